//! Finds out which parts of the geometry a scenario needs (section 6.4.6 of the paper).

use super::indicator::TreeIndicator;
use super::local_client::Indicators;
use crate::geometry::Pose;
use crate::tree::roots::PreAnalysis;

#[derive(Debug)]
pub struct JobsSubmitter<'a> {
    analysis: PreAnalysis<'a>,
    overlapping: Vec<[u32; 2]>,
}

impl<'a> JobsSubmitter<'a> {
    pub fn new(analysis: PreAnalysis<'a>) -> Self {
        Self { analysis, overlapping: Vec::new() }
    }

    /// The pre-analysis of one scenario.
    pub fn indicators(&mut self, pose: &Pose) -> Indicators {
        self.analysis.overlapping_roots(pose, &mut self.overlapping);
        let numbers = |side: usize| self.overlapping.iter().map(move |pair| pair[side]);
        [
            TreeIndicator::new(numbers(0), self.analysis.fixed_roots()),
            TreeIndicator::new(numbers(1), self.analysis.moving_roots()),
        ]
    }
}
