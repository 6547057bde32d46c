//! Running totals of results.

use crate::scheduler::client_manager::ScenarioResult;

#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub colliding: u32,
    pub pairs: u64,
    /// Nanoseconds, one entry a scenario.
    compute_ns: Vec<u64>,
}

/// Time that a worker computed on one scenario, in microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ComputeTimes {
    pub mean: f64,
    pub median: f64,
    pub p99: f64,
    pub max: f64,
}

impl Tally {
    pub fn add(&mut self, result: &ScenarioResult<'_>) {
        self.colliding += u32::from(result.pair_count > 0);
        self.pairs += u64::from(result.pair_count);
        self.compute_ns.push(result.compute_ns);
    }

    /// Zeros if there was no result.
    pub fn compute_times(&self) -> ComputeTimes {
        let mut sorted = self.compute_ns.clone();
        sorted.sort_unstable();
        let Some(last) = sorted.len().checked_sub(1) else { return ComputeTimes::default() };
        let microseconds = |ns: u64| ns as f64 / 1e3;
        let quantile = |percent: usize| microseconds(sorted[last * percent / 100]);
        ComputeTimes {
            mean: microseconds(sorted.iter().sum()) / sorted.len() as f64,
            median: quantile(50),
            p99: quantile(99),
            max: quantile(100),
        }
    }
}
