//! `bumper experiment`: the paper's evaluation, on this machine.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, anyhow};
use indicatif::ProgressBar;

use super::args::{EngineArgs, ExperimentArgs, SceneArgs};
use super::failure::Failure;
use super::prepare::{self, Poses};
use super::request::{self, override_scene};
use super::{interrupt, report, terminal};
use crate::experiment::evaluation::{
    ConfigError, Evaluation, Loaded, Outcome, Step, Store, StoreError, Vary, measure, setup,
};
use crate::geometry::simd::SimdLevel;
use crate::report::source::Source;
use crate::scene::Scene;
use crate::tree::BuildOptions;

pub(super) fn run(args: ExperimentArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let evaluation = evaluation(&args)?;
    let setup = setup(&evaluation).map_err(Failure::usage)?;
    let out = args.out.unwrap_or_else(|| format!("experiment-{}", evaluation.name).into());
    let mut store = Store::open(&out, &evaluation, &setup, args.resume).map_err(refusal)?;
    let bar = terminal::point_bar(evaluation.steps().len());
    let measured = measure_all(&evaluation, &mut store, &bar, &interrupt);
    bar.finish_and_clear();
    // What was measured before a failure is worth being seen too.
    let outcome = Outcome::new(&evaluation, &setup, store.kept());
    let written = report::write_output(&out, Source::Experiment, &outcome.to_json());
    let is_interrupted = match measured {
        Ok(()) => false,
        Err(Failure::Interrupted(_)) => true,
        Err(failure) => return Err(failure),
    };
    written?;
    let text = if args.json { outcome.to_json() } else { text(&outcome) };
    terminal::print(&text).context("cannot print the figures")?;
    if is_interrupted {
        let Outcome { samples, samples_asked, .. } = outcome;
        return Err(Failure::Interrupted(format!(
            "{samples} of {samples_asked} samples are measured; the same command with --resume goes \
             on after them"
        )));
    }
    Ok(())
}

/// With the options of the command line in it.
fn evaluation(args: &ExperimentArgs) -> Result<Evaluation, Failure> {
    SimdLevel::from_environment().map_err(Failure::usage)?;
    let mut evaluation = Evaluation::find(&args.experiment).map_err(|error| match error {
        ConfigError::Read { .. } => Failure::from(error),
        error => Failure::usage(error),
    })?;
    if !args.models.is_empty() {
        evaluation.choose(&args.models).map_err(Failure::usage)?;
    }
    evaluation.samples = args.samples.unwrap_or(evaluation.samples);
    check_overrides(&evaluation, args)?;
    let scene_args = SceneArgs {
        fixed: args.fixed.clone(),
        moving: args.moving.clone(),
        poses: args.poses.clone(),
        count: args.count,
        workers: args.workers,
        engine: EngineArgs { transport: args.transport, ..EngineArgs::default() },
        ..SceneArgs::default()
    };
    for models in &mut evaluation.models {
        override_scene(&mut models.scene, &scene_args)?;
    }
    Ok(evaluation)
}

/// What would make all models the same, or say for nothing what an experiment varies or lacks.
fn check_overrides(evaluation: &Evaluation, args: &ExperimentArgs) -> Result<(), Failure> {
    let replaces = args.fixed.is_some() || args.moving.is_some() || args.poses.is_some();
    if let (true, [first, _, ..]) = (replaces, &evaluation.models[..]) {
        return Err(Failure::usage(anyhow!(
            "--fixed, --moving and --poses replace those of one pair of models: say which with \
             --models, as --models {}",
            first.name
        )));
    }
    if args.workers.is_some() && matches!(evaluation.vary, Vary::Units { .. }) {
        return Err(Failure::usage(anyhow!(
            "--workers: the workers are what experiment {} varies: write a file with other `units`",
            evaluation.name
        )));
    }
    if evaluation.vary.is_serial() && (args.workers.is_some() || args.transport.is_some()) {
        return Err(Failure::usage(anyhow!(
            "--workers and --transport: experiment {} runs on one core, without an engine",
            evaluation.name
        )));
    }
    Ok(())
}

fn refusal(error: StoreError) -> Failure {
    if error.is_refusal() { Failure::usage(error) } else { error.into() }
}

/// All steps of which there is no sample yet.
fn measure_all(
    evaluation: &Evaluation,
    store: &mut Store,
    bar: &ProgressBar,
    interrupt: &AtomicBool,
) -> Result<(), Failure> {
    let program = std::env::current_exe().context("cannot find my own executable")?;
    let steps = evaluation.steps();
    let done: Vec<Step> =
        store.kept().samples.iter().filter_map(|sample| sample.step(evaluation)).collect();
    bar.set_position(done.len() as u64);
    for (index, models) in evaluation.models.iter().enumerate() {
        let is_left = |step: &&Step| step.models == index && !done.contains(step);
        let left: Vec<&Step> = steps.iter().filter(is_left).collect();
        if left.is_empty() {
            continue;
        }
        bar.set_message(models.name.clone());
        let loaded = load(&models.scene, interrupt)?;
        store.add_models(loaded.facts(&models.name)).map_err(refusal)?;
        bar.reset_eta();
        for step in left {
            interrupt::check(interrupt)?;
            measure_one(evaluation, step, &loaded, &program, (store, bar), interrupt)?;
        }
    }
    Ok(())
}

fn measure_one(
    evaluation: &Evaluation,
    step: &Step,
    loaded: &Loaded,
    program: &Path,
    (store, bar): (&mut Store, &ProgressBar),
    interrupt: &AtomicBool,
) -> Result<(), Failure> {
    let name = evaluation.describe(step, loaded.poses.len());
    bar.set_message(name.clone());
    let sample = measure(evaluation, step, loaded, program, interrupt).map_err(|error| {
        if error.is_interrupt() {
            return interrupt::before_results();
        }
        anyhow!(error).context(format!("{name}; what is measured is kept (--resume)")).into()
    })?;
    store.add_sample(sample).map_err(refusal)?;
    bar.inc(1);
    Ok(())
}

fn load(scene: &Scene, interrupt: &AtomicBool) -> Result<Loaded, Failure> {
    let poses = Poses::of(&scene.scenarios)?;
    let meshes = prepare::load(scene)?;
    interrupt::check(interrupt)?;
    let options = BuildOptions { kind: scene.tree };
    let trees = prepare::build(&meshes, options, request::cache_dir().as_deref());
    interrupt::check(interrupt)?;
    let poses = poses.place(&meshes, &trees, interrupt)?;
    let [fixed, moving] = [trees.fixed(), trees.moving()].map(|tree| Arc::clone(&tree.image));
    Ok(Loaded { fixed, moving, poses })
}

fn text(outcome: &Outcome<'_>) -> String {
    let mut text: String = outcome.tables.iter().map(|table| table.to_text() + "\n").collect();
    for note in &outcome.notes {
        text += &format!("- {note}\n");
    }
    text
}
