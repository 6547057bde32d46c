//! What exact answers cost over plain 64-bit floating point: both on the same scenarios in turn, in
//! one run.
//!
//! ```text
//! cargo bench --bench accuracy -- [--count N] [--runs N]
//! ```
//!
//! The scenes are those of `config/accuracy`. `BUMPER_BENCH_DATA=DIR`, for a directory with
//! `meshes/*.ply` and `poses/*.csv`, puts the vehicles there in the place of the built-in ones. The
//! exact answers of the wide trees are checked against those of the paper's.

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Result, ensure};
use bumper::effects::contacts::contacts;
use bumper::experiment::accuracy::{Load, Measured, measure};
use bumper::geometry::simd::SimdLevel;
use bumper::geometry::{Pose, TriangleTest};
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::{Scenarios, Scene, random, read_poses};
use bumper::tree::descent::Descent;
use bumper::tree::{Accuracy, BuildOptions, TreeImage, TreeKind, build};
use clap::Parser;

#[derive(Parser)]
struct Args {
    /// Scenarios of each scene, at most.
    #[arg(long, default_value = "120")]
    count: NonZeroU32,
    #[arg(long, default_value = "3")]
    runs: u32,
    /// What cargo passes to every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Scenes, and how many times the time of plain f64 exact answers should take at most.
const SCENES: [(&str, Option<f64>); 5] = [
    ("ordinary", Some(1.05)),
    ("touching", Some(1.30)),
    ("far", None),
    ("sliver", None),
    ("nearly", None),
];

fn main() -> Result<()> {
    let args = Args::parse();
    println!(
        "{:9} {:>4} {:>9} {:>9} {:>8} {:>6}",
        "", "run", "f64, us", "exact, us", "ratio", "goal"
    );
    for (name, goal) in SCENES {
        let setup = Setup::new(name, args.count)?;
        let wide = setup.images(TreeKind::Wide);
        let [fixed, moving] = wide.each_ref().map(TreeImage::view);
        let levels = [TriangleTest::F64, TriangleTest::Exact].map(Accuracy::Pairs);
        let load =
            Load { fixed, moving, poses: &setup.poses, levels: &levels, simd: SimdLevel::chosen() };
        for run in 1..=args.runs {
            let Measured { rows, .. } = measure(&load, &|| (), &AtomicBool::new(false))?;
            let [plain, exact] = [&rows[0], &rows[1]].map(|row| row.time_us.mean);
            let ratio = exact / plain;
            let goal = goal.map_or("-".to_owned(), |goal| format!("{goal:.2}"));
            println!("{name:9} {run:>4} {plain:>9.1} {exact:>9.1} {ratio:>8.3} {goal:>6}");
        }
        setup.check(&wide)?;
    }
    Ok(())
}

struct Setup {
    meshes: [TriangleMesh; 2],
    poses: Vec<Pose>,
}

impl Setup {
    fn new(name: &str, count: NonZeroU32) -> Result<Self> {
        let file = format!("config/accuracy/{name}.toml");
        let mut scene = Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file))?;
        if let (Some(data), "ordinary" | "far") = (std::env::var_os("BUMPER_BENCH_DATA"), name) {
            let data = PathBuf::from(data);
            scene.fixed.mesh = MeshSource::File(data.join("meshes/m113.ply"));
            scene.moving.mesh = MeshSource::File(data.join("meshes/audi.ply"));
            if name == "ordinary" {
                let file = data.join("poses/m113-audi.csv");
                scene.scenarios = Scenarios::Poses { file, first: None };
            }
        }
        let load = |body: &bumper::scene::Body| body.mesh.load()?.moved(body.offset);
        let meshes = [load(&scene.fixed)?, load(&scene.moving)?];
        let poses = match scene.scenarios {
            Scenarios::Poses { file, .. } => read_poses(&file, Some(count))?,
            Scenarios::Random(mut scenarios) => {
                scenarios.count = scenarios.count.min(count);
                let images = images(&meshes, TreeKind::Wide);
                let [fixed, moving] = images.each_ref().map(TreeImage::view);
                let [fixed, moving] = [(&meshes[0], &fixed), (&meshes[1], &moving)];
                random::poses(&scenarios, fixed, moving, &|| (), &AtomicBool::new(false))?
            }
        };
        Ok(Self { meshes, poses })
    }

    fn images(&self, kind: TreeKind) -> [TreeImage; 2] {
        images(&self.meshes, kind)
    }

    fn check(&self, wide: &[TreeImage; 2]) -> Result<()> {
        let obb = self.images(TreeKind::Obb);
        let mut descent = Descent::default();
        let mut answer = |images: &[TreeImage; 2], pose: &Pose| -> Result<_> {
            let mut pairs = Vec::new();
            contacts(&mut descent, &images[0].view(), &images[1].view(), pose, &mut pairs)?;
            Ok(pairs)
        };
        for (scenario, pose) in self.poses.iter().enumerate() {
            let same = answer(wide, pose)? == answer(&obb, pose)?;
            ensure!(same, "scenario {scenario}: wide and OBB trees give different pairs");
        }
        Ok(())
    }
}

fn images(meshes: &[TriangleMesh; 2], kind: TreeKind) -> [TreeImage; 2] {
    meshes.each_ref().map(|mesh| build(mesh, BuildOptions { kind }))
}
