//! `bumper plan`: what a scene calls for, and what that is likely to cost.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, anyhow};
use serde::Serialize;

use super::args::PlanArgs;
use super::failure::Failure;
use super::prepare::{self, Both, Poses, Tree};
use super::request::{check_effects, scene_of};
use super::summary_text::short;
use super::{interrupt, terminal};
use crate::effects::contacts;
use crate::effects::layout::{Layout, StepCost};
use crate::effects::{DESCRIPTIONS, Description, Effects, PairsAsked, Plan, Question};
use crate::geometry::Pose;
use crate::report::figure::grouped;
use crate::scene::Scene;
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::tree::{Accuracy, BuildOptions, TreeImage};

/// What is printed.
#[derive(Serialize)]
struct PlanReport {
    schema_version: u32,
    scenarios: usize,
    /// Measured for the costs, one after the other.
    sample: usize,
    steps: Vec<PlannedStep>,
    /// Expected, on one worker.
    scenario_us: f64,
    left_out: Vec<Description>,
}

#[derive(Serialize)]
struct PlannedStep {
    effect: &'static str,
    needed_where: &'static str,
    called_for_by: &'static str,
    /// Scenarios of the sample that needed it.
    needed: usize,
    /// Over those.
    mean_us: f64,
    /// Over all scenarios of the sample.
    scenario_us: f64,
}

pub(super) fn plan(args: &PlanArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let scene = scene_of(&args.scene)?;
    check_effects(&scene)?;
    if let Accuracy::BoxesAt(_) = scene.accuracy {
        return Err(Failure::usage(anyhow!(
            "accuracy {} finds boxes that meet, and a plan is about triangles: take boxes, f32, f64 or \
             exact",
            scene.accuracy
        )));
    }
    let poses = Poses::of(&scene.scenarios)?;
    let (scenarios, poses) = (poses.len(), poses.at_most(args.sample));
    let meshes = prepare::load(&scene)?;
    let plan = scene.effects.plan([meshes.fixed(), meshes.moving()]).map_err(Failure::usage)?;
    interrupt::check(&interrupt)?;
    let options = BuildOptions { kind: scene.tree };
    let trees = prepare::build(&meshes, options, None);
    let parts = prepare::build_parts(&plan, &meshes, options);
    let poses = poses.place(&meshes, &trees, &interrupt)?;
    interrupt::check(&interrupt)?;
    let layout = plan.layout();
    let sample =
        Sample { scene: &scene, plan: &plan, layout: &layout, trees: &trees, parts: &parts };
    let costs = sample.measure(&poses).context("cannot measure a sample")?;
    let report = report(&scene, &layout, scenarios, &costs);
    let text = if args.json {
        serde_json::to_string_pretty(&report).expect("string keys and plain values") + "\n"
    } else {
        report.text()
    };
    Ok(terminal::print(&text).context("cannot print the plan")?)
}

/// Costs of one scenario: of the pairs, and of the plan's steps.
type Costs = (u64, Vec<StepCost>);

struct Sample<'a> {
    scene: &'a Scene,
    plan: &'a Plan,
    layout: &'a Layout,
    trees: &'a Both<Tree>,
    parts: &'a [Arc<TreeImage>],
}

impl Sample<'_> {
    fn measure(&self, poses: &[Pose]) -> Result<Vec<Costs>, DescentError> {
        let mut effects = Effects::new(self.plan.clone());
        let (mut descent, mut pairs) = (Descent::default(), Vec::new());
        if let Accuracy::Pairs(test) = self.scene.accuracy {
            descent.set_test(test);
        }
        poses.iter().map(|pose| self.one(pose, &mut effects, &mut descent, &mut pairs)).collect()
    }

    fn one(
        &self,
        pose: &Pose,
        effects: &mut Effects,
        descent: &mut Descent,
        pairs: &mut Vec<Pair>,
    ) -> Result<Costs, DescentError> {
        let trees = [self.trees.fixed().image.view(), self.trees.moving().image.view()];
        let begin = Instant::now();
        pairs.clear();
        let touching = if self.scene.effects.overlap_is_enough() {
            descent.any_pair(&trees[0], &trees[1], pose)?
        } else {
            contacts::contacts(descent, &trees[0], &trees[1], pose, pairs)?;
            effects.keep(pairs);
            !pairs.is_empty()
        };
        let pairs_ns = begin.elapsed().as_nanos() as u64;
        let parts: Vec<_> = self.parts.iter().map(|part| part.view()).collect();
        let mut words = Vec::new();
        let question = Question { trees, parts: &parts, pose: *pose, pairs, descent };
        effects.run(question, touching, &mut words)?;
        let said = self.layout.read(&words).expect("written by the same layout");
        Ok((pairs_ns, said.costs().collect()))
    }
}

fn report(scene: &Scene, layout: &Layout, scenarios: usize, costs: &[Costs]) -> PlanReport {
    let step = |Description { effect, needed_where, called_for_by }, ns: &dyn Fn(&Costs) -> u64| {
        let needed = costs.iter().filter(|costs| ns(costs) > 0).count();
        let all_us = costs.iter().map(|costs| ns(costs) as f64 * 1e-3).sum::<f64>();
        PlannedStep {
            effect,
            needed_where,
            called_for_by,
            needed,
            mean_us: all_us / needed.max(1) as f64,
            scenario_us: all_us / costs.len().max(1) as f64,
        }
    };
    let pairs = match scene.effects.pairs {
        PairsAsked::Overlap => ("overlap", "`effects.overlap = true`"),
        PairsAsked::Contacts => ("contacts", "every scene, unless `effects.overlap = true`"),
    };
    let pairs = Description { effect: pairs.0, needed_where: "always", called_for_by: pairs.1 };
    let mut steps = vec![step(pairs, &|costs| costs.0.max(1))];
    for (at, planned) in layout.steps.iter().enumerate() {
        let described = DESCRIPTIONS.iter().find(|described| described.effect == planned.name);
        let described = *described.expect("every effect is described");
        steps.push(step(described, &|costs| costs.1[at].ns));
    }
    let is_planned = |d: &&Description| steps.iter().any(|step| step.effect == d.effect);
    let left_out = DESCRIPTIONS.iter().filter(|d| !is_planned(d)).copied().collect();
    PlanReport {
        schema_version: 1,
        scenarios,
        sample: costs.len(),
        scenario_us: steps.iter().map(|step| step.scenario_us).sum(),
        steps,
        left_out,
    }
}

impl PlanReport {
    fn text(&self) -> String {
        let mut text = String::new();
        self.write(&mut text).expect("writing to a string does not fail");
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        let (scenarios, sample) = (grouped(self.scenarios as u64), self.sample);
        writeln!(text, "{scenarios} scenarios; costs from a sample of {sample}, on one worker\n")?;
        writeln!(
            text,
            "{:<19}{:>9}{:>13}{:>15}  called for by",
            "runs", "needed", "mean", "a scenario"
        )?;
        for step in &self.steps {
            let needed = format!("{}/{sample}", step.needed);
            let (mean, each) = (short(step.mean_us), short(step.scenario_us));
            writeln!(
                text,
                "{:<19}{needed:>9}{mean:>13}{each:>15}  {}",
                step.effect, step.called_for_by
            )?;
            writeln!(text, "{:<19}where {}", "", step.needed_where)?;
        }
        let all = self.scenario_us * self.scenarios as f64 * 1e-6;
        writeln!(text, "\na scenario {}; all of them {all:.1} s", short(self.scenario_us))?;
        if !self.left_out.is_empty() {
            writeln!(text, "\n{:<19}would be called for by", "left out")?;
        }
        for Description { effect, called_for_by, .. } in &self.left_out {
            writeln!(text, "{effect:<19}{called_for_by}")?;
        }
        Ok(())
    }
}
