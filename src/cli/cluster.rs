//! `bumper cluster`: a cluster in simulation.

mod output;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, anyhow};

use super::args::ClusterArgs;
use super::failure::Failure;
use super::files::{make_folder, write};
use super::prepare::{self, Both, Poses, Tree};
use super::report::write_output;
use super::{interrupt, request, terminal};
use crate::experiment::cluster::config::{AnalysisCost, Config};
use crate::experiment::cluster::record::{self, RecordError};
use crate::experiment::cluster::recording::{Recording, RecordingError, Subject};
use crate::experiment::cluster::sweep::{self, Progress};
use crate::experiment::cluster::validate::{self, ValidateError, Validated};
use crate::experiment::cluster::{figures, line, saturations, tables};
use crate::experiment::latency::LatencyError;
use crate::experiment::throughput::{self, ThroughputError};
use crate::geometry::Pose;
use crate::report::source::Source;
use crate::scene::Scene;
use crate::tree::roots::Cut;
use crate::tree::{BuildOptions, TreeKind};
use output::ClusterReport;

pub(super) fn run(args: &ClusterArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let config = Config::read(&args.config).map_err(request::unreadable)?;
    if args.validate && !config.is_one_node_as_recorded() {
        return Err(Failure::usage(anyhow!(
            "--validate: this machine can stand for a cluster of one node with the master on it, \
             and `scale` absent"
        )));
    }
    if let Some(out) = &args.out {
        make_folder(out)?;
    }
    let subject = Prepared::new(&config, &interrupt)?;
    let recording = recording(&subject, &config, args, &interrupt)?;
    let validated =
        if args.validate { subject.validate(&config, &recording, &interrupt)? } else { Vec::new() };
    let bar = terminal::scenario_bar("simulating", sweep::scenarios(&config));
    let progress = |progress: Progress<'_>| match progress {
        Progress::Answered(scenarios) => bar.inc(scenarios as u64),
        Progress::Finished(run) => terminal::tell(&line(&config, run)),
    };
    let simulated = sweep::run(&config, &recording, &progress, &interrupt);
    bar.finish_and_clear();
    let simulated = simulated.ok_or_else(interrupt::before_results)?;
    let mut tables = tables(&config, &simulated);
    tables.extend(output::messages_table(&validated));
    tables.extend(output::validation_table(&validated));
    let report = ClusterReport::new(
        &config.name,
        &recording,
        figures(&config, &simulated),
        tables,
        saturations(&config, &simulated),
        validated,
        simulated,
    );
    let json = report.to_json();
    if let Some(out) = &args.out {
        write_output(out, Source::Cluster, &json)?;
    }
    let text = if args.json { json } else { report.text() };
    Ok(terminal::print(&text).context("cannot print the figures")?)
}

/// The configuration's scene, ready to be run.
struct Prepared {
    scene: Scene,
    trees: Both<Tree>,
    poses: Vec<Pose>,
    subject: Subject,
}

impl Prepared {
    fn new(config: &Config, interrupt: &AtomicBool) -> Result<Self, Failure> {
        let scene = request::scene(config.scene.as_deref())?;
        if config.scale.analysis == AnalysisCost::BoxTests && scene.tree != TreeKind::Obb {
            return Err(Failure::usage(anyhow!(
                "`scale.analysis`: boxes are counted in trees of kind obb, and the scene has {} \
                 trees",
                scene.tree
            )));
        }
        let poses = Poses::of(&scene.scenarios)?;
        let meshes = prepare::load(&scene)?;
        interrupt::check(interrupt)?;
        let trees = prepare::build(&meshes, BuildOptions { kind: scene.tree }, None);
        let poses = poses.place(&meshes, &trees, interrupt)?;
        interrupt::check(interrupt)?;
        let subject = Subject::of([meshes.fixed(), meshes.moving()], &poses, scene.tree);
        Ok(Self { scene, trees, poses, subject })
    }

    fn record(&self, cuts: &[[u32; 2]], interrupt: &AtomicBool) -> Result<Recording, Failure> {
        let scene = record::Scene {
            subject: self.subject.clone(),
            fixed: Arc::clone(&self.trees.fixed().image),
            moving: Arc::clone(&self.trees.moving().image),
            poses: &self.poses,
        };
        let bar = terminal::scenario_bar("recording", self.poses.len() * (1 + cuts.len()));
        let recording = record::record(&scene, cuts, &|| bar.inc(1), interrupt);
        bar.finish_and_clear();
        recording.map_err(|error| match error {
            RecordError::Interrupted => interrupt::before_results(),
            other => other.into(),
        })
    }

    /// Runs the scene for real, beside its simulation.
    fn validate(
        &self,
        config: &Config,
        recording: &Recording,
        interrupt: &AtomicBool,
    ) -> Result<Vec<Validated>, Failure> {
        let [fixed_depth, moving_depth] = config.run.point.depths;
        let load = throughput::Load {
            fixed: (Arc::clone(&self.trees.fixed().image), Cut::Depth(fixed_depth)),
            moving: (Arc::clone(&self.trees.moving().image), Cut::Depth(moving_depth)),
            poses: &self.poses,
            engine: self.scene.engine.clone(),
            program: std::env::current_exe().context("cannot find my own executable")?,
        };
        let activity = terminal::activity("measuring");
        let validated = validate::validate(config, recording, &load, interrupt);
        activity.finish_and_clear();
        validated.map_err(|error| match error {
            ValidateError::Latency(LatencyError::Interrupted)
            | ValidateError::Throughput(ThroughputError::Interrupted) => {
                interrupt::before_results()
            }
            other => other.into(),
        })
    }
}

/// The recording of the file if it fits the scene, otherwise a new one, which the file keeps.
fn recording(
    prepared: &Prepared,
    config: &Config,
    args: &ClusterArgs,
    interrupt: &AtomicBool,
) -> Result<Recording, Failure> {
    let cuts = config.cuts();
    if let Some(kept) = args.recording.as_deref().map(kept).transpose()?.flatten() {
        let has_cuts = cuts.iter().all(|&depths| kept.cut(depths).is_some());
        if kept.subject == prepared.subject && has_cuts {
            return Ok(kept);
        }
        tracing::warn!("the recording is of another scene, program or depth, and is made anew");
    }
    let recording = prepared.record(&cuts, interrupt)?;
    if let Some(path) = &args.recording {
        write(path, recording.to_json())?;
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
