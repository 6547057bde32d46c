//! What each effect costs, and what a scene pays that asks for none.
//!
//! ```text
//! cargo bench --bench effects -- [--count N] [--rounds N]
//! ```
//!
//! On the built-in vehicles, or on those of `BUMPER_BENCH_DATA=DIR`, a directory with `meshes/*.ply`.
//! First overlap alone: a worker's time for it, with everything that could be asked for and is not,
//! over that of the bare kernel call on the same poses in turn, and the same for all contacts. Then
//! every effect by itself, one scenario after the other. Answers are checked: those of workers against
//! the kernel's, and what an effect says against what the others know.

use std::collections::BTreeMap;
use std::io;
use std::num::NonZeroU32;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use bumper::effects::contacts::{contacts, pairs_fnv1a64};
use bumper::effects::layout::ABSENT;
use bumper::effects::{Effects, Question};
use bumper::geometry::Pose;
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::{EngineOptions, Scene, Transport, WorkerCount, random};
use bumper::scheduler::client_manager::{AnyEngine, ResultSink, ScenarioResult, Work, start};
use bumper::tree::descent::Descent;
use bumper::tree::roots::Cut;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};
use bumper::wire::Wanted;
use clap::Parser;

#[derive(Parser)]
struct Args {
    /// Scenarios.
    #[arg(long, default_value = "200")]
    count: NonZeroU32,
    /// Of worker and kernel in turn; the best of each counts.
    #[arg(long, default_value = "7")]
    rounds: u32,
    /// What cargo passes to every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Poses are random, with some drawn away so that they are apart.
const SCENE: &str = r#"
version = 1
[fixed]
mesh = "builtin:tracked"
mass_kg = 11000.0
inertia_kg_m2 = [10000.0, 30000.0, 35000.0]
stiffness = { a_n_m = 80000.0, b_n_m2 = 900000.0 }
[moving]
mesh = "builtin:car"
mass_kg = 1500.0
inertia_kg_m2 = [600.0, 2500.0, 2800.0]
stiffness = { a_n_m = 40000.0, b_n_m2 = 500000.0 }
[scenarios]
random = { count = 1 }
"#;

/// What is added to the scene for each effect.
const EFFECTS: [(&str, &str); 9] = [
    ("contacts.segments", "[effects]\nsegments = true"),
    ("containment", "[effects]\ncontainment = true"),
    ("clearance", "[effects]\nclearance = true"),
    ("clearance, 10 cm margin", "[effects]\nclearance = { margin_m = 0.1 }"),
    ("penetration along x", "[effects]\npenetration = { direction = [1.0, 0.0, 0.0] }"),
    ("penetration, least", "[effects]\npenetration = { directions = 16 }"),
    ("motion, 1 s at 60 km/h", "[motion]\nduration_s = 1.0"),
    ("response", "[effects]\nresponse = true"),
    ("crush", "[effects]\ncrush = { width_m = 1.5 }"),
];

fn main() -> Result<()> {
    let args = Args::parse();
    let setup = Setup::new(args.count)?;
    setup.nothing_asked_for(args.rounds)?;
    setup.each_effect()
}

struct Setup {
    meshes: [TriangleMesh; 2],
    images: [Arc<TreeImage>; 2],
    poses: Vec<Pose>,
}

impl Setup {
    fn new(count: NonZeroU32) -> Result<Self> {
        let data = std::env::var_os("BUMPER_BENCH_DATA");
        let source = |builtin: &str, name: &str| match &data {
            Some(folder) => {
                Path::new(folder).join(format!("meshes/{name}.ply")).display().to_string()
            }
            None => builtin.to_owned(),
        };
        let sources = [source("builtin:tracked", "m113"), source("builtin:car", "audi")];
        println!("{} against {}, {count} scenarios\n", sources[0], sources[1]);
        let [fixed, moving] = sources.map(|text| text.parse::<MeshSource>()?.load());
        let meshes = [fixed?, moving?];
        let options = BuildOptions { kind: TreeKind::Wide };
        let images = meshes.each_ref().map(|mesh| Arc::new(build(mesh, options)));
        let scene = Scene::embedded_default();
        let bumper::scene::Scenarios::Random(random) = scene.scenarios else {
            unreachable!("the default scene is random")
        };
        let views = images.each_ref().map(|image| image.view());
        let random = random::RandomScenarios { count, ..random };
        let (fixed, moving) = ((&meshes[0], &views[0]), (&meshes[1], &views[1]));
        let mut poses = random::poses(&random, fixed, moving, &|| {}, &AtomicBool::new(false))?;
        // Every third one is drawn back from the centre, so that it touches nothing.
        for pose in poses.iter_mut().step_by(3) {
            let length = pose.translation.iter().map(|c| c * c).sum::<f64>().sqrt();
            pose.translation = pose.translation.map(|c| c * (1.0 + 1.0 / length));
        }
        Ok(Self { meshes, images, poses })
    }

    /// A worker's time over the kernel's.
    fn nothing_asked_for(&self, rounds: u32) -> Result<()> {
        println!("{:24}{:>12}{:>12}{:>9}", "no effects", "kernel, us", "worker, us", "ratio");
        let options = EngineOptions {
            workers: Some(WorkerCount::new(1)?),
            transport: Transport::Threads,
            // One batch, so that the master sleeps while the worker computes: what they cost each
            // other is for `bumper bench engine`.
            buffer_scenarios: NonZeroU32::new(self.poses.len() as u32).expect("there are some"),
            ..EngineOptions::default()
        };
        let mut engine = start(options, std::env::current_exe()?)?;
        let [fixed, moving] =
            self.images.each_ref().map(|image| engine.add_mesh(Arc::clone(image)));
        let (fixed, moving) = ((fixed?, Cut::Depth(0)), (moving?, Cut::Depth(0)));
        for (name, overlap_only) in [("overlap", true), ("contacts", false)] {
            let wanted = Wanted { overlap_only, ..Wanted::default() };
            let poses = &self.poses;
            let work = Work { fixed, moving, poses, wanted, effects: None };
            let mut best = [f64::INFINITY; 2];
            for _ in 0..rounds {
                let (answers, kernel_s) = self.kernel(overlap_only)?;
                let (theirs, worker_s) = worker(&mut *engine, &work)?;
                ensure!(answers == theirs, "{name}: the worker has other answers");
                best = [best[0].min(kernel_s), best[1].min(worker_s)];
            }
            let [kernel, worker] = best.map(|s| s * 1e6 / poses.len() as f64);
            println!("{name:24}{kernel:12.2}{worker:12.2}{:9.3}", worker / kernel);
        }
        Ok(())
    }

    fn kernel(&self, overlap_only: bool) -> Result<(Vec<(u32, u64)>, f64)> {
        let [fixed, moving] = self.images.each_ref().map(|image| image.view());
        let (mut descent, mut pairs, mut answers) = (Descent::default(), Vec::new(), Vec::new());
        let mut seconds = 0.0;
        for pose in &self.poses {
            let begin = Instant::now();
            pairs.clear();
            let count = if overlap_only {
                descent.any_pair(&fixed, &moving, pose)?.into()
            } else {
                contacts(&mut descent, &fixed, &moving, pose, &mut pairs)?;
                pairs.len() as u32
            };
            let hash = pairs_fnv1a64(&pairs);
            seconds += begin.elapsed().as_secs_f64();
            answers.push((count, hash));
        }
        Ok((answers, seconds))
    }

    fn each_effect(&self) -> Result<()> {
        println!(
            "\n{:24}{:>12}{:>12}{:>12}{:>12}",
            "effect", "scenarios", "mean, us", "median, us", "p99, us"
        );
        for (name, lines) in EFFECTS {
            let moving = if name.starts_with("motion") || name == "response" || name == "crush" {
                "[moving]\nvelocity_m_s = [16.667, 0.0, 0.0]"
            } else {
                "[moving]"
            };
            let mut text = SCENE.replace("[moving]", moving);
            if name.starts_with("motion")
                || lines.contains("effects") && !moving.contains("velocity")
            {
                // Masses would call for an impact.
                let is_physics =
                    |line: &&str| line.starts_with("mass") || line.starts_with("inertia");
                text = text
                    .lines()
                    .filter(|line| !is_physics(line))
                    .map(|line| format!("{line}\n"))
                    .collect();
            }
            self.effect(name, &(text + lines))?;
        }
        Ok(())
    }

    fn effect(&self, name: &str, text: &str) -> Result<()> {
        let scene = Scene::parse(text, name, Path::new(""))?;
        let plan = scene.effects.plan([&self.meshes[0], &self.meshes[1]]);
        let plan = plan.with_context(|| format!("{name} cannot be asked of these meshes"))?;
        let layout = plan.layout();
        let mut effects = Effects::new(plan);
        let trees = self.images.each_ref().map(|image| image.view());
        let (mut descent, mut pairs, mut words) = (Descent::default(), Vec::new(), Vec::new());
        let mut times = Vec::new();
        for pose in &self.poses {
            contacts(&mut descent, &trees[0], &trees[1], pose, &mut pairs)?;
            words.clear();
            let question =
                Question { trees, parts: &[], pose: *pose, pairs: &pairs, descent: &mut descent };
            effects.run(question, !pairs.is_empty(), &mut words)?;
            let said = layout.read(&words)?;
            let cost = said.costs().last().expect("the effect is the last step");
            if cost.ns > 0 {
                times.push(cost.ns as f64 * 1e-3);
            }
            let said: BTreeMap<_, _> = said.columns().map(|(c, word)| (c.name, word)).collect();
            check(&said, pairs.len()).with_context(|| name.to_owned())?;
        }
        times.sort_unstable_by(f64::total_cmp);
        let quantile = |q: f64| times[((times.len() - 1) as f64 * q).round() as usize];
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        println!(
            "{name:24}{:12}{mean:12.1}{:12.1}{:12.1}",
            times.len(),
            quantile(0.5),
            quantile(0.99)
        );
        Ok(())
    }
}

/// What must hold between what an effect says and the pairs.
fn check(said: &BTreeMap<&str, u64>, pairs: usize) -> Result<()> {
    let number = |name| {
        let word = said.get(name).copied().filter(|&word| word != ABSENT);
        word.map(f64::from_bits)
    };
    if let Some(clearance) = number("clearance_m") {
        ensure!(clearance > 0.0 && pairs == 0, "clearance {clearance} with {pairs} pairs");
    }
    if let Some(depth) = number("penetration_depth_m").or(number("least_translation_m")) {
        ensure!(depth >= 0.0 && pairs > 0, "depth {depth} with {pairs} pairs");
    }
    if let Some(time) = number("impact_time_s") {
        ensure!((time == 0.0) == (pairs > 0), "impact after {time} s with {pairs} pairs");
    }
    if let Some(loss) = number("energy_loss_j") {
        let halves = [number("fixed_crush_energy_j"), number("moving_crush_energy_j")];
        if let [Some(a), Some(b)] = halves {
            ensure!((a + b - loss).abs() <= 1e-9 * loss.abs(), "{a} J and {b} J are not {loss} J");
        }
    }
    Ok(())
}

fn worker(engine: &mut dyn AnyEngine, work: &Work<'_>) -> Result<(Vec<(u32, u64)>, f64)> {
    let mut answers = Answers::default();
    engine.run(work, &mut answers, &AtomicBool::new(false))?;
    Ok((answers.answers, answers.compute_ns as f64 * 1e-9))
}

#[derive(Default)]
struct Answers {
    answers: Vec<(u32, u64)>,
    compute_ns: u64,
}

impl ResultSink for Answers {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        self.answers.push((result.pair_count, result.pairs_fnv1a64));
        self.compute_ns += result.compute_ns;
        Ok(())
    }

    fn set_aside(&mut self, scenario: u32) -> io::Result<()> {
        Err(io::Error::other(format!("nobody answers scenario {scenario}")))
    }
}
