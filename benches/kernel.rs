//! The serial kernel on one core beside parry3d-f64 on the same poses in the same run.
//!
//! ```text
//! cargo bench --bench kernel -- [--fixed M] [--moving M] [--poses CSV --truth CSV] [--count N]
//! ```
//!
//! `BUMPER_BENCH_DATA=DIR`, for a directory with `meshes/*.ply`, `poses/*.csv` and
//! `poses/*.truth.csv`, stands for the vehicle pairs there. Answers are checked: against the counts
//! and hashes of the truth if there is one, else every kind and instruction set against the others.
//! parry's plain floating point may differ by a few pairs; in how many poses it does is shown.

#[path = "kernel/parry.rs"]
mod parry;
#[path = "kernel/poses.rs"]
mod poses;
#[path = "kernel/timing.rs"]
mod timing;

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, ensure};
use bumper::effects::contacts::pairs_fnv1a64;
use bumper::geometry::Pose;
use bumper::geometry::simd::SimdLevel;
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::read_poses;
use bumper::tree::descent::Descent;
use bumper::tree::{BuildOptions, Counts, TreeImage, TreeKind, build};
use clap::Parser;
use timing::Timings;

#[derive(Parser)]
struct Args {
    #[arg(long, default_value = "builtin:tracked")]
    fixed: String,
    #[arg(long, default_value = "builtin:car")]
    moving: String,
    /// Rows of qw,qx,qy,qz,tx,ty,tz under a header.
    #[arg(long)]
    poses: Option<PathBuf>,
    /// Rows of pose,count,fnv1a64 under a header.
    #[arg(long, requires = "poses")]
    truth: Option<PathBuf>,
    #[arg(long, default_value = "300")]
    count: NonZeroU32,
    /// What cargo passes to every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Number of pairs and their hash.
type Answer = (usize, u64);

/// A tree kind, and what it is descended with.
struct Contender {
    name: String,
    trees: usize,
    descent: Descent,
    all: Timings,
    colliding: Timings,
    near: Timings,
    counts: Counts,
    answers: Vec<Answer>,
}

struct Trees {
    kind: TreeKind,
    fixed: TreeImage,
    moving: TreeImage,
}

fn main() -> Result<()> {
    let args = Args::parse();
    match std::env::var_os("BUMPER_BENCH_DATA") {
        None => run(&args),
        Some(directory) => {
            for names in [["m113", "audi"], ["audi", "audi"]] {
                run(&from_directory(Path::new(&directory), names, args.count))?;
            }
            Ok(())
        }
    }
}

fn from_directory(directory: &Path, [fixed, moving]: [&str; 2], count: NonZeroU32) -> Args {
    let mesh = |name: &str| directory.join(format!("meshes/{name}.ply")).display().to_string();
    let poses = |end: &str| Some(directory.join(format!("poses/{fixed}-{moving}{end}.csv")));
    let (poses, truth) = (poses(""), poses(".truth"));
    Args { fixed: mesh(fixed), moving: mesh(moving), poses, truth, count, bench: true }
}

fn run(args: &Args) -> Result<()> {
    let load = |source: &str| -> Result<TriangleMesh> { Ok(source.parse::<MeshSource>()?.load()?) };
    let (fixed, moving) = (load(&args.fixed)?, load(&args.moving)?);
    println!("\n{} against {}", args.fixed, args.moving);
    let trees: Vec<Trees> =
        TreeKind::ALL.into_iter().map(|kind| built(kind, &fixed, &moving)).collect();
    let views = trees.last().map(|trees| (trees.fixed.view(), trees.moving.view()));
    let (a, b) = views.expect("there are tree kinds");
    let poses = match &args.poses {
        Some(path) => read_poses(path, Some(args.count))?,
        None => poses::random(&a, &b, args.count.get() as usize)?,
    };
    let near = poses::near_misses(&a, &b, &poses)?;

    let peer = parry::Peer::new(&fixed, &moving);
    let mut contenders = contenders(&trees);
    let mut peers = [Timings::default(), Timings::default(), Timings::default()];
    let differing = time(&trees, &mut contenders, (&peer, &mut peers), [&poses, &near])?;
    check(args, &contenders)?;
    println!("parry3d-f64 differs from the exact pairs in {differing} of {} poses", poses.len());
    print_tables(&mut contenders, &mut peers, poses.len());
    Ok(())
}

fn built(kind: TreeKind, fixed: &TriangleMesh, moving: &TriangleMesh) -> Trees {
    let timed = |mesh: &TriangleMesh| {
        let start = Instant::now();
        let image = build(mesh, BuildOptions { kind });
        let triangles = mesh.faces().len();
        println!(
            "{kind}: built {triangles} triangles in {:.0} ms, {:.1} bytes a triangle",
            start.elapsed().as_secs_f64() * 1e3,
            (64 * image.blocks().len()) as f64 / triangles as f64
        );
        image
    };
    Trees { kind, fixed: timed(fixed), moving: timed(moving) }
}

fn contenders(trees: &[Trees]) -> Vec<Contender> {
    let mut contenders = Vec::new();
    for (index, trees) in trees.iter().enumerate() {
        let levels = match trees.kind {
            TreeKind::Wide => SimdLevel::available(),
            TreeKind::Obb | TreeKind::Aabb => vec![SimdLevel::Portable],
        };
        for level in levels {
            contenders.push(Contender {
                name: format!("{} {level}", trees.kind),
                trees: index,
                descent: Descent::with_simd(level),
                all: Timings::default(),
                colliding: Timings::default(),
                near: Timings::default(),
                counts: Counts::default(),
                answers: Vec::new(),
            });
        }
    }
    contenders
}

/// All in turn on every pose, each twice, of which the first is to warm up: so all see the machine
/// at its best and at its worst. In how many poses the peer differs.
fn time(
    trees: &[Trees],
    contenders: &mut [Contender],
    (peer, [peer_all, peer_colliding, peer_near]): (&parry::Peer, &mut [Timings; 3]),
    [poses, near]: [&[Pose]; 2],
) -> Result<usize> {
    let (mut pairs, mut differing) = (Vec::new(), 0);
    for pose in poses {
        for contender in &mut *contenders {
            let trees = &trees[contender.trees];
            let (fixed, moving) = (trees.fixed.view(), trees.moving.view());
            pairs.clear();
            let descent = &mut contender.descent;
            let counts = descent.counted_pairs(&fixed, &moving, pose, &mut pairs)?;
            add(&mut contender.counts, &counts);
            pairs.clear();
            contender.all.time(|| descent.all_pairs(&fixed, &moving, pose, &mut pairs))?;
            pairs.sort_unstable();
            contender.answers.push((pairs.len(), pairs_fnv1a64(&pairs)));
            let found = !pairs.is_empty();
            ensure!(descent.any_pair(&fixed, &moving, pose)? == found, "yes or no is wrong");
            if found {
                contender.colliding.time(|| descent.any_pair(&fixed, &moving, pose))?;
            }
        }
        peer.all_pairs(pose, &mut pairs);
        peer_all.time(|| peer.all_pairs(pose, &mut pairs));
        pairs.sort_unstable();
        let answer = (pairs.len(), pairs_fnv1a64(&pairs));
        differing += usize::from(contenders[0].answers.last() != Some(&answer));
        if peer.any_pair(pose) {
            peer_colliding.time(|| peer.any_pair(pose));
        }
    }
    for pose in near {
        for contender in &mut *contenders {
            let trees = &trees[contender.trees];
            let (fixed, moving) = (trees.fixed.view(), trees.moving.view());
            let descent = &mut contender.descent;
            ensure!(!descent.any_pair(&fixed, &moving, pose)?, "a near miss is a hit");
            contender.near.time(|| descent.any_pair(&fixed, &moving, pose))?;
        }
        peer.any_pair(pose);
        peer_near.time(|| peer.any_pair(pose));
    }
    Ok(differing)
}

fn add(sum: &mut Counts, more: &Counts) {
    sum.boxes += more.boxes;
    sum.triangles += more.triangles;
    sum.exact += more.exact;
}

fn check(args: &Args, contenders: &[Contender]) -> Result<()> {
    let answers = &contenders[0].answers;
    for other in contenders {
        ensure!(other.answers == *answers, "{} and {} disagree", contenders[0].name, other.name);
    }
    if let Some(path) = &args.truth {
        let truth = read_truth(path, answers.len())?;
        ensure!(*answers == truth, "the answers are not those of {}", path.display());
        println!("all {} answers are those of {}", truth.len(), path.display());
    }
    Ok(())
}

fn read_truth(path: &Path, count: usize) -> Result<Vec<Answer>> {
    let mut file = csv::Reader::from_path(path)?;
    let rows = file.deserialize::<(u32, usize, String)>().take(count);
    rows.map(|row| {
        let (_, pairs, hash) = row?;
        Ok((pairs, u64::from_str_radix(&hash, 16)?))
    })
    .collect()
}

fn print_tables(contenders: &mut [Contender], peers: &mut [Timings; 3], poses: usize) {
    let [all, colliding, near] = peers;
    table("all pairs", all, contenders, |contender| &mut contender.all);
    table("any, colliding", colliding, contenders, |contender| &mut contender.colliding);
    table("any, near miss", near, contenders, |contender| &mut contender.near);
    println!("\n{:16} {:>10} {:>10} {:>10}", "a pose", "N_b", "N_p", "exact");
    for Contender { name, counts, .. } in contenders {
        let [b, p, exact] =
            [counts.boxes, counts.triangles, counts.exact].map(|count| count as f64 / poses as f64);
        println!("{name:16} {b:10.0} {p:10.0} {exact:10.1}");
    }
}

fn table(
    title: &str,
    peer: &mut Timings,
    contenders: &mut [Contender],
    timings: impl Fn(&mut Contender) -> &mut Timings,
) {
    println!("\n{title:16} {:>9} {:>9} {:>9} {:>14}", "mean us", "median", "p99", "parry / this");
    let base = peer.mean_ms();
    row("parry3d-f64", peer, base);
    for contender in contenders {
        let name = contender.name.clone();
        row(&name, timings(contender), base);
    }
}

fn row(name: &str, timings: &mut Timings, base: f64) {
    let mean = timings.mean_ms();
    let [median, p99] = [0.5, 0.99].map(|q| 1e3 * timings.quantile_ms(q));
    println!("{name:16} {:9.1} {median:9.1} {p99:9.1} {:14.1}", 1e3 * mean, base / mean);
}
