//! Parts of a mesh, as the numbers of their triangles.

use serde::{Deserialize, Serialize};

/// Triangles by number: ranges in ascending order, none of which meets another.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[u32; 2]>", into = "Vec<[u32; 2]>")]
pub struct Ranges(Vec<[u32; 2]>);

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotRanges {
    #[error("[{0}, {1}] is no range of triangles: write the first and the last, the smaller first")]
    Reversed(u32, u32),
    #[error("[{0}, {1}] has triangles of another range: each may be in one only")]
    Overlap(u32, u32),
    #[error("there is no range of triangles")]
    Empty,
}

impl Ranges {
    /// Each the first and the last number, in any order.
    pub fn new(mut ranges: Vec<[u32; 2]>) -> Result<Self, NotRanges> {
        if ranges.is_empty() {
            return Err(NotRanges::Empty);
        }
        ranges.sort_unstable();
        if let Some(&[first, last]) = ranges.iter().find(|[first, last]| first > last) {
            return Err(NotRanges::Reversed(first, last));
        }
        match ranges.windows(2).find(|pair| pair[1][0] <= pair[0][1]) {
            Some(pair) => Err(NotRanges::Overlap(pair[1][0], pair[1][1])),
            None => Ok(Self(ranges)),
        }
    }

    /// Of numbers in ascending order; `None` if there are none.
    pub fn of(numbers: impl IntoIterator<Item = u32>) -> Option<Self> {
        let mut ranges: Vec<[u32; 2]> = Vec::new();
        for number in numbers {
            match ranges.last_mut() {
                Some([_, last]) if *last + 1 == number => *last = number,
                _ => ranges.push([number, number]),
            }
        }
        Self::new(ranges).ok()
    }

    pub fn contains(&self, triangle: u32) -> bool {
        let after = self.0.partition_point(|[first, _]| *first <= triangle);
        after > 0 && triangle <= self.0[after - 1][1]
    }

    pub fn meets(&self, other: &Self) -> bool {
        other
            .0
            .iter()
            .any(|&[first, last]| self.0.iter().any(|&[from, to]| first <= to && from <= last))
    }

    pub fn last(&self) -> u32 {
        self.0.last().map_or(0, |[_, last]| *last)
    }

    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.iter().flat_map(|&[first, last]| first..=last)
    }
}

impl TryFrom<Vec<[u32; 2]>> for Ranges {
    type Error = NotRanges;

    fn try_from(ranges: Vec<[u32; 2]>) -> Result<Self, NotRanges> {
        Self::new(ranges)
    }
}

impl From<Ranges> for Vec<[u32; 2]> {
    fn from(ranges: Ranges) -> Self {
        ranges.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_what_lies_between_their_ends() {
        let ranges = Ranges::new(vec![[7, 9], [2, 2]]).unwrap();
        let held: Vec<u32> = (0..12).filter(|&n| ranges.contains(n)).collect();
        assert_eq!(held, [2, 7, 8, 9]);
        assert_eq!(ranges.iter().collect::<Vec<_>>(), held);
        assert_eq!(ranges.last(), 9);
        assert_eq!(Ranges::of(held), Some(ranges));
        assert_eq!(Ranges::of([]), None);
    }

    #[test]
    fn what_are_no_ranges_is_refused() {
        assert_eq!(Ranges::new(vec![]), Err(NotRanges::Empty));
        assert_eq!(Ranges::new(vec![[3, 2]]), Err(NotRanges::Reversed(3, 2)));
        assert_eq!(Ranges::new(vec![[5, 9], [0, 5]]), Err(NotRanges::Overlap(5, 9)));
    }
}
