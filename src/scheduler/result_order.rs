//! Puts results back into scenario order.

use std::collections::BTreeMap;

/// Holds what came early until everything before it has come.
#[derive(Debug)]
pub struct ResultOrder<T> {
    next: u32,
    early: BTreeMap<u32, T>,
}

impl<T> Default for ResultOrder<T> {
    fn default() -> Self {
        Self { next: 0, early: BTreeMap::new() }
    }
}

impl<T> ResultOrder<T> {
    /// Each scenario comes once.
    pub fn insert(&mut self, scenario: u32, result: T) {
        let displaced = self.early.insert(scenario, result);
        assert!(displaced.is_none() && scenario >= self.next, "two results of {scenario}");
    }

    /// The next result in order, if it has come.
    pub fn pop(&mut self) -> Option<(u32, T)> {
        let result = self.early.remove(&self.next)?;
        self.next += 1;
        Some((self.next - 1, result))
    }

    /// How many results were delivered: all scenarios below this number.
    pub fn delivered(&self) -> u32 {
        self.next
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn results_in_any_order_come_out_in_order_and_as_early_as_possible(
            order in Just((0..40_u32).collect::<Vec<_>>()).prop_shuffle()
        ) {
            let mut results = ResultOrder::default();
            let mut delivered = Vec::new();
            for (count, &scenario) in order.iter().enumerate() {
                results.insert(scenario, scenario);
                delivered.extend(std::iter::from_fn(|| results.pop()));
                let come = &order[..=count];
                let without_gap = (0..).take_while(|n| come.contains(n)).count();
                prop_assert_eq!(results.delivered() as usize, without_gap);
            }
            prop_assert!(delivered.into_iter().eq((0..40).map(|n| (n, n))));
        }
    }

    #[test]
    #[should_panic(expected = "two results of 3")]
    fn a_second_result_is_our_own_mistake() {
        let mut results = ResultOrder::default();
        results.insert(3, ());
        results.insert(3, ());
    }
}
