//! Branch and bound in 64 bits, over trees of any kind.

use super::gap::Gap;
use super::search::Search;
use crate::tree::placement::Placement;

/// A tree of boxes, each with a number.
pub trait Hierarchy {
    type Box: Gap;
    /// What to start from.
    fn top(&self) -> Step;
    fn boxed(&self, at: u32) -> Self::Box;
    fn below(&self, at: u32) -> Step;
}

/// What is below a box.
#[derive(Clone, Copy)]
pub enum Step {
    /// `count` boxes, `step` numbers from each other.
    Open { first: u32, step: u32, count: u32 },
    /// Triangles by rank.
    Triangles { first: u32, count: u32 },
}

/// Two boxes whose children, or triangles, have not been looked at.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    bound_m: f64,
    boxes: [u32; 2],
}

/// Of boxes that are opened together the nearest come first: what waits grows with the depth of the
/// trees.
pub fn descend<H: Hierarchy>(
    trees: [H; 2],
    placement: &Placement,
    waiting: &mut Vec<Waiting>,
    search: &mut Search<'_>,
) {
    waiting.clear();
    let mut descend = Descend { trees, placement, waiting, search };
    let [fixed, moving] = descend.trees.each_ref().map(|tree| numbers(tree.top()));
    descend.add(fixed.flat_map(|a| moving.clone().map(move |b| [a, b])));
    while let Some(Waiting { bound_m, boxes }) = descend.waiting.pop() {
        if bound_m <= descend.search.limit_m() {
            descend.look(boxes);
        }
    }
}

struct Descend<'d, 'a, H> {
    trees: [H; 2],
    placement: &'d Placement,
    waiting: &'d mut Vec<Waiting>,
    search: &'d mut Search<'a>,
}

impl<H: Hierarchy> Descend<'_, '_, H> {
    fn look(&mut self, [a, b]: [u32; 2]) {
        let [fixed, moving] = &self.trees;
        match (fixed.below(a), moving.below(b)) {
            (below_a @ Step::Triangles { .. }, below_b @ Step::Triangles { .. }) => {
                for a in numbers(below_a) {
                    for b in numbers(below_b) {
                        self.search.counts.triangles += 1;
                        self.search.consider(a, b);
                    }
                }
            }
            (below @ Step::Open { .. }, other)
                if matches!(other, Step::Triangles { .. })
                    || self.placement.first_is_larger(&fixed.boxed(a), &moving.boxed(b)) =>
            {
                self.add(numbers(below).map(|a| [a, b]));
            }
            (_, below) => self.add(numbers(below).map(|b| [a, b])),
        }
    }

    fn add(&mut self, pairs: impl Iterator<Item = [u32; 2]>) {
        let Self { trees: [fixed, moving], placement, waiting, search } = self;
        let (limit_m, from) = (search.limit_m(), waiting.len());
        for boxes @ [a, b] in pairs {
            search.counts.boxes += 1;
            let bound_m = fixed.boxed(a).gap(&moving.boxed(b), placement);
            if bound_m <= limit_m {
                waiting.push(Waiting { bound_m, boxes });
            }
        }
        waiting[from..].sort_unstable_by(|a, b| b.bound_m.total_cmp(&a.bound_m));
    }
}

fn numbers(step: Step) -> impl Iterator<Item = u32> + Clone {
    let (first, step, count) = match step {
        Step::Open { first, step, count } => (first, step, count),
        Step::Triangles { first, count } => (first, 1, count),
    };
    (0..count).map(move |i| first + i * step)
}
