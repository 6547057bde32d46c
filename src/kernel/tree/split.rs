//! The paper's split of a set of triangles in two (section 6.2), with a weight by counts.
//!
//! On each axis of the box the triangles are sorted by their largest projected vertex, and for
//! every prefix the relative lengths of the projections of both parts are added; the least sum
//! wins. Taken literally the sum is least when one part is almost nothing, so it peels off a
//! triangle or two a level and the tree of a real vehicle gets thousands of levels deep. Here each
//! part's length is weighted by its share of the triangles. Large sets are not sorted but put into
//! bins.

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

/// Sets of this size are not sorted but sweep over bins: between two of them lies a split that is
/// nearly as good as the best.
const BINNED_FROM: usize = 256;

const BINS: usize = 128;

/// Above what any useful split scores; also keeps rounding from choosing among equals.
const USEFUL: f64 = 1.0 - 1e-6;

/// Writes positions into `room.order` so that the first part comes first; returns its length,
/// which is at least 1 and at most one less than all. `None` where no split is better than none:
/// then the order is arbitrary.
pub fn weighted_sweep(intervals: &[Interval], room: &mut SweepRoom<'_>) -> Option<usize> {
    if intervals.len() >= BINNED_FROM
        && let Some(count) = binned_sweep(intervals, room)
    {
        return Some(count);
    }
    let mut best = None;
    let mut least = USEFUL;
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
    sorted.sort_unstable();
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
        lowest = least(lowest, low(i));
        lowest_after[i] = lowest;
    }
    let length = high(n - 1) - lowest;
    if length.is_nan() || length <= 0.0 {
        return None;
    }
    let (mut prefix_low, top) = (f32::INFINITY, high(n - 1));
    let mut best: Option<(f64, usize)> = None;
    for (count, &lowest) in (1..n).zip(&lowest_after[1..]) {
        prefix_low = least(prefix_low, low(count - 1));
        let score = weighted(count, high(count - 1) - prefix_low, n - count, top - lowest);
        let better = best.is_none_or(|(least, at)| {
            score < least || (score == least && n.abs_diff(2 * count) < n.abs_diff(2 * at))
        });
        if better {
            best = Some((score, count));
        }
    }
    let whole = n as f64 * f64::from(length);
    best.map(|(score, count)| (score / whole, count))
}

/// Both parts' lengths, each times its number of triangles.
#[inline(always)]
fn weighted(count: usize, length: f32, other_count: usize, other_length: f32) -> f64 {
    count as f64 * f64::from(length) + other_count as f64 * f64::from(other_length)
}

/// Of numbers; unlike [`f32::min`] this is one instruction.
#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn most(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Triangles by their largest projected vertex.
#[derive(Clone, Copy)]
struct Bin {
    low: f32,
    high: f32,
    count: usize,
}

const EMPTY: Bin = Bin { low: f32::INFINITY, high: f32::NEG_INFINITY, count: 0 };

/// [`weighted_sweep`] that splits between bins only. Both parts keep their order.
fn binned_sweep(intervals: &[Interval], room: &mut SweepRoom<'_>) -> Option<usize> {
    let (mut from, mut to) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for interval in intervals {
        for axis in 0..3 {
            let high = interval.high[axis];
            from[axis] = least(from[axis], high);
            to[axis] = most(to[axis], high);
        }
    }
    let mut scale = [0.0; 3];
    for axis in 0..3 {
        let length = to[axis] - from[axis];
        if length > f32::MIN_POSITIVE {
            scale[axis] = BINS as f32 * (1.0 - 1e-6) / length;
        }
    }
    let bin_of = |interval: &Interval, axis: usize| {
        // By way of 32 bits, which takes fewer instructions.
        (((interval.high[axis] - from[axis]) * scale[axis]) as i32 as usize).min(BINS - 1)
    };
    let mut bins = [[EMPTY; BINS]; 3];
    for interval in intervals {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[bin_of(interval, axis)];
            bin.low = least(bin.low, interval.low[axis]);
            bin.high = most(bin.high, interval.high[axis]);
            bin.count += 1;
        }
    }
    let splits = (0..3).filter_map(|axis| {
        sweep_bins(&bins[axis], intervals.len()).map(|(score, last)| (score, axis, last))
    });
    let best = splits.min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, axis, last) = best.filter(|&(score, ..)| score < USEFUL)?;
    let left: usize = bins[axis][..=last].iter().map(|bin| bin.count).sum();
    let (mut to_left, mut to_right) = (0, left);
    for (i, interval) in intervals.iter().enumerate() {
        let goes_left = bin_of(interval, axis) <= last;
        room.order[if goes_left { to_left } else { to_right }] = i as u32;
        to_left += usize::from(goes_left);
        to_right += usize::from(!goes_left);
    }
    Some(left)
}

/// The least weighted sum of relative lengths and the last bin of the first part.
fn sweep_bins(bins: &[Bin; BINS], n: usize) -> Option<(f64, usize)> {
    let mut lowest_after = [f32::INFINITY; BINS + 1];
    for (i, bin) in bins.iter().enumerate().rev() {
        lowest_after[i] = least(lowest_after[i + 1], bin.low);
    }
    let top = bins.iter().map(|bin| bin.high).fold(f32::NEG_INFINITY, f32::max);
    let length = top - lowest_after[0];
    if length.is_nan() || length <= 0.0 {
        return None;
    }
    let (mut prefix_low, mut count) = (f32::INFINITY, 0);
    let mut best: Option<(f64, usize)> = None;
    for (last, bin) in bins.iter().enumerate().filter(|(_, bin)| bin.count > 0) {
        count += bin.count;
        if count == n {
            break;
        }
        prefix_low = least(prefix_low, bin.low);
        let rest = top - lowest_after[last + 1];
        let score = weighted(count, bin.high - prefix_low, n - count, rest);
        if best.is_none_or(|(least, _)| score < least) {
            best = Some((score, last));
        }
    }
    let whole = n as f64 * f64::from(length);
    best.map(|(score, last)| (score / whole, last))
}
