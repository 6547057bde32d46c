//! Builds the binary tree that a wide one is collapsed from: the surface area heuristic over bins
//! (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007), the same bits on
//! any number of cores.

use super::node::WIDTH;
use crate::geometry::Triangle;

/// Below this many triangles a subtree is not worth another task.
const PARALLEL_BUILD: usize = 4096;

/// From this depth on sets are halved, so that no mesh, however it is made, gets a deep tree.
const HALVE_FROM_DEPTH: u32 = 48;

/// Sets up to this size are split by sweeping, so that as few leaves as possible come of them.
const SWEEP: usize = 3 * WIDTH;

const BINS: usize = 32;

/// Bounds along the axes of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Bounds {
    pub const NOTHING: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// Contains the triangle: rounding to nearest is monotone but may move a bound inwards, which
    /// one step out makes good.
    fn of(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle;
        let bound = |k: usize| {
            let low = a[k].min(b[k]).min(c[k]) as f32;
            let high = a[k].max(b[k]).max(c[k]) as f32;
            (low, high)
        };
        let [x, y, z] = [bound(0), bound(1), bound(2)];
        Self { low: [x.0, y.0, z.0].map(f32::next_down), high: [x.1, y.1, z.1].map(f32::next_up) }
    }

    #[inline]
    pub fn with(&self, other: &Self) -> Self {
        let mut both = *self;
        for k in 0..3 {
            both.low[k] = both.low[k].min(other.low[k]);
            both.high[k] = both.high[k].max(other.high[k]);
        }
        both
    }

    /// Half of the surface.
    #[inline]
    pub fn area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|k| (self.high[k] - self.low[k]).max(0.0));
        x * y + y * z + z * x
    }
}

/// A node of the binary tree: the `count` triangles from `first` in the order of the leaves.
#[derive(Clone, Copy, Debug)]
pub struct BinaryNode {
    pub bounds: Bounds,
    pub first: u32,
    pub count: u32,
    /// Of the left child among all nodes, and of the right child; none for a leaf.
    pub children: Option<[u32; 2]>,
}

const NOWHERE: BinaryNode =
    BinaryNode { bounds: Bounds::NOTHING, first: 0, count: 0, children: None };

/// A triangle on its way to its leaf.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    id: u32,
}

impl Item {
    /// Twice the middle of the box.
    #[inline]
    fn middle(&self, axis: usize) -> f32 {
        self.bounds.low[axis] + self.bounds.high[axis]
    }
}

/// The nodes, the root first, and the triangles' numbers in the order of their leaves. Not every
/// node is in use.
pub fn build_binary(triangles: &[Triangle]) -> (Vec<BinaryNode>, Vec<u32>) {
    let mut items: Vec<Item> = triangles
        .iter()
        .enumerate()
        .map(|(id, triangle)| Item { bounds: Bounds::of(triangle), id: id as u32 })
        .collect();
    let mut nodes = vec![NOWHERE; 2 * items.len() - 1];
    let mut room = items.clone();
    subtree(&mut items, &mut room, &mut nodes, Place { node: 0, first: 0, depth: 0 });
    (nodes, items.into_iter().map(|item| item.id).collect())
}

#[derive(Clone, Copy)]
struct Place {
    node: u32,
    first: u32,
    depth: u32,
}

fn subtree(items: &mut [Item], room: &mut [Item], nodes: &mut [BinaryNode], at: Place) {
    let count = items.len();
    let bounds = items.iter().fold(Bounds::NOTHING, |all, item| all.with(&item.bounds));
    nodes[0] = BinaryNode { bounds, first: at.first, count: count as u32, children: None };
    if count <= WIDTH {
        return;
    }
    let split = if at.depth >= HALVE_FROM_DEPTH {
        None
    } else if count <= SWEEP {
        sweep(items, room)
    } else {
        binned(items, room)
    };
    let left = split.unwrap_or_else(|| halve(items));
    // The left subtree has room for as many nodes as it could need.
    let right_at = 2 * left;
    nodes[0].children = Some([at.node + 1, at.node + right_at as u32]);
    let (left_nodes, right_nodes) = nodes[1..].split_at_mut(right_at - 1);
    let (left_items, right_items) = items.split_at_mut(left);
    let (left_room, right_room) = room.split_at_mut(left);
    let depth = at.depth + 1;
    let left_place = Place { node: at.node + 1, first: at.first, depth };
    let right_place =
        Place { node: at.node + right_at as u32, first: at.first + left as u32, depth };
    let mut build_left = || subtree(left_items, left_room, left_nodes, left_place);
    let mut build_right = || subtree(right_items, right_room, right_nodes, right_place);
    if count < PARALLEL_BUILD {
        build_left();
        build_right();
    } else {
        rayon::join(build_left, build_right);
    }
}

/// Along the longest axis of the boxes' middles.
fn halve(items: &mut [Item]) -> usize {
    let (low, high) = middles(items);
    let axis = (0..3).max_by(|&a, &b| (high[a] - low[a]).total_cmp(&(high[b] - low[b])));
    let axis = axis.unwrap_or(0);
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| order(a, b, axis));
    half
}

fn order(a: &Item, b: &Item, axis: usize) -> std::cmp::Ordering {
    a.middle(axis).total_cmp(&b.middle(axis)).then(a.id.cmp(&b.id))
}

fn middles(items: &[Item]) -> ([f32; 3], [f32; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in items {
        for k in 0..3 {
            let middle = item.middle(k);
            low[k] = low[k].min(middle);
            high[k] = high[k].max(middle);
        }
    }
    (low, high)
}

/// Orders the items by the best split into as few leaves as there can be; its left part's length.
fn sweep(items: &mut [Item], room: &mut [Item]) -> Option<usize> {
    let count = items.len();
    let leaves = count.div_ceil(WIDTH);
    let mut best: Option<(f32, usize)> = None;
    let mut sorted = [items[0]; SWEEP];
    let sorted = &mut sorted[..count];
    for axis in 0..3 {
        sorted.copy_from_slice(items);
        sorted.sort_unstable_by(|a, b| order(a, b, axis));
        let mut after = [0.0; SWEEP];
        let mut bounds = Bounds::NOTHING;
        for i in (1..count).rev() {
            bounds = bounds.with(&sorted[i].bounds);
            after[i] = bounds.area();
        }
        bounds = Bounds::NOTHING;
        for left in 1..count {
            bounds = bounds.with(&sorted[left - 1].bounds);
            if left.div_ceil(WIDTH) + (count - left).div_ceil(WIDTH) > leaves {
                continue;
            }
            let score = left as f32 * bounds.area() + (count - left) as f32 * after[left];
            if best.is_none_or(|(least, _)| score < least) {
                best = Some((score, left));
                room[..count].copy_from_slice(sorted);
            }
        }
    }
    let (_, left) = best?;
    items.copy_from_slice(&room[..count]);
    Some(left)
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

/// Orders the items by the best split between bins, keeping their order within both parts; the
/// left part's length. `None` if all boxes have one middle.
fn binned(items: &mut [Item], room: &mut [Item]) -> Option<usize> {
    let (low, high) = middles(items);
    let scale = [0, 1, 2].map(|k| {
        let length = high[k] - low[k];
        // The last middle falls into the last bin.
        if length > f32::MIN_POSITIVE { BINS as f32 * (1.0 - 1e-6) / length } else { 0.0 }
    });
    let bin_of = |item: &Item, k: usize| ((item.middle(k) - low[k]) * scale[k]) as usize;
    let mut bins = [[Bin { bounds: Bounds::NOTHING, count: 0 }; BINS]; 3];
    for item in items.iter() {
        for (k, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[bin_of(item, k).min(BINS - 1)];
            bin.bounds = bin.bounds.with(&item.bounds);
            bin.count += 1;
        }
    }
    let (axis, last, left) = (0..3)
        .filter(|&axis| scale[axis] > 0.0)
        .filter_map(|axis| {
            best_between(&bins[axis]).map(|(score, last, left)| (score, axis, last, left))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, axis, last, left)| (axis, last, left))?;
    let (mut to_left, mut to_right) = (0, left);
    for item in items.iter() {
        let to =
            if bin_of(item, axis).min(BINS - 1) <= last { &mut to_left } else { &mut to_right };
        room[*to] = *item;
        *to += 1;
    }
    items.copy_from_slice(room);
    Some(left)
}

/// The least cost, the last bin of the left part, and how many items that part has.
fn best_between(bins: &[Bin; BINS]) -> Option<(f32, usize, usize)> {
    let all: usize = bins.iter().map(|bin| bin.count).sum();
    let mut after = [0.0; BINS];
    let mut bounds = Bounds::NOTHING;
    for i in (1..BINS).rev() {
        bounds = bounds.with(&bins[i].bounds);
        after[i] = bounds.area();
    }
    let (mut bounds, mut left) = (Bounds::NOTHING, 0);
    let mut best: Option<(f32, usize, usize)> = None;
    for last in 0..BINS - 1 {
        bounds = bounds.with(&bins[last].bounds);
        left += bins[last].count;
        if left == 0 || left == all {
            continue;
        }
        let score = left as f32 * bounds.area() + (all - left) as f32 * after[last + 1];
        if best.is_none_or(|(least, ..)| score < least) {
            best = Some((score, last, left));
        }
    }
    best
}
