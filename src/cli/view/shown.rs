//! What a page shows, beside the results.

use crate::cli::prepare::{Both, Tree};
use crate::effects::motion::MotionOptions;
use crate::effects::{Plan, Step};
use crate::geometry::{Point, Pose};
use crate::report::viewer::{Collected, View, ViewBody, ViewMotion, page};
use crate::scene::{Scene, Transport};
use crate::scheduler::client_manager::EngineReport;
use crate::tree::TreeView;
use crate::tree::roots::PreAnalysis;

pub(super) struct Shown<'a> {
    pub scene: &'a Scene,
    pub plan: &'a Plan,
    pub trees: &'a Both<Tree>,
    /// After the crash of a scene that has one.
    pub deformed: Option<&'a Both<Tree>>,
    pub poses: &'a [Pose],
}

/// For each distributed root, workers as bits of words.
type Holders = Vec<Vec<u32>>;

impl Shown<'_> {
    /// `answered_by`: the worker of each scenario that has an answer.
    pub(super) fn page(
        &self,
        report: &EngineReport,
        collected: Collected,
        answered_by: &[Option<u32>],
    ) -> String {
        let motion = self.motion();
        let [fixed, moving] = self.holders(report.workers.len(), answered_by);
        let layout = self.plan.layout();
        page(&View {
            bodies: [self.body(0, fixed, motion), self.body(1, moving, motion)],
            accuracy: self.scene.accuracy,
            transport: report.transport,
            shares_memory: self.shares_memory(),
            workers: report.workers.len(),
            layout: &layout,
            motion: motion.map(|options| ViewMotion {
                duration_s: options.horizon.seconds(),
                tolerance_m: options.tolerance.metres(),
            }),
            penetration_direction: self.penetration_direction(),
            deform_after: self.scene.effects.deform_after(),
            collected,
        })
    }

    fn body(&self, side: usize, holders: Holders, motion: Option<&MotionOptions>) -> ViewBody<'_> {
        let body = [&self.scene.fixed, &self.scene.moving][side];
        ViewBody {
            name: body.mesh.to_string(),
            tree: views(self.trees)[side],
            deformed: self.deformed.map(|trees| views(trees)[side]),
            cut: self.scene.cuts()[side],
            holders,
            motion: motion.map(|options| options.bodies[side]),
            parts: motion.map(|options| options.parts[side].clone()).unwrap_or_default(),
        }
    }

    fn motion(&self) -> Option<&MotionOptions> {
        self.plan.steps.iter().find_map(|step| match step {
            Step::Motion(options) => Some(&**options),
            _ => None,
        })
    }

    fn penetration_direction(&self) -> Option<Point> {
        self.plan.steps.iter().find_map(|step| match step {
            Step::Penetration(options) => options.direction.map(Point::from),
            _ => None,
        })
    }

    fn shares_memory(&self) -> bool {
        matches!(self.scene.engine.transport, Transport::Iceoryx2 | Transport::Threads)
    }

    /// The workers that were given a scenario which needs the root: what the matchmaker knows of them.
    /// Of the fixed and of the moving tree.
    fn holders(&self, workers: usize, answered_by: &[Option<u32>]) -> [Holders; 2] {
        let words = workers.div_ceil(32).max(1);
        let [fixed, moving] = views(self.trees);
        let [fixed_cut, moving_cut] = self.scene.cuts();
        let mut analysis = PreAnalysis::new(fixed, fixed_cut, moving, moving_cut);
        let mut held = [analysis.fixed_roots(), analysis.moving_roots()]
            .map(|roots| vec![vec![0_u32; words]; roots.len()]);
        // Effects look at whole trees: where these are sent, they are, in one piece.
        let in_one_piece = !self.plan.is_empty() && !self.shares_memory();
        let deformed_from = self.deformed_from();
        let mut pairs = Vec::new();
        for (scenario, (pose, worker)) in self.poses.iter().zip(answered_by).enumerate() {
            if let (true, Some([fixed, moving])) =
                (scenario == deformed_from, self.deformed.map(views))
            {
                analysis = PreAnalysis::new(fixed, fixed_cut, moving, moving_cut);
            }
            let Some(worker) = *worker else { continue };
            let (word, bit) = (worker as usize / 32, 1 << (worker % 32));
            if in_one_piece {
                held.iter_mut().flatten().for_each(|root| root[word] |= bit);
                continue;
            }
            analysis.overlapping_roots(pose, &mut pairs);
            for pair in &pairs {
                (0..2).for_each(|side| held[side][pair[side] as usize][word] |= bit);
            }
        }
        held
    }

    fn deformed_from(&self) -> usize {
        let after = self.scene.effects.deform_after();
        after.map_or(usize::MAX, |scenario| scenario as usize + 1)
    }
}

fn views(trees: &Both<Tree>) -> [TreeView<'_>; 2] {
    [trees.fixed(), trees.moving()].map(|tree| tree.image.view())
}
