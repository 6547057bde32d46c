//! The smallest distance of two vehicles on one core, beside parry3d-f64 on the same poses in turn.
//!
//! ```text
//! cargo bench --bench clearance -- [--count N] [--margin METRES]
//! ```
//!
//! On the vehicles of `BUMPER_BENCH_DATA=DIR`, a directory with `meshes/*.ply` and `poses/*.csv`, or
//! else on the built-in ones, in poses apart by 1.5 mm, 10 cm and 1 m. Every distance is
//! checked against the peer's, and against those of every kind of tree and instruction set.

#[path = "kernel/parry.rs"]
#[expect(dead_code, reason = "pairs are for the kernel's own benchmark")]
mod parry;
#[path = "kernel/poses.rs"]
mod poses;
#[path = "kernel/timing.rs"]
#[expect(dead_code, reason = "means are for the kernel's own benchmark")]
mod timing;

use std::num::NonZeroU32;
use std::path::Path;

use anyhow::{Result, ensure};
use bumper::geometry::Pose;
use bumper::geometry::simd::SimdLevel;
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::read_poses;
use bumper::tree::nearest::{Clearance, Tolerance};
use bumper::tree::{BuildOptions, Counts, TreeImage, TreeKind, build};
use clap::Parser;
use parry3d_f64::math::Pose as Placement;
use parry3d_f64::query::distance;
use timing::Timings;

#[derive(Parser)]
struct Args {
    #[arg(long, default_value = "8")]
    count: NonZeroU32,
    /// Pairs of triangles that are as near as this are found too, metres.
    #[arg(long, default_value = "0.01")]
    margin: f64,
    /// Without the peer, which is slow.
    #[arg(long)]
    alone: bool,
    /// What cargo passes to every benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let Some(directory) = std::env::var_os("BUMPER_BENCH_DATA") else {
        return study(["builtin:tracked", "builtin:car"], None, &args);
    };
    let directory = Path::new(&directory);
    for [fixed, moving] in [["m113", "audi"], ["audi", "audi"]] {
        let mesh = |name| directory.join(format!("meshes/{name}.ply")).display().to_string();
        let poses = directory.join(format!("poses/{fixed}-{moving}.csv"));
        study([&mesh(fixed), &mesh(moving)], Some(&poses), &args)?;
    }
    Ok(())
}

/// One way to ask for the smallest distance.
struct Contender {
    name: String,
    index: usize,
    clearance: Clearance,
    tolerance: Tolerance,
}

fn contenders() -> Result<Vec<Contender>> {
    let mut all = Vec::new();
    for (index, kind) in TreeKind::ALL.into_iter().enumerate() {
        let levels = match kind {
            TreeKind::Wide => SimdLevel::available(),
            TreeKind::Obb | TreeKind::Aabb => vec![SimdLevel::Portable],
        };
        for level in levels {
            let (name, clearance) = (format!("{kind} {level}"), Clearance::with_simd(level));
            all.push(Contender { name, index, clearance, tolerance: Tolerance::NONE });
        }
    }
    let (clearance, tolerance) = (Clearance::default(), Tolerance::new(0.0, 0.01)?);
    all.push(Contender { name: "within 1 %".to_owned(), index: 2, clearance, tolerance });
    Ok(all)
}

fn study(sources: [&str; 2], file: Option<&Path>, args: &Args) -> Result<()> {
    let load = |source: &str| -> Result<TriangleMesh> { Ok(source.parse::<MeshSource>()?.load()?) };
    let [fixed, moving] = sources;
    println!("\n{fixed} against {moving}, us a pose");
    let (fixed, moving) = (load(fixed)?, load(moving)?);
    let images =
        TreeKind::ALL.map(|kind| [&fixed, &moving].map(|m| build(m, BuildOptions { kind })));
    let [.., wide] = &images;
    let touching = match file {
        Some(path) => read_poses(path, Some(args.count))?,
        None => poses::random((&fixed, &wide[0]), (&moving, &wide[1]), args.count)?,
    };
    let near = poses::near_misses(&wide[0].view(), &wide[1].view(), &touching)?;
    let peer = parry::Peer::new(&fixed, &moving);
    for away in [0.0, 0.1, 1.0] {
        let poses: Vec<Pose> = near.iter().map(|pose| drawn_back(pose, wide, away)).collect();
        compare(&images, &peer, &poses, args)?;
    }
    Ok(())
}

/// Farther from the fixed vehicle's middle.
fn drawn_back(pose: &Pose, [fixed, moving]: &[TreeImage; 2], by: f64) -> Pose {
    let middle = |tree: &TreeImage| {
        let header = *tree.view().header();
        [0, 1, 2].map(|k| 0.5 * header.low[k] + 0.5 * header.high[k])
    };
    let (a, b) = (middle(fixed), pose.apply(middle(moving)));
    let away = [0, 1, 2].map(|k| b[k] - a[k]);
    let length = away.iter().map(|c| c * c).sum::<f64>().sqrt();
    let translation = [0, 1, 2].map(|k| pose.translation[k] + away[k] * by / length);
    Pose { translation, ..*pose }
}

fn compare(
    images: &[[TreeImage; 2]; 3],
    peer: &parry::Peer,
    poses: &[Pose],
    args: &Args,
) -> Result<()> {
    let mut contenders = contenders()?;
    let mut timed: Vec<(Timings, Counts)> = contenders.iter().map(|_| Default::default()).collect();
    let (mut of_peer, mut of_margin) = (Timings::default(), Timings::default());
    let (mut distances, mut found, mut pairs) = (Vec::new(), Vec::new(), 0);
    for pose in poses {
        let mut exact = None;
        for (contender, (timings, counts)) in contenders.iter_mut().zip(&mut timed) {
            let Contender { name, index, clearance, tolerance } = contender;
            let [a, b] = &images[*index];
            let (a, b) = (a.view(), b.view());
            clearance.smallest(&a, &b, pose, *tolerance)?;
            let clearest = timings.time(|| clearance.smallest(&a, &b, pose, *tolerance))?;
            *counts += clearance.counts();
            let nearest = clearest.nearest;
            if *tolerance == Tolerance::NONE {
                ensure!(*exact.get_or_insert(nearest) == nearest, "{name} answers {nearest:?}");
            }
        }
        let [a, b] = images[2].each_ref().map(TreeImage::view);
        let mut clearance = Clearance::default();
        clearance.within(&a, &b, pose, args.margin, &mut found)?;
        of_margin.time(|| clearance.within(&a, &b, pose, args.margin, &mut found))?;
        pairs += found.len();
        let nearest = exact.expect("most contenders give the smallest").distance_m;
        distances.push(nearest);
        if !args.alone {
            let placed = parry::placement(pose);
            let asked = || distance(&Placement::IDENTITY, &peer.fixed, &placed, &peer.moving);
            let theirs = of_peer.time(asked)?.distance;
            ensure!((theirs - nearest).abs() < 1e-6, "the peer answers {theirs}, not {nearest}");
        }
    }
    distances.sort_by(f64::total_cmp);
    let count = distances.len();
    println!("\n{count} poses apart by {:.5} m in the median", distances[count / 2]);
    println!(
        "{:16} {:>9} {:>9} {:>14} {:>9} {:>9} {:>9}",
        "", "median", "p90", "parry / this", "N_b", "N_p", "distances"
    );
    let median = of_peer.quantile_us(0.5);
    println!("{:16} {median:9.1} {:9.1}", "parry3d-f64", of_peer.quantile_us(0.9));
    for (contender, (timings, counts)) in contenders.iter().zip(&mut timed) {
        let [ours, p90] = [0.5, 0.9].map(|q| timings.quantile_us(q));
        let [b, p, exact] =
            [counts.boxes, counts.triangles, counts.exact].map(|n| n as f64 / count as f64);
        println!(
            "{:16} {ours:9.1} {p90:9.1} {:14.1} {b:9.0} {p:9.0} {exact:9.1}",
            contender.name,
            median / ours
        );
    }
    let [ours, p90] = [0.5, 0.9].map(|q| of_margin.quantile_us(q));
    println!(
        "{:16} {ours:9.1} {p90:9.1} {:14} {:9.1} pairs",
        "within margin",
        "",
        pairs as f64 / count as f64
    );
    Ok(())
}
