//! `bumper view`: a scene, or the results of a run, as a page for a browser.

mod shown;

use std::io;
use std::num::NonZeroU32;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, anyhow};
use indicatif::ProgressBar;

use super::args::{SceneArgs, ViewArgs};
use super::deform::Crash;
use super::failure::Failure;
use super::page_server::PageServer;
use super::prepare::{Poses, Prepared};
use super::request::{cache_dir, check_effects, scene_of};
use super::run::{Job, check_crash, naming_the_vertex, start_engine};
use super::{files, interrupt, terminal};
use crate::effects::PairsAsked;
use crate::geometry::Pose;
use crate::report::viewer::{Collected, Differs, EarlierRun, MOST_SHOWN, content_security_policy};
use crate::report::{SCENARIOS, SCENE};
use crate::scene::Scene;
use crate::scheduler::client_manager::{EngineReport, ResultSink, ScenarioResult};
use crate::tree::Accuracy;
use crate::wire::Wanted;
use shown::Shown;

const DEFAULT_PAGE: &str = "bumper.html";

pub(super) fn view(args: ViewArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let (scene, earlier) = what_to_show(args.scene)?;
    let bind = |at| PageServer::bind(at).with_context(|| format!("cannot serve here: {at}"));
    let server = args.serve.map(bind).transpose()?;
    let out = args.out.or_else(|| server.is_none().then(|| DEFAULT_PAGE.into()));

    let cache_dir = args.cache_dir.or_else(cache_dir);
    let page = page_of(&scene, earlier.as_ref(), cache_dir.as_deref(), &interrupt)?;
    if let Some(out) = out {
        let name = out.display().to_string();
        files::write(&out, &page)?;
        terminal::print(&format!("{name}\n")).context("cannot print its name")?;
    }
    let Some(server) = server else { return Ok(()) };
    let address = format!("http://{}/\n", server.address());
    terminal::print(&address).context("cannot print the address")?;
    let served = server.serve(page.into_bytes(), &content_security_policy(), &interrupt);
    Ok(served.context("cannot serve the page")?)
}

/// The scene, and what an earlier run of it said, if a run's directory is given.
fn what_to_show(mut args: SceneArgs) -> Result<(Scene, Option<EarlierRun>), Failure> {
    let directory = args.scene.take_if(|path| path.is_dir());
    let earlier = match &directory {
        None => None,
        Some(directory) => {
            let scene = directory.join(SCENE);
            if !scene.is_file() {
                return Err(anyhow!(
                    "{}: has no {SCENE}, as the directory of a run has (`bumper run --out`): give the \
                     scene file",
                    directory.display()
                )
                .into());
            }
            args.scene = Some(scene);
            Some(EarlierRun::read(&directory.join(SCENARIOS))?)
        }
    };
    let mut scene = scene_of(&args)?;
    check_effects(&scene)?;
    if let Accuracy::BoxesAt(_) = scene.accuracy {
        return Err(Failure::usage(anyhow!(
            "accuracy {} finds boxes that meet, and no triangles to show: take boxes, f32, f64 or exact",
            scene.accuracy
        )));
    }
    // There is nothing to see of a pair that is not looked for.
    scene.effects.pairs = PairsAsked::Contacts;
    Ok((scene, earlier))
}

/// Runs the scene, and makes the page of what comes.
fn page_of(
    scene: &Scene,
    earlier: Option<&EarlierRun>,
    cache_dir: Option<&Path>,
    interrupt: &AtomicBool,
) -> Result<String, Failure> {
    let poses = poses_of(scene, earlier)?;
    check_crash(scene, poses.len())?;
    let mut engine = start_engine(scene, poses.len(), None)?;
    let Prepared { meshes, plan, trees, parts, poses, .. } =
        Prepared::new(scene, poses, cache_dir, interrupt)?;
    let job = Job {
        poses: &poses,
        cuts: scene.cuts(),
        wanted: Wanted {
            accuracy: scene.accuracy,
            overlap_only: false,
            pairs: scene.effects.most_pairs().min(MOST_SHOWN as u32),
            costs: false,
            plan: None,
        },
        effects: (!plan.is_empty()).then_some((&plan, &parts)),
        interrupt,
    };
    let crash = Crash::of(scene, &plan, &meshes, None);
    let mut results = Results::new(&poses, earlier);
    let answered = match &crash {
        Some(crash) => crash.run(&job, &mut *engine, &trees, &mut results).map_err(Failure::from),
        None => job
            .run(&mut *engine, &trees, &mut results)
            .map(|report| (report, None))
            .map_err(Failure::from),
    };
    results.bar.finish_and_clear();
    let (report, deformed) = answered.map_err(|error| naming_the_vertex(error, meshes.moving()))?;
    if report.interrupted {
        return Err(Failure::Interrupted("no page was written".to_owned()));
    }
    if let Some(differs) = results.differs.take() {
        return Err(anyhow::Error::from(differs).into());
    }
    warn_of_set_aside(&report);
    let activity = terminal::activity("packing");
    let shown =
        Shown { scene, plan: &plan, trees: &trees, deformed: deformed.as_ref(), poses: &poses };
    let page = shown.page(&report, results.collected, &results.workers);
    activity.finish_and_clear();
    Ok(page)
}

/// Of a run that did not come to its end, those that it came to.
fn poses_of(scene: &Scene, earlier: Option<&EarlierRun>) -> Result<Poses, Failure> {
    let poses = Poses::of(&scene.scenarios)?;
    let Some(earlier) = earlier else { return Ok(poses) };
    match NonZeroU32::new(earlier.end()) {
        Some(end) => Ok(poses.at_most(end)),
        None => {
            Err(anyhow!("the run has not answered any scenario: there is nothing to show").into())
        }
    }
}

fn warn_of_set_aside(report: &EngineReport) {
    if !report.set_aside.is_empty() {
        tracing::warn!(
            "these scenarios are not in the page, because every worker at them died: {:?}",
            report.set_aside
        );
    }
}

/// Takes what the page shows, and holds it against what was answered before.
struct Results<'a> {
    poses: &'a [Pose],
    earlier: Option<&'a EarlierRun>,
    /// The first scenario that is not answered as before.
    differs: Option<Differs>,
    collected: Collected,
    /// That answered each scenario.
    workers: Vec<Option<u32>>,
    bar: ProgressBar,
}

impl<'a> Results<'a> {
    fn new(poses: &'a [Pose], earlier: Option<&'a EarlierRun>) -> Self {
        let bar = terminal::scenario_bar("running", poses.len());
        let workers = vec![None; poses.len()];
        Self { poses, earlier, differs: None, collected: Collected::default(), workers, bar }
    }
}

impl ResultSink for Results<'_> {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        let at = result.scenario as usize;
        if let (Some(earlier), None) = (self.earlier, &self.differs) {
            self.differs = earlier.check(&result).err();
        }
        self.collected.add(&result, self.poses[at]);
        self.workers[at] = Some(result.worker);
        self.bar.inc(1);
        Ok(())
    }

    fn set_aside(&mut self, _scenario: u32) -> io::Result<()> {
        self.bar.inc(1);
        Ok(())
    }
}
