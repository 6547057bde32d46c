//! `bumper run`: the main job.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context, anyhow};
use indicatif::ProgressBar;

use super::args::RunArgs;
use super::compare::{Comparison, Measured};
use super::deform::Crash;
use super::failure::Failure;
use super::prepare::{Both, Poses, Prepared, Tree, timed};
use super::ranks::{self, Master};
use super::renumber::{Renumbered, renumbered};
use super::request::Request;
use super::{interrupt, summary_text, terminal};
use crate::effects::layout::Layout;
use crate::effects::{PairsAsked, Plan};
use crate::geometry::Pose;
use crate::mesh::TriangleMesh;
use crate::report::{OutputDir, OutputError, Outputs, ResultFiles, RunIdentity, Summary, Tally};
use crate::scene::{EngineOptions, Scene, WorkerCount};
use crate::scheduler::client_manager::{
    self, AnyEngine, EffectsWork, EngineError, EngineReport, ResultSink, ScenarioResult, Work,
};
use crate::scheduler::ranks::Command;
use crate::tree::roots::Cut;
use crate::tree::{TreeImage, TreeKind};
use crate::wire::Wanted;

pub(super) fn run(args: RunArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let Some(Master { command }) = ranks::take_part()? else { return Ok(()) };
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let request = Request::new(args)?;
    if let Some(complete) = request.out.as_ref().filter(|out| request.resumes && out.is_complete())
    {
        return already_complete(complete, request.json);
    }
    let scene = &request.scene;

    let (poses, read_s) = timed(|| Poses::of(&scene.scenarios));
    let poses = poses?;
    check_crash(scene, poses.len())?;
    // Workers come to life while meshes are loaded and trees are built.
    let mut engine = start_engine(scene, poses.len(), command)?;
    let Prepared { meshes, plan, trees, parts, poses, mut times } =
        Prepared::new(scene, poses, request.cache_dir.as_deref(), &interrupt)?;
    times.poses_s += read_s;

    let all = poses.len();
    let layout = plan.layout();
    let mut results = Results::new(layout.clone(), request.stats, all);
    // What is only written costs nothing where nothing is.
    let mut missing = None;
    if let Some(out) = request.out {
        let outputs = Outputs {
            scene: scene.to_toml()?,
            identity: RunIdentity::new(meshes.fixed(), meshes.moving(), &poses, request.contacts),
            overlap_only: scene.effects.pairs == PairsAsked::Overlap,
            layout,
        };
        if request.resumes {
            missing = Some(results.go_on(out, outputs)?);
        } else {
            results.out = Some((out, outputs));
        }
    }
    let poses = match &missing {
        Some(missing) => missing.iter().map(|&scenario| poses[scenario as usize]).collect(),
        None => poses,
    };
    let job = Job {
        poses: &poses,
        cuts: scene.cuts(),
        wanted: Wanted {
            accuracy: scene.accuracy,
            overlap_only: scene.effects.overlap_is_enough(),
            pairs: if request.contacts { scene.effects.most_pairs() } else { 0 },
            costs: request.stats,
            plan: None,
        },
        effects: (!plan.is_empty()).then_some((&plan, &parts)),
        interrupt: &interrupt,
    };
    let crash = Crash::of(scene, &plan, &meshes, request.out_path.as_deref());
    let way = Way { crash: crash.as_ref(), missing: missing.as_deref() };
    let report = answer(&mut *engine, &trees, &job, &way, &mut results)
        .map_err(|error| naming_the_vertex(error, meshes.moving()))?;

    let trees_summary = [trees.fixed(), trees.moving()].map(|tree| tree.summary.clone());
    let mut compared = Ok(Vec::new());
    if let (Some(measured), false) =
        (&results.measured, report.interrupted || !report.set_aside.is_empty())
    {
        let cache_dir = request.cache_dir.as_deref();
        let job = Job { wanted: Wanted { pairs: 0, ..job.wanted }, effects: None, ..job };
        let comparison = Comparison { meshes: &meshes, cache_dir, job };
        compared =
            comparison.with_others(&mut *engine, scene.tree, (trees, times.build_s), measured);
    }
    drop(engine);
    times.wall_s = start.elapsed().as_secs_f64();
    let summary = Summary::new(scene, trees_summary, all, report, &results.tally, times);
    // The answers are there, whatever came of the comparison.
    let (tree_costs, failure) =
        compared.map_or_else(|error| (Vec::new(), Some(error)), |costs| (costs, None));
    let finished = finish(&Summary { tree_costs, plan, ..summary }, &mut results, request.json);
    failure.map_or(finished, Err)
}

/// That the scenario is there whose crash deforms the vehicles.
pub(super) fn check_crash(scene: &Scene, scenarios: usize) -> Result<(), Failure> {
    let after = scene.effects.deform_after();
    match after.filter(|&scenario| scenario as usize >= scenarios) {
        None => Ok(()),
        Some(scenario) => Err(Failure::usage(anyhow!(
            "`effects.crush.deform_after`: there is no scenario {scenario}: there are {scenarios}, \
             counted from 0"
        ))),
    }
}

/// Says so.
fn already_complete(out: &OutputDir, json: bool) -> Result<(), Failure> {
    let text = if json {
        out.summary()?
    } else {
        "nothing is missing: all scenarios are answered\n".into()
    };
    Ok(terminal::print(&text).context("cannot print the summary")?)
}

/// A worker for each rank; or no more than there are scenarios.
pub(super) fn start_engine(
    scene: &Scene,
    scenarios: usize,
    command: Option<Command>,
) -> anyhow::Result<Box<dyn AnyEngine>> {
    let program = std::env::current_exe().context("cannot find my own executable")?;
    if let Some(command) = command {
        return Ok(client_manager::start_on_ranks(scene.engine.clone(), program, command)?);
    }
    let most = WorkerCount::new(scenarios.clamp(1, WorkerCount::MAX as usize) as i64);
    let workers = scene.engine.worker_count().min(most.expect("clamped").get());
    let workers = WorkerCount::new(workers.get().into()).expect("fewer than it was");
    let options = EngineOptions { workers: Some(workers), ..scene.engine.clone() };
    Ok(client_manager::start(options, program)?)
}

/// What is asked of the engine about a pair of trees.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub poses: &'a [Pose],
    /// Of the fixed and of the moving tree.
    pub cuts: [Cut; 2],
    pub wanted: Wanted,
    /// With the trees that only they need. Absent: pairs are all that is asked for.
    pub effects: Option<(&'a Plan, &'a [Arc<TreeImage>])>,
    pub interrupt: &'a AtomicBool,
}

impl Job<'_> {
    /// Lends the trees to the engine for the time of a run.
    pub(super) fn run(
        &self,
        engine: &mut dyn AnyEngine,
        trees: &Both<Tree>,
        sink: &mut dyn ResultSink,
    ) -> Result<EngineReport, EngineError> {
        let meshes = trees.try_map(|tree| engine.add_mesh(Arc::clone(&tree.image)))?;
        let parts = self.effects.map_or(&[][..], |(_, parts)| parts).iter();
        let parts: Vec<_> =
            parts.map(|part| engine.add_mesh(Arc::clone(part))).collect::<Result<_, _>>()?;
        let [fixed_cut, moving_cut] = self.cuts;
        let work = Work {
            fixed: (*meshes.fixed(), fixed_cut),
            moving: (*meshes.moving(), moving_cut),
            poses: self.poses,
            wanted: self.wanted,
            effects: self.effects.map(|(plan, _)| EffectsWork { plan, parts: &parts }),
        };
        let report = engine.run(&work, sink, self.interrupt)?;
        // The answers are complete, whatever comes of it.
        let trees = [
            Some(*meshes.fixed()),
            (meshes.fixed() != meshes.moving()).then_some(*meshes.moving()),
        ];
        for mesh in trees.into_iter().flatten().chain(parts) {
            if let Err(error) = engine.remove_mesh(mesh) {
                tracing::warn!("the engine keeps the memory of a tree: {error}");
            }
        }
        Ok(report)
    }
}

/// What is not simply one scenario after the other.
struct Way<'a> {
    crash: Option<&'a Crash<'a>>,
    /// Only these are to be answered: the poses of the job are theirs.
    missing: Option<&'a [u32]>,
}

impl Way<'_> {
    fn run(
        &self,
        engine: &mut dyn AnyEngine,
        trees: &Both<Tree>,
        job: &Job<'_>,
        results: &mut Results,
    ) -> anyhow::Result<EngineReport> {
        match (self.crash, self.missing) {
            (Some(crash), _) => Ok(crash.run(job, engine, trees, results)?.0),
            (None, None) => Ok(job.run(engine, trees, results)?),
            (None, Some(missing)) => {
                let number = |scenario: u32| missing[scenario as usize];
                let earlier = results.tally.earlier();
                let mut sink = Renumbered { sink: results, number: &number };
                let report = job.run(engine, trees, &mut sink);
                let mut report = report.map_err(|e| renumbered(e, &number, earlier))?;
                report.set_aside.iter_mut().for_each(|scenario| *scenario = number(*scenario));
                Ok(report)
            }
        }
    }
}

/// Runs the engine. Whatever comes of it, the results so far are complete files afterwards.
fn answer(
    engine: &mut dyn AnyEngine,
    trees: &Both<Tree>,
    job: &Job<'_>,
    way: &Way<'_>,
    results: &mut Results,
) -> Result<EngineReport, Failure> {
    let report = way.run(engine, trees, job, results);
    results.bar.finish_and_clear();
    let tables = results.files.as_mut().map_or(Ok(()), ResultFiles::finish_tables);
    // If both failed, the tables did so for the same reason.
    let report = report.map_err(|error| match (&results.files, error.downcast_ref()) {
        (Some(_), Some(EngineError::Sink(error))) => {
            anyhow!("{error}; what was answered before is kept, and --resume goes on after it")
        }
        _ => error,
    })?;
    tables?;
    Ok(report)
}

/// Workers know the corners of triangles; which vertex one is, only the mesh tells.
pub(super) fn naming_the_vertex(failure: Failure, moving: &TriangleMesh) -> Failure {
    let Failure::Failed(error) = failure else { return failure };
    let corner = match error.downcast_ref() {
        Some(&EngineError::Overflow { triangle, corner, .. }) => (triangle, corner),
        _ => return Failure::Failed(error),
    };
    let face = moving.faces().get(corner.0 as usize);
    Failure::Failed(match face.and_then(|face| face.get(corner.1 as usize)) {
        Some(vertex) => {
            error.context(format!("vertex {vertex} of the moving mesh cannot be placed"))
        }
        None => error,
    })
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
    if !summary.set_aside.is_empty() {
        let count = summary.set_aside.len();
        return Err(anyhow!(
            "{count} scenarios have no answer, because every worker that was at them died: {:?}; \
             all others are answered",
            summary.set_aside
        )
        .into());
    }
    if results.measured.is_some() && summary.tree_costs.len() < TreeKind::ALL.len() {
        let kept = "all scenarios were answered, but not with every kind of tree";
        return Err(Failure::Interrupted(kept.to_owned()));
    }
    Ok(())
}

/// Takes each result to where it is wanted.
struct Results {
    tally: Tally,
    /// With `--stats`.
    measured: Option<Measured>,
    /// Until the first result comes: what cannot begin must not cost an earlier run its files.
    out: Option<(OutputDir, Outputs)>,
    files: Option<ResultFiles>,
    bar: ProgressBar,
}

impl Results {
    fn new(layout: Layout, stats: bool, scenarios: usize) -> Self {
        let bar = terminal::scenario_bar("running", scenarios);
        let measured = stats.then(Measured::default);
        Self { tally: Tally::new(layout), measured, out: None, files: None, bar }
    }

    /// Keeps what an earlier run answered. Returns the scenarios that it did not.
    fn go_on(&mut self, out: OutputDir, outputs: Outputs) -> Result<Vec<u32>, OutputError> {
        let (files, earlier) = out.go_on(outputs)?;
        self.tally.add_earlier(&earlier);
        self.bar.inc(earlier.scenarios.into());
        self.files = Some(files);
        Ok(earlier.missing())
    }

    fn start_files(&mut self) -> Result<(), OutputError> {
        if let Some((out, outputs)) = self.out.take() {
            self.files = Some(out.start(outputs)?);
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
        if let Some(measured) = &mut self.measured {
            measured.add(&result);
        }
        self.bar.inc(1);
        Ok(())
    }

    fn set_aside(&mut self, _scenario: u32) -> io::Result<()> {
        self.bar.inc(1);
        Ok(())
    }
}
