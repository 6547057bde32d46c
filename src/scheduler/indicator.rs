//! OBB tree distributed nodes indicator (section 6.4.5 and table 1 of the paper).

use super::bits::Bits;
use crate::tree::roots::DistributedRoot;

/// The bounding volume vector of one scenario and one tree: per distributed root the number of
/// triangles below it, or 0 where it takes no part. Only the others are held.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TreeIndicator {
    /// (number of the root, triangles below it), ascending.
    taking_part: Vec<(u32, u32)>,
}

impl TreeIndicator {
    /// From the numbers of the roots that take part, in any order, repeated or not.
    pub fn new(numbers: impl Iterator<Item = u32>, roots: &[DistributedRoot]) -> Self {
        let mut numbers: Vec<u32> = numbers.collect();
        numbers.sort_unstable();
        numbers.dedup();
        let with_triangles = |number: u32| (number, roots[number as usize].triangles);
        Self::of(numbers.into_iter().map(with_triangles))
    }

    /// From (number of the root, triangles below it), ascending.
    pub fn of(taking_part: impl Iterator<Item = (u32, u32)>) -> Self {
        let taking_part: Vec<_> = taking_part.collect();
        debug_assert!(taking_part.is_sorted_by(|a, b| a.0 < b.0));
        Self { taking_part }
    }

    /// Of the roots that take part, ascending.
    pub fn numbers(&self) -> impl ExactSizeIterator<Item = u32> {
        self.taking_part.iter().map(|&(number, _)| number)
    }

    /// The score of a client that has them all.
    pub fn triangles(&self) -> u64 {
        self.taking_part.iter().map(|&(_, triangles)| u64::from(triangles)).sum()
    }
}

/// Which distributed roots of one tree a client has been given: 1 or else 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ClientIndicator {
    given: Bits,
}

impl ClientIndicator {
    /// The sum of the products of the two vectors.
    pub fn score(&self, scenario: &TreeIndicator) -> u64 {
        if self.given.is_roomless() {
            return 0;
        }
        // Multiplied rather than skipped: which they have nobody can foresee.
        let product = |&(number, n): &(u32, u32)| self.given.bit(number as usize) * u64::from(n);
        scenario.taking_part.iter().map(product).sum()
    }

    pub fn has(&self, number: u32) -> bool {
        self.given.bit(number as usize) == 1
    }

    /// It was given a whole tree in one piece.
    pub fn give_whole(&mut self) {
        self.give_all(1);
    }

    /// It has the tree, which is cut at so many roots.
    pub fn give_all(&mut self, roots: usize) {
        self.given = Bits::below(roots);
        for number in 0..roots {
            self.given.insert(number);
        }
    }

    /// Switches back to 0 what it was not given after all.
    pub fn take_back(&mut self, number: u32) {
        self.given.remove(number as usize);
    }

    /// Switches to 1 what the scenario adds, and tells `added` of each.
    pub fn give(&mut self, scenario: &TreeIndicator, mut added: impl FnMut(u32)) {
        if let Some(&(last, _)) = scenario.taking_part.last() {
            self.given.reach(last as usize + 1);
        }
        for &(number, _) in &scenario.taking_part {
            if self.given.insert(number as usize) {
                added(number);
            }
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Triangles below the roots of table 1: of the first tree (figure 2), then of the second.
    pub const TABLE_1_ROOTS: [&[u32]; 2] = [&[1, 11, 1, 1, 1, 4], &[2, 1, 14, 6]];

    /// A row of table 1 that reads 0 or the number of triangles.
    pub fn row(tree: usize, values: &[u32]) -> TreeIndicator {
        let roots: Vec<_> = TABLE_1_ROOTS[tree]
            .iter()
            .map(|&triangles| DistributedRoot { node: 0, lanes: 1, first: 0, triangles })
            .collect();
        let numbers = (0..).zip(values).filter(|(_, value)| **value > 0).map(|(number, _)| number);
        let indicator = TreeIndicator::new(numbers, &roots);
        let held: u32 = indicator.taking_part.iter().map(|(_, n)| n).sum();
        assert_eq!(held, values.iter().sum::<u32>(), "not a row for these roots");
        indicator
    }

    #[test]
    fn a_client_scores_the_triangles_it_was_given_already() {
        let mut client = ClientIndicator::default();
        assert_eq!(client.score(&row(1, &[2, 0, 14, 6])), 0);
        client.give(&row(1, &[2, 0, 14, 6]), |_| {});
        assert_eq!(client.score(&row(1, &[2, 1, 14, 6])), 22);
        assert_eq!(client.score(&row(1, &[0, 1, 0, 6])), 6);
        assert_eq!(client.score(&row(1, &[0, 1, 0, 0])), 0);
        let mut added = Vec::new();
        client.give(&row(1, &[0, 1, 0, 6]), |number| added.push(number));
        assert_eq!(added, [1], "the last was given before");
        assert_eq!(client.score(&row(1, &[0, 1, 0, 6])), 7);
    }

    #[test]
    fn a_root_named_by_several_pairs_counts_once() {
        let roots =
            [3, 5].map(|triangles| DistributedRoot { node: 0, lanes: 1, first: 0, triangles });
        let repeated = TreeIndicator::new([1, 0, 1, 1].into_iter(), &roots);
        assert_eq!(repeated, TreeIndicator::new([0, 1].into_iter(), &roots));
        let mut client = ClientIndicator::default();
        client.give(&repeated, |_| {});
        assert_eq!(client.score(&repeated), 8);
    }
}
