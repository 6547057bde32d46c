//! Running totals of results.

use super::Earlier;
use crate::effects::layout::Layout;
use crate::scheduler::client_manager::ScenarioResult;

#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub colliding: u32,
    pub pairs: u64,
    /// Scenarios that an earlier run answered, of which nothing else is known.
    earlier: u32,
    /// Nanoseconds, one entry a scenario.
    compute_ns: Vec<u64>,
    layout: Layout,
    /// Of the steps of the layout: the scenarios that needed it, nanoseconds, and work.
    steps: Vec<(u32, u64, u64)>,
}

/// What one effect took, over all scenarios.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct EffectSummary {
    pub effect: &'static str,
    /// That needed it.
    pub scenarios: u32,
    /// Over all workers.
    pub compute_s: f64,
    /// Over the scenarios that needed it, in microseconds.
    pub mean_us: f64,
    pub work: u64,
    pub work_unit: &'static str,
}

/// Time that a worker computed on one scenario, in microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ComputeTimes {
    pub mean: f64,
    pub median: f64,
    pub p99: f64,
    pub max: f64,
    /// At 0, 10, ..., 100 % of the scenarios.
    pub deciles: [f64; 11],
}

impl Tally {
    /// Of results whose effects are laid out like that.
    pub fn new(layout: Layout) -> Self {
        Self { steps: vec![(0, 0, 0); layout.steps.len()], layout, ..Self::default() }
    }

    /// Of those effects that were called for, the pairs first.
    pub fn effects(&self, pairs: &'static str) -> Vec<EffectSummary> {
        let scenarios = self.compute_ns.len() as u32;
        let others: u64 = self.steps.iter().map(|(_, ns, _)| ns).sum();
        let pairs_ns = self.compute_ns.iter().sum::<u64>().saturating_sub(others);
        let summary = |effect, (scenarios, ns, work), work_unit| EffectSummary {
            effect,
            scenarios,
            compute_s: ns as f64 * 1e-9,
            mean_us: ns as f64 * 1e-3 / f64::from(scenarios.max(1)),
            work,
            work_unit,
        };
        let first = summary(pairs, (scenarios, pairs_ns, self.pairs), "pairs found");
        let steps = self.layout.steps.iter().zip(&self.steps);
        let others = steps.map(|(step, &sums)| summary(step.name, sums, step.work_unit));
        [first].into_iter().chain(others).collect()
    }

    /// What a run had answered before this one goes on with it.
    pub fn add_earlier(&mut self, earlier: &Earlier) {
        self.earlier += earlier.scenarios;
        self.colliding += earlier.colliding;
        self.pairs += earlier.pairs;
    }

    pub fn earlier(&self) -> u32 {
        self.earlier
    }

    pub fn add(&mut self, result: &ScenarioResult<'_>) {
        for (sums, cost) in self.steps.iter_mut().zip(result.effects.costs()) {
            sums.0 += u32::from(cost.ns > 0);
            sums.1 += cost.ns;
            sums.2 += cost.work;
        }
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
            deciles: std::array::from_fn(|tenths| quantile(10 * tenths)),
        }
    }
}
