//! Finds out which parts of the geometry a scenario needs (section 6.4.6 of the paper).

use super::indicator::TreeIndicator;
use super::local_client::Analysis;
use crate::geometry::Pose;
use crate::tree::descent::DescentError;
use crate::tree::roots::{PreAnalysis, RootPair};

#[derive(Debug)]
pub struct JobsSubmitter<'a> {
    analysis: PreAnalysis<'a>,
    overlapping: Vec<RootPair>,
}

impl<'a> JobsSubmitter<'a> {
    pub fn new(analysis: PreAnalysis<'a>) -> Self {
        Self { analysis, overlapping: Vec::new() }
    }

    /// The pre-analysis of one scenario, with the pairs of roots if a worker has to know them.
    ///
    /// An error if a vertex overflows, wherever it is: who has to look below some pairs of roots only
    /// does not see all vertices.
    pub fn analyse(
        &mut self,
        pose: &Pose,
        with_root_pairs: bool,
    ) -> Result<Analysis, DescentError> {
        self.analysis.boxes_that_meet(pose, &mut self.overlapping)?;
        let numbers = |side: usize| self.overlapping.iter().map(move |pair| pair[side]);
        let indicators = [
            TreeIndicator::new(numbers(0), self.analysis.fixed_roots()),
            TreeIndicator::new(numbers(1), self.analysis.moving_roots()),
        ];
        let root_pairs = if with_root_pairs { self.overlapping.clone() } else { Vec::new() };
        Ok(Analysis { indicators, root_pairs })
    }
}
