//! What refitting a tree to vertices that have moved costs beside building it anew.
//!
//! ```text
//! cargo bench --bench refit -- [--rounds N] [--count N]
//! ```
//!
//! On the vehicles of `BUMPER_BENCH_DATA=DIR`, a directory with `meshes/*.ply` and `poses/*.csv`, and
//! on the built-in ones. A vehicle is dented at its front, or bent as a whole, so that every vertex
//! moves. Both ways to its tree are timed in turn, on all cores, by the clock. The pairs of a query on
//! either tree are checked against each other; how much longer the refitted one's queries take is
//! the price of keeping a tree's shape.

#[path = "kernel/poses.rs"]
#[expect(dead_code, reason = "near misses are for the kernel's own benchmark")]
mod poses;
#[path = "kernel/timing.rs"]
#[expect(dead_code, reason = "a query is summed up by its mean")]
mod timing;

use std::hint::black_box;
use std::num::NonZeroU32;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use bumper::geometry::{Point, Pose};
use bumper::mesh::{Dent, MeshSource, TriangleMesh, deform};
use bumper::scene::read_poses;
use bumper::tree::descent::Descent;
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build, refit};
use clap::Parser;
use timing::Timings;

#[derive(Parser)]
struct Args {
    /// Timed builds, and refits, of each tree.
    #[arg(long, default_value = "9")]
    rounds: NonZeroU32,
    /// Poses of the query that is checked.
    #[arg(long, default_value = "100")]
    count: NonZeroU32,
    /// What cargo passes to every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<()> {
    let args = Args::parse();
    study(["builtin:tracked", "builtin:car"], None, &args)?;
    if let Some(directory) = std::env::var_os("BUMPER_BENCH_DATA") {
        let directory = Path::new(&directory);
        let [fixed, moving] =
            ["m113", "audi"].map(|name| directory.join(format!("meshes/{name}.ply")));
        let sources = [&*fixed.to_string_lossy(), &*moving.to_string_lossy()];
        study(sources, Some(&directory.join("poses/m113-audi.csv")), &args)?;
    }
    Ok(())
}

fn study(sources: [&str; 2], poses: Option<&Path>, args: &Args) -> Result<()> {
    let load = |source: &str| -> Result<TriangleMesh> { Ok(source.parse::<MeshSource>()?.load()?) };
    let [fixed, moving] = [load(sources[0])?, load(sources[1])?];
    let wide = BuildOptions { kind: TreeKind::Wide };
    let poses = match poses {
        Some(path) => read_poses(path, Some(args.count))?,
        None => {
            let trees = (build(&fixed, wide), build(&moving, wide));
            poses::random((&fixed, &trees.0), (&moving, &trees.1), args.count)?
        }
    };
    let cores = std::thread::available_parallelism()?;
    println!("\n{} ({} triangles), {cores} cores", sources[0], fixed.faces().len());
    println!(
        "{:5} {:6} {:>9} {:>9} {:>9} {:>7} {:>14} {:>7}",
        "kind", "motion", "vertices", "build ms", "refit ms", "ratio", "query us", "ratio"
    );
    let deformed = [("none", fixed.clone()), ("dent", dented(&fixed)?), ("bend", bent(&fixed)?)];
    for kind in TreeKind::ALL.into_iter().rev() {
        let before = build(&fixed, BuildOptions { kind });
        let moving = build(&moving, BuildOptions { kind });
        for (name, mesh) in &deformed {
            let trees = timed_trees(&before, mesh, kind, args.rounds)?;
            print!("{kind:5} {name:6} {:8.1}% ", 100.0 * moved(&fixed, mesh));
            trees.print();
            query([&trees.built, &trees.refitted], &moving, &poses)?;
        }
    }
    Ok(())
}

/// Pushed in by a twelfth of its length at the far end, over a third of its width.
fn dented(mesh: &TriangleMesh) -> Result<TriangleMesh> {
    let (low, high) = bounds(mesh);
    let extent = |k: usize| high[k] - low[k];
    let (along, across) = if extent(0) > extent(1) { (0, 1) } else { (1, 0) };
    let mut inward = [0.0; 3];
    inward[along] = -1.0;
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let (width, depth) = (extent(across) / 3.0, extent(along) / 12.0);
    let dent = Dent::new(middle, inward, width, None, depth, 0.5 * depth)?;
    Ok(deform(mesh, &dent)?)
}

/// Sideways by a wave along the vehicle, of a hundredth of its size.
fn bent(mesh: &TriangleMesh) -> Result<TriangleMesh> {
    let (low, high) = bounds(mesh);
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let bend = |v: &Point| {
        let wave = 5.0 * (v[0] - low[0]) / size;
        [v[0], v[1] + 0.01 * size * wave.sin(), v[2] + 0.004 * size * wave.cos()]
    };
    Ok(TriangleMesh::new(mesh.vertices().iter().map(bend).collect(), mesh.faces().to_vec())?)
}

fn bounds(mesh: &TriangleMesh) -> (Point, Point) {
    mesh.vertices().iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), v| {
        ([0, 1, 2].map(|k| low[k].min(v[k])), [0, 1, 2].map(|k| high[k].max(v[k])))
    })
}

/// The share of the vertices.
fn moved(before: &TriangleMesh, after: &TriangleMesh) -> f64 {
    let pairs = before.vertices().iter().zip(after.vertices());
    pairs.filter(|(v, w)| v != w).count() as f64 / before.vertices().len() as f64
}

struct Trees {
    built: TreeImage,
    refitted: TreeImage,
    build: Vec<Duration>,
    refit: Vec<Duration>,
}

fn timed_trees(
    before: &TreeImage,
    mesh: &TriangleMesh,
    kind: TreeKind,
    rounds: NonZeroU32,
) -> Result<Trees> {
    let mut trees = Trees {
        built: build(mesh, BuildOptions { kind }),
        refitted: before.clone(),
        build: Vec::new(),
        refit: Vec::new(),
    };
    refit(&mut trees.refitted, mesh)?;
    for _ in 0..rounds.get() {
        let start = Instant::now();
        let built = black_box(build(mesh, BuildOptions { kind }));
        trees.build.push(start.elapsed());
        let mut refitted = before.clone();
        let start = Instant::now();
        refit(black_box(&mut refitted), mesh)?;
        trees.refit.push(start.elapsed());
        ensure!(built == trees.built && refitted == trees.refitted, "{kind}: other bytes");
    }
    Ok(trees)
}

impl Trees {
    fn print(&self) {
        let median_ms = |durations: &[Duration]| {
            let mut sorted = durations.to_vec();
            sorted.sort_unstable();
            sorted[sorted.len() / 2].as_secs_f64() * 1e3
        };
        let (build, refit) = (median_ms(&self.build), median_ms(&self.refit));
        print!("{build:9.1} {refit:9.1} {:7.3} ", refit / build);
    }
}

/// Of a built and a refitted tree, against the same one.
fn query(trees: [&TreeImage; 2], moving: &TreeImage, poses: &[Pose]) -> Result<()> {
    let (mut descent, moving) = (Descent::default(), moving.view());
    let mut timings = [Timings::default(), Timings::default()];
    for (number, pose) in poses.iter().enumerate() {
        let mut found = [Vec::new(), Vec::new()];
        // The first two are to warm up, and each is as often the first of both.
        for turn in 0..4 {
            let which = (turn + number) % 2;
            let pairs = &mut found[which];
            pairs.clear();
            let tree = trees[which].view();
            let mut call = || descent.all_pairs(&tree, &moving, pose, pairs);
            if turn > 1 { timings[which].time(call) } else { call() }?;
        }
        let [built, refitted] = &mut found;
        built.sort_unstable();
        refitted.sort_unstable();
        ensure!(built == refitted, "pose {number}: the refitted tree has other pairs");
    }
    let [built, refitted] = timings.map(|timings| timings.mean_us());
    println!("{built:6.1} {refitted:7.1} {:7.3}", refitted / built);
    Ok(())
}
