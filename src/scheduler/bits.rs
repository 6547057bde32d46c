//! A set of small numbers, a bit each: what is known of thousands of clients stays near the processor.

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bits {
    words: Vec<u64>,
}

impl Bits {
    /// Empty, with room for the numbers below `end`.
    pub fn below(end: usize) -> Self {
        Self { words: vec![0; end.div_ceil(64)] }
    }

    /// Makes room for the numbers below `end`, and keeps what it has.
    pub fn reach(&mut self, end: usize) {
        self.words.resize(self.words.len().max(end.div_ceil(64)), 0);
    }

    /// Whether there is room for nothing at all.
    pub fn is_roomless(&self) -> bool {
        self.words.is_empty()
    }

    /// 1 of a number that is in the set, or else 0: what is multiplied by it needs no branch.
    pub fn bit(&self, number: usize) -> u64 {
        self.words.get(number / 64).map_or(0, |word| word >> (number % 64) & 1)
    }

    /// A number that there is room for. Returns whether it is new.
    pub fn insert(&mut self, number: usize) -> bool {
        let (word, bit) = (&mut self.words[number / 64], 1 << (number % 64));
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    /// A number that there is room for, in the set or not.
    pub fn remove(&mut self, number: usize) {
        self.words[number / 64] &= !(1 << (number % 64));
    }

    /// In ascending order, from 0.
    pub fn nth(&self, mut n: usize) -> Option<usize> {
        for (at, &word) in self.words.iter().enumerate() {
            let here = word.count_ones() as usize;
            if n < here {
                let rest = (0..n).fold(word, |rest, _| rest & (rest - 1));
                return Some(64 * at + rest.trailing_zeros() as usize);
            }
            n -= here;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn it_holds_what_a_plain_set_holds(
            changes in prop::collection::vec((any::<bool>(), 0_usize..200), 0..300),
        ) {
            let (mut bits, mut plain) = (Bits::below(10), BTreeSet::new());
            bits.reach(200);
            for (is_added, number) in changes {
                if is_added {
                    prop_assert_eq!(bits.insert(number), plain.insert(number));
                } else {
                    bits.remove(number);
                    plain.remove(&number);
                }
            }
            for number in 0..300 {
                prop_assert_eq!(bits.bit(number) == 1, plain.contains(&number));
            }
            for n in 0..=plain.len() {
                prop_assert_eq!(bits.nth(n), plain.iter().nth(n).copied());
            }
            bits.reach(5);
            prop_assert_eq!(bits.nth(0), plain.first().copied());
        }
    }
}
