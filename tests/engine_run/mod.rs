//! A small scene, its answers found without the engine, and runs of the engine on it.
#![allow(dead_code, reason = "each test program uses its part of this")]

use std::collections::BTreeSet;
use std::io;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bumper::effects::contacts::{contacts, pairs_fnv1a64};
use bumper::geometry::Pose;
use bumper::mesh::TriangleMesh;
use bumper::scene::{EngineOptions, WorkerCount};
use bumper::scheduler::client_manager::{
    AnyEngine, Engine, EngineError, EngineReport, ResultSink, ScenarioResult, Work, needs, start,
};
use bumper::scheduler::launch::Processes;
use bumper::transport::shared_memory::SharedMemory;
use bumper::tree::descent::{Descent, Pair};
use bumper::tree::roots::Cut;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};
use bumper::wire::Wanted;

/// Scenario, number of pairs, their hash, the pairs.
pub type Answer = (u32, u32, u64, Vec<Pair>);

pub struct Scene {
    pub fixed: Arc<TreeImage>,
    pub moving: Arc<TreeImage>,
    pub poses: Vec<Pose>,
}

/// A sphere of about radius 1 with dents, in `2 * rings * rings` triangles.
fn dented_sphere(rings: u32, dents: f64) -> TriangleMesh {
    let angle = |i: u32| f64::from(i) / f64::from(rings) * std::f64::consts::PI;
    let mut vertices = Vec::new();
    for (i, j) in (0..=rings).flat_map(|i| (0..rings).map(move |j| (i, j))) {
        let (polar, azimuth) = (angle(i), 2.0 * angle(j));
        let radius = 1.0 + 0.05 * (dents * polar).sin() * (dents * azimuth).cos();
        vertices.push([
            radius * polar.sin() * azimuth.cos(),
            radius * polar.sin() * azimuth.sin(),
            radius * polar.cos(),
        ]);
    }
    let at = |i: u32, j: u32| i * rings + j % rings;
    let faces = (0..rings).flat_map(|i| (0..rings).map(move |j| (i, j))).flat_map(|(i, j)| {
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    });
    TriangleMesh::new(vertices, faces.collect()).unwrap()
}

impl Scene {
    /// Two spheres of `2 * rings * rings` triangles in `scenarios` poses, from touching nowhere to
    /// deep inside each other.
    pub fn new(rings: u32, scenarios: u32) -> Self {
        Self::of_kind(TreeKind::Obb, rings, scenarios)
    }

    pub fn of_kind(kind: TreeKind, rings: u32, scenarios: u32) -> Self {
        let options = BuildOptions { kind };
        let poses = (0..scenarios).map(|n| {
            let t = f64::from(n);
            let half = 0.37 * t;
            let quaternion = [half.cos(), half.sin() * 0.6, 0.0, half.sin() * 0.8];
            let distance = 1.2 + 0.5 * (1.0 + (0.73 * t).sin());
            Pose::from_quaternion(quaternion, [distance * t.cos(), distance * t.sin(), 0.1])
        });
        Self {
            fixed: Arc::new(build(&dented_sphere(rings, 7.0), options)),
            moving: Arc::new(build(&dented_sphere(rings, 5.0), options)),
            poses: poses.collect(),
        }
    }

    /// Answered one after the other in this process.
    pub fn truth(&self) -> Vec<Answer> {
        let (mut descent, mut pairs) = (Descent::default(), Vec::new());
        let (fixed, moving) = (self.fixed.view(), self.moving.view());
        (0..)
            .zip(&self.poses)
            .map(|(scenario, pose)| {
                contacts(&mut descent, &fixed, &moving, pose, &mut pairs).unwrap();
                (scenario, pairs.len() as u32, pairs_fnv1a64(&pairs), pairs.clone())
            })
            .collect()
    }

    /// One run of an engine that was started for it.
    pub fn run_on(
        &self,
        engine: &mut dyn AnyEngine,
        options: &Options,
        sink: &mut dyn ResultSink,
        interrupt: &AtomicBool,
    ) -> Result<EngineReport, EngineError> {
        let fixed = engine.add_mesh(Arc::clone(&self.fixed))?;
        let moving = engine.add_mesh(Arc::clone(&self.moving))?;
        let [fixed_cut, moving_cut] = options.cuts;
        let work = Work {
            effects: None,
            fixed: (fixed, fixed_cut),
            moving: (moving, moving_cut),
            poses: &self.poses,
            wanted: options.wanted,
        };
        let report = engine.run(&work, sink, interrupt)?;
        engine.remove_mesh(fixed)?;
        engine.remove_mesh(moving)?;
        Ok(report)
    }

    /// Over whatever transport the options name.
    pub fn run(&self, options: &Options) -> (EngineReport, Vec<Answer>) {
        let mut recorder = Recorder::new(|_| Ok(()));
        let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
        let interrupt = AtomicBool::new(false);
        let report = self.run_on(&mut *engine, options, &mut recorder, &interrupt).unwrap();
        (report, recorder.answers)
    }
}

#[derive(Clone)]
pub struct Options {
    pub engine: EngineOptions,
    /// Of the fixed and of the moving tree.
    pub cuts: [Cut; 2],
    pub wanted: Wanted,
    /// What a worker process runs.
    pub program: PathBuf,
}

pub fn options(workers: u32) -> Options {
    Options {
        engine: EngineOptions {
            workers: Some(WorkerCount::new(workers.into()).unwrap()),
            buffer_scenarios: NonZeroU32::new(5).unwrap(),
            ..EngineOptions::default()
        },
        cuts: [Cut::Depth(5), Cut::Depth(4)],
        wanted: Wanted { pairs: Wanted::ALL_PAIRS, ..Wanted::default() },
        program: env!("CARGO_BIN_EXE_bumper").into(),
    }
}

/// Keeps results, after `on_result` has seen each.
pub struct Recorder<F> {
    pub answers: Vec<Answer>,
    pub set_aside: Vec<u32>,
    on_result: F,
}

impl<F: FnMut(u32) -> io::Result<()>> Recorder<F> {
    pub fn new(on_result: F) -> Self {
        Self { answers: Vec::new(), set_aside: Vec::new(), on_result }
    }
}

impl<F: FnMut(u32) -> io::Result<()>> ResultSink for Recorder<F> {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        (self.on_result)(result.scenario)?;
        let ScenarioResult { scenario, pair_count, pairs_fnv1a64, pairs, .. } = result;
        self.answers.push((scenario, pair_count, pairs_fnv1a64, pairs.to_vec()));
        Ok(())
    }

    fn set_aside(&mut self, scenario: u32) -> io::Result<()> {
        self.set_aside.push(scenario);
        Ok(())
    }
}

/// Where a run has its files.
pub struct Place {
    base: PathBuf,
    /// Removed with everything in it.
    _made: Option<tempfile::TempDir>,
}

impl Place {
    pub fn new() -> Self {
        let made = tempfile::tempdir().unwrap();
        Self { base: made.path().to_owned(), _made: Some(made) }
    }

    /// One that there is already.
    pub fn at(base: &Path) -> Self {
        Self { base: base.to_owned(), _made: None }
    }

    pub fn base(&self) -> &Path {
        &self.base
    }

    /// Runs the engine here on shared memory, then checks that nothing of it is left: no process,
    /// no file.
    pub fn run(
        &self,
        scene: &Scene,
        options: &Options,
        interrupt: &AtomicBool,
        mut on_result: impl FnMut(u32) -> io::Result<()>,
    ) -> (Result<EngineReport, EngineError>, Vec<Answer>) {
        let transport = SharedMemory::create(self.base(), &needs(&options.engine)).unwrap();
        let prefixes = self.prefixes();
        assert!(!shared_memory_files(&prefixes).is_empty(), "cannot see the run's files");
        let mut recorder = Recorder::new(&mut on_result);
        let processes = Processes { program: options.program.clone() };
        let engine = Engine::start(transport, processes, options.engine.clone());
        let report = engine
            .and_then(|mut engine| scene.run_on(&mut engine, options, &mut recorder, interrupt));
        assert_eq!(shared_memory_files(&prefixes), [""; 0]);
        assert_eq!(self.prefixes(), [""; 0]);
        assert_eq!(self.workers(), BTreeSet::new());
        (report, recorder.answers)
    }

    /// Prefixes in shared memory of the runs that have a directory here.
    pub fn prefixes(&self) -> Vec<String> {
        let is_directory = |name: &String| self.base().join(name).is_dir();
        let Some(home) = names(self.base()).into_iter().find(is_directory) else {
            return Vec::new();
        };
        let runs = names(&self.base().join(&home)).into_iter();
        let user = home.replace('-', "_");
        runs.filter_map(|run| Some(format!("{user}_{}_", run.strip_prefix("run-")?))).collect()
    }

    /// Processes that were told of this place and have not ended.
    pub fn workers(&self) -> BTreeSet<u32> {
        let base = self.base().as_os_str().as_encoded_bytes();
        let ids = names(Path::new("/proc")).into_iter().filter_map(|name| name.parse().ok());
        ids.filter(|pid: &u32| {
            let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
            line.windows(base.len()).any(|window| window == base)
        })
        .collect()
    }
}

pub fn shared_memory_files(prefixes: &[String]) -> Vec<String> {
    let files = names(Path::new("/dev/shm")).into_iter();
    files.filter(|file| prefixes.iter().any(|prefix| file.starts_with(prefix))).collect()
}

fn names(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// Whether there was such a process.
pub fn signal(pid: u32, signal: &str) -> bool {
    let mut command = std::process::Command::new("kill");
    command.args([signal, &pid.to_string()]).stderr(std::process::Stdio::null());
    command.status().unwrap().success()
}

/// Returns when the process has no memory any more.
pub fn kill(pid: u32) {
    assert!(signal(pid, "-KILL"), "no process {pid}");
    while std::fs::read(format!("/proc/{pid}/cmdline")).is_ok_and(|line| !line.is_empty()) {
        std::thread::yield_now();
    }
}

/// Runs the named test of this test program in a process of its own, in another role.
pub fn in_role(test: &str, role: &str) -> std::process::Command {
    let program: PathBuf = std::env::current_exe().unwrap();
    let mut command = std::process::Command::new(program);
    command.args(["--exact", test, "--nocapture"]).env("BUMPER_TEST_ROLE", role);
    command
}

pub fn role() -> Option<String> {
    std::env::var("BUMPER_TEST_ROLE").ok()
}
