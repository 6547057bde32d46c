//! The paper's split of a set of triangles in two (section 6.2), with a weight by counts.
//!
//! On each axis of the box the triangles are sorted by their largest projected vertex, and for
//! every prefix the relative lengths of the projections of both parts are added; the least sum
//! wins. Taken literally the sum is least when one part is almost nothing, so it peels off a
//! triangle or two a level and the tree of a real vehicle gets thousands of levels deep. Here each
//! part's length is weighted by its share of the triangles.

use rayon::slice::ParallelSliceMut;

/// Projection of a triangle on the three axes of its node's box.
#[derive(Clone, Copy, Debug, Default)]
pub struct Interval {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

/// Room for the sweep, as long as the set of triangles.
pub struct SweepRoom<'a> {
    /// Largest projected vertex in the upper half, position in the lower.
    pub sorted: &'a mut [u64],
    /// Lowest projected vertex of this triangle and all after it.
    pub lowest_after: &'a mut [f32],
    /// The best order so far.
    pub order: &'a mut [u32],
}

const PARALLEL_SORT: usize = 1 << 15;

/// Writes positions into `room.order` so that the first part comes first; returns its length,
/// which is at least 1 and at most one less than all. `None` where no split is better than none:
/// then the order is arbitrary.
pub fn weighted_sweep(intervals: &[Interval], room: &mut SweepRoom<'_>) -> Option<usize> {
    let mut best = None;
    // Below what any useful split gains; also keeps rounding from choosing among equals.
    let mut least = 1.0 - 1e-6;
    for axis in 0..3 {
        sort_by_high(intervals, axis, room.sorted);
        if let Some((score, count)) = sweep(intervals, axis, room.sorted, room.lowest_after)
            && score < least
        {
            least = score;
            best = Some(count);
            for (slot, &key) in room.order.iter_mut().zip(room.sorted.iter()) {
                *slot = position(key) as u32;
            }
        }
    }
    best
}

/// Puts the half with the smaller projections on the longest axis first.
pub fn median_split(intervals: &[Interval], room: &mut SweepRoom<'_>) -> usize {
    let length = |axis: usize| {
        let low = intervals.iter().map(|i| i.low[axis]).fold(f32::INFINITY, f32::min);
        let high = intervals.iter().map(|i| i.high[axis]).fold(f32::NEG_INFINITY, f32::max);
        high - low
    };
    let axis = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
    sort_by_high(intervals, axis, room.sorted);
    for (slot, &key) in room.order.iter_mut().zip(room.sorted.iter()) {
        *slot = position(key) as u32;
    }
    intervals.len() / 2
}

fn position(key: u64) -> usize {
    (key & 0xffff_ffff) as usize
}

/// Bits that order as the numbers do.
fn ordered_bits(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

fn sort_by_high(intervals: &[Interval], axis: usize, sorted: &mut [u64]) {
    for (i, (slot, interval)) in sorted.iter_mut().zip(intervals).enumerate() {
        // Adding zero makes -0.0 and 0.0 one key.
        *slot = u64::from(ordered_bits(interval.high[axis] + 0.0)) << 32 | i as u64;
    }
    if sorted.len() < PARALLEL_SORT {
        sorted.sort_unstable();
    } else {
        sorted.par_sort_unstable();
    }
}

/// The least weighted sum of relative lengths and the length of the prefix that has it; among
/// equals the most balanced. `None` where the projection has no length.
fn sweep(
    intervals: &[Interval],
    axis: usize,
    sorted: &[u64],
    lowest_after: &mut [f32],
) -> Option<(f64, usize)> {
    let n = sorted.len();
    let low = |i: usize| intervals[position(sorted[i])].low[axis];
    let high = |i: usize| intervals[position(sorted[i])].high[axis];
    let mut lowest = f32::INFINITY;
    for i in (0..n).rev() {
        lowest = lowest.min(low(i));
        lowest_after[i] = lowest;
    }
    let length = high(n - 1) - lowest;
    if length.is_nan() || length <= 0.0 {
        return None;
    }
    let whole = n as f64 * f64::from(length);
    let (mut prefix_low, top) = (f32::INFINITY, high(n - 1));
    let mut best: Option<(f64, usize)> = None;
    for (count, &lowest) in (1..n).zip(&lowest_after[1..]) {
        prefix_low = prefix_low.min(low(count - 1));
        let first = f64::from(high(count - 1) - prefix_low);
        let rest = f64::from(top - lowest);
        let score = (count as f64 * first + (n - count) as f64 * rest) / whole;
        let better = best.is_none_or(|(least, at)| {
            score < least || (score == least && n.abs_diff(2 * count) < n.abs_diff(2 * at))
        });
        if better {
            best = Some((score, count));
        }
    }
    best
}
