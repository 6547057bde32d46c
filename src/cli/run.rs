//! `bumper run`: the main job.

use std::io;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context, anyhow};
use indicatif::ProgressBar;

use super::args::RunArgs;
use super::failure::Failure;
use super::prepare::{self, Both, Tree, timed};
use super::request::Request;
use super::{interrupt, summary_text, terminal};
use crate::geometry::Pose;
use crate::report::{OutputDir, OutputError, ResultFiles, Summary, Tally, Times};
use crate::scheduler::client_manager::{
    self, EngineError, EngineOptions, EngineReport, ResultSink, ScenarioResult,
};
use crate::tree::BuildOptions;

pub(super) fn run(args: RunArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let request = Request::new(args)?;
    let scene = &request.scene;

    let (meshes, load_s) = timed(|| prepare::load(scene));
    let meshes = meshes?;
    interrupt::check(&interrupt)?;
    let options = BuildOptions { kind: scene.tree };
    let (trees, build_s) = timed(|| prepare::build(&meshes, options, request.cache_dir.as_deref()));
    interrupt::check(&interrupt)?;
    let (poses, poses_s) = timed(|| prepare::poses(&scene.scenarios, &meshes, &trees, &interrupt));
    let poses = poses?;
    drop(meshes);
    interrupt::check(&interrupt)?;

    let mut results = Results::new(request.out, request.contacts, poses.len());
    let options = EngineOptions {
        workers: request.workers.get(),
        buffer_scenarios: scene.engine.buffer_scenarios,
        fixed_depth: scene.fixed.depth.get(),
        moving_depth: scene.moving.depth.get(),
        send_pairs: request.contacts,
        worker_program: std::env::current_exe().context("cannot find my own executable")?,
    };
    let report = answer(&trees, &poses, &options, &mut results, &interrupt)?;

    let mut times = Times { load_s, build_s, poses_s, ..Times::default() };
    times.wall_s = start.elapsed().as_secs_f64();
    let meshes = [trees.fixed(), trees.moving()].map(|tree| tree.summary.clone());
    let summary = Summary::new(scene, meshes, poses.len(), report, &results.tally, times);
    finish(&summary, &mut results, request.json)
}

/// Runs the engine. Whatever comes of it, the results so far are complete files afterwards.
fn answer(
    trees: &Both<Tree>,
    poses: &[Pose],
    options: &EngineOptions,
    results: &mut Results,
    interrupt: &AtomicBool,
) -> Result<EngineReport, Failure> {
    let (fixed, moving) = (trees.fixed().image.view(), trees.moving().image.view());
    let report = client_manager::run(fixed, moving, poses, options, results, interrupt);
    results.bar.finish_and_clear();
    let contacts = results.files.as_mut().map_or(Ok(()), ResultFiles::finish_contacts);
    // If both failed, the contacts did so for the same reason.
    let report = report.map_err(|error| match (&results.files, error) {
        (Some(_), EngineError::Sink(error)) => {
            anyhow!("{error}; scenarios.csv keeps the scenarios that were answered before")
        }
        (_, error) => error.into(),
    })?;
    contacts?;
    Ok(report)
}

/// Writes and prints the figures.
fn finish(summary: &Summary, results: &mut Results, json: bool) -> Result<(), Failure> {
    if let Some(files) = &mut results.files {
        files.write_summary(summary)?;
    }
    let text = if json { summary.to_json() + "\n" } else { summary_text::summary_text(summary) };
    terminal::print(&text).context("cannot print the summary")?;
    if summary.interrupted && summary.scenarios == 0 {
        return Err(interrupt::before_results());
    }
    if summary.interrupted {
        let (done, asked) = (summary.scenarios, summary.scenarios_asked);
        return Err(Failure::Interrupted(format!("{done} of {asked} scenarios were answered")));
    }
    Ok(())
}

/// Takes each result to where it is wanted.
struct Results {
    tally: Tally,
    /// Until the first result comes: what cannot begin must not cost an earlier run its files.
    out: Option<OutputDir>,
    contacts: bool,
    files: Option<ResultFiles>,
    bar: ProgressBar,
}

impl Results {
    fn new(out: Option<OutputDir>, contacts: bool, scenarios: usize) -> Self {
        let bar = terminal::scenario_bar("running", scenarios);
        Self { tally: Tally::default(), out, contacts, files: None, bar }
    }

    fn start_files(&mut self) -> Result<(), OutputError> {
        if let Some(out) = self.out.take() {
            self.files = Some(out.start(self.contacts)?);
        }
        Ok(())
    }
}

impl ResultSink for Results {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        self.start_files().map_err(io::Error::other)?;
        if let Some(files) = &mut self.files {
            files.write(&result).map_err(io::Error::other)?;
        }
        self.tally.add(&result);
        self.bar.inc(1);
        Ok(())
    }
}
