use std::cmp::Ordering;
use std::collections::VecDeque;

use crate::geometry::predicates::{Point2, orient2d};

/// Cuts a counterclockwise polygon into n - 2 triangles of positions in `outline`, each in the
/// polygon's own order; and whether they cover exactly the polygon.
///
/// Ear clipping (Meisters, "Polygons have ears", 1975) with exact signs, in O(n^2): a corner is
/// tried again only when one beside it was cut off. Polygons that touch themselves, as those
/// with bridges to their holes do, are covered. One that crosses itself is cut as far as it has
/// ears; the rest is a fan.
pub fn cut(outline: &[Point2]) -> (Vec<[usize; 3]>, bool) {
    let mut ring = Ring::of(outline);
    let mut triangles = Vec::with_capacity(outline.len() - 2);
    for rule in [Rule::Spur, Rule::Clear, Rule::Touching, Rule::Flat] {
        let mut candidates: VecDeque<usize> = ring.corners().collect();
        while ring.len > 3
            && let Some(tip) = candidates.pop_front()
        {
            if ring.has(tip) && ring.is_ear(tip, rule) {
                let ear = ring.cut_off(tip);
                triangles.push(ear);
                for beside in [ear[0], ear[2]] {
                    if ring.is_spur(beside) {
                        candidates.push_front(beside);
                    } else {
                        candidates.push_back(beside);
                    }
                }
            }
        }
    }
    let rest: Vec<usize> = ring.corners().collect();
    triangles.extend(rest[1..].windows(2).map(|edge| [rest[0], edge[0], edge[1]]));
    (triangles, rest.len() == 3)
}

/// What may be cut off, each with what is before it: spurs at once, since beside them a turn to
/// the left says nothing of the inside; then from the best to the last resort.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    /// A triangle without area: of a repeated corner, or of an edge that goes back.
    Spur,
    /// No other corner touches the new edge.
    Clear,
    /// No edge enters the triangle.
    Touching,
    /// A corner on the line between those beside it.
    Flat,
}

/// What is left of the polygon, linked both ways.
struct Ring<'a> {
    points: &'a [Point2],
    next: Vec<usize>,
    previous: Vec<usize>,
    len: usize,
}

/// The link of a corner that was cut off.
const GONE: usize = usize::MAX;

impl<'a> Ring<'a> {
    fn of(points: &'a [Point2]) -> Self {
        let len = points.len();
        let next = (1..len).chain([0]).collect();
        let previous = [len - 1].into_iter().chain(0..len - 1).collect();
        Self { points, next, previous, len }
    }

    fn has(&self, corner: usize) -> bool {
        self.next[corner] != GONE
    }

    fn corners(&self) -> impl Iterator<Item = usize> {
        (0..self.points.len()).filter(|&corner| self.has(corner))
    }

    fn ear(&self, tip: usize) -> [usize; 3] {
        [self.previous[tip], tip, self.next[tip]]
    }

    fn cut_off(&mut self, tip: usize) -> [usize; 3] {
        let ear = self.ear(tip);
        self.next[ear[0]] = ear[2];
        self.previous[ear[2]] = ear[0];
        self.next[tip] = GONE;
        self.len -= 1;
        ear
    }

    fn is_spur(&self, tip: usize) -> bool {
        let [a, b, c] = self.ear(tip).map(|corner| &self.points[corner]);
        orient2d(a, b, c) == Ordering::Equal && !is_between(a, c, b)
    }

    /// The triangle at `tip` is left of both edges there; it is inside the polygon if no edge
    /// enters it.
    fn is_ear(&self, tip: usize, rule: Rule) -> bool {
        let ear = self.ear(tip);
        let triangle = ear.map(|corner| &self.points[corner]);
        match orient2d(triangle[0], triangle[1], triangle[2]) {
            Ordering::Less => return false,
            Ordering::Equal => return rule == Rule::Flat || self.is_spur(tip),
            Ordering::Greater if rule == Rule::Spur => return false,
            Ordering::Greater => {}
        }
        let mut from = ear[2];
        while from != ear[0] {
            let to = self.next[from];
            let edge = [from, to].map(|corner| &self.points[corner]);
            let touches = rule == Rule::Clear && is_between(triangle[0], triangle[2], edge[0]);
            if touches || enters(edge, triangle) {
                return false;
            }
            from = to;
        }
        true
    }
}

/// True iff an edge has a point inside a counterclockwise triangle, its boundary left out.
fn enters([p, q]: [&Point2; 2], triangle: [&Point2; 3]) -> bool {
    let [a, b, c] = triangle;
    let apart_on = |k: usize| {
        let [low, high] = [p[k].min(q[k]), p[k].max(q[k])];
        high <= a[k].min(b[k]).min(c[k]) || low >= a[k].max(b[k]).max(c[k])
    };
    if apart_on(0) || apart_on(1) {
        return false;
    }
    // Open convex sets are apart iff the line of one of their edges separates them.
    let sides = |point| [(a, b), (b, c), (c, a)].map(|(from, to)| orient2d(from, to, point));
    let (p_sides, q_sides) = (sides(p), sides(q));
    if (0..3).any(|k| p_sides[k].is_le() && q_sides[k].is_le()) {
        return false;
    }
    if p == q {
        return true;
    }
    let across = triangle.map(|corner| orient2d(p, q, corner));
    across.contains(&Ordering::Less) && across.contains(&Ordering::Greater)
}

/// True iff `point` is on the segment from `a` to `b`, its ends left out.
fn is_between(a: &Point2, b: &Point2, point: &Point2) -> bool {
    let within = |k: usize| a[k].min(b[k]) <= point[k] && point[k] <= a[k].max(b[k]);
    point != a && point != b && within(0) && within(1) && orient2d(a, b, point) == Ordering::Equal
}
