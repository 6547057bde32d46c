//! Builds the binary tree that a wide one is collapsed from: the surface area heuristic over bins
//! (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007), the same bits on
//! any number of cores.

use rayon::prelude::*;

use super::node::WIDTH;
use crate::geometry::{Point, Triangle};

/// Below this many triangles a subtree is not worth another task.
const PARALLEL_BUILD: usize = 4096;

/// From this depth on sets are halved, so that no mesh, however it is made, gets a deep tree.
const HALVE_FROM_DEPTH: u32 = 48;

/// Sets up to this size are split by sweeping, so that as few leaves as possible come of them.
const SWEEP: usize = 3 * WIDTH;

const BINS: usize = 32;

/// Bounds along the axes of the mesh. Of each corner the fourth number means nothing here: with it
/// a corner is a vector, and a union two instructions.
#[repr(align(16))]
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    pub low: [f32; 4],
    pub high: [f32; 4],
}

impl Bounds {
    pub const NOTHING: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    /// Contains the triangle: rounding to nearest is monotone but may move a bound inwards, which
    /// one step out makes good.
    fn of([a, b, c]: &Triangle) -> Self {
        let low = [0, 1, 2].map(|k| a[k].min(b[k]).min(c[k]));
        let high = [0, 1, 2].map(|k| a[k].max(b[k]).max(c[k]));
        Self::rounded_outwards(low, high)
    }

    /// The smallest that contain these.
    pub fn rounded_outwards(low: Point, high: Point) -> Self {
        let mut all = Self { low: [0.0; 4], high: [0.0; 4] };
        for k in 0..3 {
            all.low[k] = (low[k] as f32).next_down();
            all.high[k] = (high[k] as f32).next_up();
        }
        all
    }

    pub fn around(center: Point, half: Point) -> Self {
        let [low, high] = [-1.0, 1.0].map(|sign| [0, 1, 2].map(|k| center[k] + sign * half[k]));
        Self::rounded_outwards(low, high)
    }

    #[inline(always)]
    pub fn with(&self, other: &Self) -> Self {
        Self { low: least(self.low, other.low), high: most(self.high, other.high) }
    }

    /// Half of the surface.
    #[inline]
    pub fn area(&self) -> f32 {
        let length = |k: usize| (self.high[k] - self.low[k]).max(0.0);
        let (x, y, z) = (length(0), length(1), length(2));
        x * y + y * z + z * x
    }
}

/// Of equal numbers the first, so that the sign of a zero does not depend on how sets are grouped.
#[inline(always)]
fn least(mut a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    for k in 0..4 {
        a[k] = if b[k] < a[k] { b[k] } else { a[k] };
    }
    a
}

#[inline(always)]
fn most(mut a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    for k in 0..4 {
        a[k] = if b[k] > a[k] { b[k] } else { a[k] };
    }
    a
}

/// A node of the binary tree: the `count` triangles from `first` in the order of the leaves.
#[derive(Clone, Copy, Debug)]
pub struct BinaryNode {
    pub bounds: Bounds,
    pub first: u32,
    pub count: u32,
    /// How many nodes further the right child is; the left one is next. 0 for a leaf.
    pub right: u32,
}

impl BinaryNode {
    pub const NOWHERE: Self = Self { bounds: Bounds::NOTHING, first: 0, count: 0, right: 0 };
}

/// A triangle on its way to its leaf: its bounds, and its number as the bits of the lower corner's
/// fourth number. (A mesh has fewer than 2^30 triangles, so that this is never NaN.)
#[derive(Clone, Copy)]
struct Item(Bounds);

impl Item {
    fn new(id: u32, triangle: &Triangle) -> Self {
        let mut bounds = Bounds::of(triangle);
        bounds.low[3] = f32::from_bits(id);
        Self(bounds)
    }

    #[inline(always)]
    fn id(&self) -> u32 {
        self.0.low[3].to_bits()
    }

    /// Twice the middle of the box.
    #[inline(always)]
    fn middle(&self) -> [f32; 4] {
        let mut sum = self.0.low;
        for (sum, high) in sum.iter_mut().zip(self.0.high) {
            *sum += high;
        }
        sum
    }
}

/// The nodes, depth first, and the triangles' numbers in the order of their leaves.
pub fn build_binary(triangles: &[Triangle]) -> (Vec<BinaryNode>, Vec<u32>) {
    let item = |(id, triangle): (usize, &Triangle)| Item::new(id as u32, triangle);
    let mut items: Vec<Item> = triangles.par_iter().enumerate().map(item).collect();
    let mut room = items.clone();
    let mut order = vec![0; items.len()];
    let mut nodes = Vec::new();
    let set = Set { items: &mut items, room: &mut room, order: &mut order, first: 0, depth: 0 };
    set.subtree(&mut nodes);
    (nodes, order)
}

/// What a subtree is made of, with room for as many items and for their order.
struct Set<'a> {
    items: &'a mut [Item],
    room: &'a mut [Item],
    order: &'a mut [u32],
    /// Rank of its first triangle.
    first: u32,
    depth: u32,
}

impl<'a> Set<'a> {
    fn subtree(mut self, nodes: &mut Vec<BinaryNode>) {
        let count = self.items.len();
        let bounds = self.items.iter().fold(Bounds::NOTHING, |all, item| all.with(&item.0));
        let at = nodes.len();
        nodes.push(BinaryNode { bounds, first: self.first, count: count as u32, right: 0 });
        if count <= WIDTH {
            for (id, item) in self.order.iter_mut().zip(&*self.items) {
                *id = item.id();
            }
            return;
        }
        let left = self.split();
        let (left, right) = self.split_at(left);
        if count < PARALLEL_BUILD {
            left.subtree(nodes);
            nodes[at].right = (nodes.len() - at) as u32;
            right.subtree(nodes);
        } else {
            let mut of_right = Vec::new();
            rayon::join(|| left.subtree(nodes), || right.subtree(&mut of_right));
            nodes[at].right = (nodes.len() - at) as u32;
            nodes.append(&mut of_right);
        }
    }

    /// Orders the items so that the left part comes first; its length.
    fn split(&mut self) -> usize {
        let left = if self.depth >= HALVE_FROM_DEPTH {
            None
        } else if self.items.len() <= SWEEP {
            sweep(self.items, self.room)
        } else {
            binned(self.items, self.room)
        };
        if left.is_some() {
            std::mem::swap(&mut self.items, &mut self.room);
        }
        left.unwrap_or_else(|| halve(self.items))
    }

    fn split_at(self, left: usize) -> (Self, Self) {
        let (items, items_right) = self.items.split_at_mut(left);
        let (room, room_right) = self.room.split_at_mut(left);
        let (order, order_right) = self.order.split_at_mut(left);
        let (first, depth) = (self.first, self.depth + 1);
        let right = Self {
            items: items_right,
            room: room_right,
            order: order_right,
            first: first + left as u32,
            depth,
        };
        (Self { items, room, order, first, depth }, right)
    }
}

/// Along the longest axis of the boxes' middles.
fn halve(items: &mut [Item]) -> usize {
    let (low, high) = middles(items);
    let axis = (0..3).max_by(|&a, &b| (high[a] - low[a]).total_cmp(&(high[b] - low[b])));
    let axis = axis.unwrap_or(0);
    let half = items.len() / 2;
    items.select_nth_unstable_by_key(half, |item| (ordered_bits(item.middle()[axis]), item.id()));
    half
}

/// Bits that order as the numbers do.
fn ordered_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

fn middles(items: &[Item]) -> ([f32; 4], [f32; 4]) {
    let nothing = (Bounds::NOTHING.low, Bounds::NOTHING.high);
    items.iter().fold(nothing, |(low, high), item| {
        let middle = item.middle();
        (least(low, middle), most(high, middle))
    })
}

/// Puts the items into `room` in the order of the best split into as few leaves as there can be;
/// its left part's length.
fn sweep(items: &[Item], room: &mut [Item]) -> Option<usize> {
    let count = items.len();
    let leaves = count.div_ceil(WIDTH);
    let mut best: Option<(f32, usize)> = None;
    let (mut sorted, mut chosen) = ([0_u128; SWEEP], [0_u128; SWEEP]);
    let (sorted, chosen) = (&mut sorted[..count], &mut chosen[..count]);
    let position = |key: u128| key as u32 as usize;
    for axis in 0..3 {
        // Middle, then number; the position comes along.
        for (at, (key, item)) in sorted.iter_mut().zip(items).enumerate() {
            let middle = ordered_bits(item.middle()[axis]);
            *key = u128::from(middle) << 64 | u128::from(item.id()) << 32 | at as u128;
        }
        sorted.sort_unstable();
        let mut after = [0.0; SWEEP];
        let mut bounds = Bounds::NOTHING;
        for i in (1..count).rev() {
            bounds = bounds.with(&items[position(sorted[i])].0);
            after[i] = bounds.area();
        }
        bounds = Bounds::NOTHING;
        let mut better = false;
        for left in 1..count {
            bounds = bounds.with(&items[position(sorted[left - 1])].0);
            if left.div_ceil(WIDTH) + (count - left).div_ceil(WIDTH) > leaves {
                continue;
            }
            let score = left as f32 * bounds.area() + (count - left) as f32 * after[left];
            if best.is_none_or(|(least, _)| score < least) {
                best = Some((score, left));
                better = true;
            }
        }
        if better {
            chosen.copy_from_slice(sorted);
        }
    }
    for (slot, &key) in room.iter_mut().zip(&*chosen) {
        *slot = items[position(key)];
    }
    best.map(|(_, left)| left)
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

struct Binning {
    low: [f32; 4],
    scale: [f32; 4],
}

impl Binning {
    #[inline(always)]
    fn number(&self, middle: [f32; 4], axis: usize) -> usize {
        let at = (middle[axis] - self.low[axis]) * self.scale[axis];
        // By way of 32 bits, which takes fewer instructions.
        (at as i32 as usize).min(BINS - 1)
    }
}

/// Puts the items into `room`, ordered by the best split between bins and as they were within both
/// parts; the left part's length. `None` if all boxes have one middle.
fn binned(items: &[Item], room: &mut [Item]) -> Option<usize> {
    let (low, high) = middles(items);
    let mut scale = [0.0; 4];
    for k in 0..3 {
        let length = high[k] - low[k];
        // The last middle falls into the last bin.
        if length > f32::MIN_POSITIVE {
            scale[k] = BINS as f32 * (1.0 - 1e-6) / length;
        }
    }
    let binning = Binning { low, scale };
    let mut bins = [[Bin { bounds: Bounds::NOTHING, count: 0 }; BINS]; 3];
    for item in items {
        let middle = item.middle();
        for (k, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[binning.number(middle, k)];
            bin.bounds = bin.bounds.with(&item.0);
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
    // Without a branch, which would be a coin's toss.
    let (mut to_left, mut to_right) = (0, left);
    for item in items {
        let goes_left = binning.number(item.middle(), axis) <= last;
        room[if goes_left { to_left } else { to_right }] = *item;
        to_left += usize::from(goes_left);
        to_right += usize::from(!goes_left);
    }
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
