//! `bumper cluster`: a cluster in simulation.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, anyhow};

use super::args::ClusterArgs;
use super::failure::Failure;
use super::prepare::{self, Poses};
use super::{interrupt, terminal};
use crate::experiment::cluster::config::Config;
use crate::experiment::cluster::record::{self, RecordError};
use crate::experiment::cluster::recording::{Recording, RecordingError, Subject};
use crate::experiment::cluster::sweep;
use crate::scene::{Scene, SceneError};
use crate::tree::BuildOptions;

pub(super) fn run(args: &ClusterArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let config = Config::read(&args.config).map_err(unreadable)?;
    if let Some(out) = &args.out {
        let unusable = || format!("{}: cannot be written to", out.display());
        std::fs::create_dir_all(out).with_context(unusable)?;
    }
    let recording = recording(&config, args, &interrupt)?;
    let bar = terminal::scenario_bar("simulating", sweep::count(&config));
    let simulated = sweep::run(&config, &recording, &|| bar.inc(1), &interrupt);
    bar.finish_and_clear();
    let simulated = simulated.ok_or_else(interrupt::before_results)?;
    let mut text = String::new();
    for s in &simulated {
        let u = &s.samples[0].utilisation;
        text += &format!(
            "{:?} {:>8.2} {:10} {:8} speedup {:6.2} over_first {:6.2}/{:.1} rdt {:8.3} T {:9.3} master {:.2} (an {:.2} ma {:.2} se {:.2}) blocked {:.2} link {:.2} comp {:.2} place {:.2} mem {:.2} tasks {}\n",
            s.varied, s.x, s.matchmaker.name(), s.copies.name(), s.mean(|o| o.speedup), s.mean(|o| o.over_first), s.samples[0].bound,
            s.mean(|o| o.relative_data_transfer), s.mean(|o| o.time_s), u.master, u.master_analysis, u.master_matching, u.master_sending, u.master_blocked, u.link, u.computing, u.placing, s.samples[0].memory.fullest, s.samples[0].tasks,
        );
    }
    Ok(terminal::print(&text).context("cannot print the figures")?)
}

fn unreadable(error: SceneError) -> Failure {
    match error {
        SceneError::Read { .. } => Failure::from(error),
        SceneError::Invalid { .. } => Failure::usage(error),
    }
}

/// The recording of the file if it fits the scene, otherwise a new one, which the file keeps.
fn recording(
    config: &Config,
    args: &ClusterArgs,
    interrupt: &AtomicBool,
) -> Result<Recording, Failure> {
    let scene = match &config.scene {
        None => Scene::embedded_default(),
        Some(path) => Scene::read(path).map_err(unreadable)?,
    };
    let poses = Poses::of(&scene.scenarios)?;
    let meshes = prepare::load(&scene)?;
    let trees = prepare::build(&meshes, BuildOptions { kind: scene.tree }, None);
    let poses = poses.place(&meshes, &trees, interrupt)?;
    interrupt::check(interrupt)?;
    let subject = Subject::of([meshes.fixed(), meshes.moving()], &poses, scene.tree);
    let cuts = config.cuts();
    if let Some(kept) = args.recording.as_deref().map(kept).transpose()?.flatten() {
        if kept.subject == subject && cuts.iter().all(|&depths| kept.cut(depths).is_some()) {
            return Ok(kept);
        }
        tracing::warn!("the recording is of another scene, program or depths, and is made anew");
    }
    let scene = record::Scene {
        subject,
        fixed: Arc::clone(&trees.fixed().image),
        moving: Arc::clone(&trees.moving().image),
        poses: &poses,
    };
    let bar = terminal::scenario_bar("recording", poses.len() * (1 + cuts.len()));
    let recording = record::record(&scene, &cuts, &|| bar.inc(1), interrupt);
    bar.finish_and_clear();
    let recording = recording.map_err(|error| match error {
        RecordError::Interrupted => interrupt::before_results(),
        other => other.into(),
    })?;
    if let Some(path) = &args.recording {
        let unwritable = || format!("cannot write {}", path.display());
        std::fs::write(path, recording.to_json()).with_context(unwritable)?;
    }
    Ok(recording)
}

/// What the file has; nothing if there is no file, or one of another version.
fn kept(path: &Path) -> Result<Option<Recording>, Failure> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(anyhow!("cannot read {}: {error}", path.display()).into()),
    };
    match Recording::parse(&text) {
        Ok(recording) => Ok(Some(recording)),
        Err(RecordingError::Version { found }) => {
            tracing::warn!("{}: a recording of version {found} is made anew", path.display());
            Ok(None)
        }
        Err(error) => Err(Failure::usage(anyhow!("{}: {error}", path.display()))),
    }
}
