//! What the scenarios of a run take with one kind of tree: the terms of the paper's cost equation.

use serde::Serialize;

use super::CostFit;
use crate::tree::cache::CacheOutcome;
use crate::tree::{Counts, TreeKind};
use crate::wire::CostRecord;

/// T_total = N_b C_b + N_p C_p (section 3) with both trees of one kind. Counts and times are sums
/// over all scenarios.
#[derive(Clone, Debug, Serialize)]
pub struct TreeCosts {
    pub tree: TreeKind,
    pub scenarios: usize,
    /// N_b: pairs of boxes tested.
    pub n_b: u64,
    /// N_p: pairs of triangles tested.
    pub n_p: u64,
    /// Those of them that came to the exact test.
    pub exact: u64,
    /// T_total: seconds of the descents, in processor time.
    pub descent_s: f64,
    /// Absent where the scenarios do not tell C_b and C_p apart.
    pub fit: Option<CostFit>,
    /// Both trees, built or read from the cache.
    pub build_s: f64,
    /// Of the fixed and of the moving tree.
    pub cache: [CacheOutcome; 2],
}

impl TreeCosts {
    pub fn new(
        tree: TreeKind,
        costs: &[CostRecord],
        build_s: f64,
        cache: [CacheOutcome; 2],
    ) -> Self {
        let mut sum = Counts::default();
        costs.iter().for_each(|cost| sum += cost.counts);
        let descent_ns: u64 = costs.iter().map(|cost| cost.descent_ns).sum();
        Self {
            tree,
            scenarios: costs.len(),
            n_b: sum.boxes,
            n_p: sum.triangles,
            exact: sum.exact,
            descent_s: descent_ns as f64 * 1e-9,
            fit: CostFit::of(costs),
            build_s,
            cache,
        }
    }
}
