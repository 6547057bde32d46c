//! Runs the steps of a plan on one scenario after the other.

use std::time::Instant;

use super::layout::{Layout, Notes, StepCost};
use super::{Effect, Kept, Known, Plan, Scenario};
use crate::geometry::Pose;
use crate::tree::TreeView;
use crate::tree::descent::{Descent, DescentError, Pair};

/// What is asked about one scenario.
pub struct Question<'a> {
    /// The fixed and the moving one.
    pub trees: [TreeView<'a>; 2],
    /// Those beside both, in the order of the plan.
    pub parts: &'a [TreeView<'a>],
    pub pose: Pose,
    /// Sorted.
    pub pairs: &'a [Pair],
    pub descent: &'a mut Descent,
}

/// A plan at work.
pub struct Effects {
    plan: Plan,
    layout: Layout,
    effects: Vec<Box<dyn Effect>>,
    notes: Notes,
    /// Of the fixed and of the moving mesh.
    kept: [Kept; 2],
}

impl Effects {
    pub fn new(plan: Plan) -> Self {
        let effects = plan.steps.iter().map(|step| step.effect()).collect();
        Self {
            layout: plan.layout(),
            plan,
            effects,
            notes: Notes::default(),
            kept: Default::default(),
        }
    }

    /// Takes out what the plan ignores.
    pub fn keep(&self, pairs: &mut Vec<Pair>) {
        if !self.plan.ignore.is_empty() {
            pairs.retain(|pair| !self.plan.ignores(*pair));
        }
    }

    /// Runs the steps that the scenario needs, and appends what they say. `touching`: whether there
    /// is a pair, which overlap alone does not name.
    pub fn run(
        &mut self,
        question: Question<'_>,
        touching: bool,
        words: &mut Vec<u64>,
    ) -> Result<(), DescentError> {
        let Question { trees: [fixed, moving], parts, pose, pairs, descent } = question;
        let kept = &mut self.kept;
        let scenario = &mut Scenario { fixed, moving, pose, pairs, descent, parts, kept };
        let mut known = Known { touching, ..Known::default() };
        self.notes.clear(&self.layout);
        for (at, effect) in self.effects.iter_mut().enumerate() {
            if effect.is_called_for(&known) {
                let begin = Instant::now();
                let mut note = self.notes.of_step(&self.layout, at);
                let work = effect.run(scenario, &mut known, &mut note)?;
                let ns = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
                self.notes.set_cost(at, StepCost { ns, work });
            }
        }
        self.notes.write(&self.layout, words);
        Ok(())
    }
}
