//! A crash that changes the vehicles: what comes after it is of the deformed ones.

use std::io;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow};

use super::prepare::{self, Both, Tree};
use super::renumber::{Renumbered, renumbered};
use super::run::Job;
use super::terminal;
use crate::effects::crush::{CrushOptions, Impression};
use crate::effects::{Plan, Step};
use crate::geometry::Pose;
use crate::mesh::{TriangleMesh, deform, write_ply};
use crate::report::DEFORMED;
use crate::scene::Scene;
use crate::scheduler::client_manager::{AnyEngine, EngineReport, ResultSink, ScenarioResult};
use crate::tree::{BuildOptions, refit};

/// What a scene with such a crash has, beside a job.
pub(super) struct Crash<'a> {
    /// This scenario's crush deforms both vehicles.
    scenario: u32,
    plan: &'a Plan,
    meshes: &'a Both<TriangleMesh>,
    build: BuildOptions,
    /// Where the deformed meshes are written.
    out: Option<&'a Path>,
}

impl<'a> Crash<'a> {
    /// Of a scene in which a crash deforms the vehicles.
    pub(super) fn of(
        scene: &Scene,
        plan: &'a Plan,
        meshes: &'a Both<TriangleMesh>,
        out: Option<&'a Path>,
    ) -> Option<Self> {
        let scenario = scene.effects.deform_after()?;
        let build = BuildOptions { kind: scene.tree };
        Some(Self { scenario, plan, meshes, build, out })
    }

    /// The scenarios up to the crash, and then, with new versions of both trees, those after it. Also
    /// these versions, if the crash deforms anything.
    pub(super) fn run(
        &self,
        job: &Job<'_>,
        engine: &mut dyn AnyEngine,
        trees: &Both<Tree>,
        sink: &mut dyn ResultSink,
    ) -> anyhow::Result<(EngineReport, Option<Both<Tree>>)> {
        let crash = self.scenario as usize;
        let (before, after) = job.poses.split_at(job.poses.len().min(crash + 1));
        let mut watch = Watch { sink, scenario: self.scenario, seen: None };
        let report = Job { poses: before, ..*job }.run(engine, trees, &mut watch)?;
        let seen = watch.seen;
        if report.interrupted {
            return Ok((report, None));
        }
        if report.set_aside.contains(&self.scenario) {
            return Err(anyhow!(
                "scenario {crash}, whose crash deforms the vehicles, has no answer, because every \
                 worker that was at it died: those after it cannot be answered"
            ));
        }
        let later = |scenario: u32| self.scenario + 1 + scenario;
        let mut sink = Renumbered { sink, number: &later };
        let deformed = match (seen, self.options()) {
            (Some(impression), Some(options)) => {
                Some(self.deformed(trees, options, &job.poses[crash], &impression)?)
            }
            _ => {
                tracing::warn!("scenario {crash} has no impact: the vehicles stay as they are");
                None
            }
        };
        if after.is_empty() {
            return Ok((report, deformed.map(|(_, trees)| trees)));
        }
        let after = Job { poses: after, ..*job };
        let second = match &deformed {
            None => after.run(engine, trees, &mut sink),
            Some((meshes, trees)) => {
                let parts = prepare::build_parts(self.plan, meshes, self.build);
                let effects = job.effects.map(|(plan, _)| (plan, &parts[..]));
                Job { effects, ..after }.run(engine, trees, &mut sink)
            }
        };
        let first = self.scenario + 1;
        let second = second.map_err(|error| renumbered(error, &later, first))?;
        Ok((report.followed_by(second, first), deformed.map(|(_, trees)| trees)))
    }

    fn options(&self) -> Option<&CrushOptions> {
        self.plan.steps.iter().find_map(|step| match step {
            Step::Crush(options) => Some(&**options),
            _ => None,
        })
    }

    /// Both meshes with their dents, and their trees, which keep the shape of those before.
    fn deformed(
        &self,
        trees: &Both<Tree>,
        options: &CrushOptions,
        pose: &Pose,
        impression: &Impression,
    ) -> anyhow::Result<(Both<TriangleMesh>, Both<Tree>)> {
        let [fixed, moving] = options.dents(pose, impression);
        let one = |name, file, mesh: &TriangleMesh, tree: &Tree, dent: Option<_>| {
            let mesh = match &dent {
                Some(dent) => deform(mesh, dent)
                    .with_context(|| format!("the {name} mesh cannot be deformed"))?,
                None => mesh.clone(),
            };
            let mut image = (*tree.image).clone();
            refit(&mut image, &mesh).context("its tree cannot be refitted")?;
            if let Some(out) = self.out {
                let path = out.join(file);
                write_ply(&mesh, &path)
                    .with_context(|| format!("{}: cannot write it", path.display()))?;
            }
            anyhow::Ok((mesh, Tree { image: Arc::new(image), summary: tree.summary.clone() }))
        };
        let activity = terminal::activity("deforming");
        let both = one("fixed", DEFORMED[0], self.meshes.fixed(), trees.fixed(), fixed).and_then(
            |fixed| {
                Ok((
                    fixed,
                    one("moving", DEFORMED[1], self.meshes.moving(), trees.moving(), moving)?,
                ))
            },
        );
        activity.finish_and_clear();
        let ((fixed_mesh, fixed_tree), (moving_mesh, moving_tree)) = both?;
        Ok((Both::of(fixed_mesh, moving_mesh), Both::of(fixed_tree, moving_tree)))
    }
}

/// Sees what is said of one scenario.
struct Watch<'a> {
    sink: &'a mut dyn ResultSink,
    scenario: u32,
    seen: Option<Impression>,
}

impl ResultSink for Watch<'_> {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        if result.scenario == self.scenario {
            self.seen = Impression::read(&result.effects);
        }
        self.sink.accept(result)
    }

    fn set_aside(&mut self, scenario: u32) -> io::Result<()> {
        self.sink.set_aside(scenario)
    }
}
