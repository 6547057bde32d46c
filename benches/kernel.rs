//! The serial kernel on one core beside parry3d-f64 on the same poses in the same run.
//!
//! ```text
//! cargo bench --bench kernel -- [--fixed M --moving M [--poses CSV [--truth CSV]]] [--count N]
//! ```
//!
//! `BUMPER_BENCH_DATA=DIR`, for a directory with `meshes/*.ply`, `poses/*.csv` and
//! `poses/*.truth.csv`, stands for the vehicle pairs there; otherwise they are built in. Answers
//! are checked: against the counts and hashes of the truth if there is one, else every kind and
//! instruction set against the others. parry's plain floating point may differ by a few pairs; in
//! how many poses it does is shown.

#[path = "kernel/cold.rs"]
mod cold;
#[path = "kernel/contender.rs"]
mod contender;
#[path = "kernel/parry.rs"]
mod parry;
#[path = "kernel/poses.rs"]
mod poses;
#[path = "kernel/tables.rs"]
mod tables;
#[path = "kernel/timing.rs"]
mod timing;
#[path = "kernel/vehicles.rs"]
mod vehicles;
#[path = "kernel/warm.rs"]
mod warm;

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Parser;
use vehicles::Vehicles;

#[derive(Parser)]
struct Args {
    #[arg(long, requires = "moving")]
    fixed: Option<String>,
    #[arg(long, requires = "fixed")]
    moving: Option<String>,
    /// Rows of qw,qx,qy,qz,tx,ty,tz under a header.
    #[arg(long, requires = "fixed")]
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

/// Where a pair of vehicles and its poses come from.
struct Source {
    fixed: String,
    moving: String,
    poses: Option<PathBuf>,
    truth: Option<PathBuf>,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let count = args.count;
    let mut contenders = contender::all();
    let mut pairs = Vec::new();
    for source in sources(args) {
        pairs.push(Vehicles::new(&source, count)?);
    }
    let mut answers = Vec::new();
    for vehicles in &pairs {
        let mut timed = warm::time(vehicles, &mut contenders)?;
        warm::check(vehicles, &contenders, &timed)?;
        tables::warm(vehicles, &contenders, &mut timed);
        answers.push(timed);
    }
    let mut timed = cold::time(&pairs, &mut contenders, &answers)?;
    for (vehicles, timed) in pairs.iter().zip(&mut timed) {
        tables::cold(vehicles, &contenders, timed);
    }
    Ok(())
}

fn sources(args: Args) -> Vec<Source> {
    if let (Some(fixed), Some(moving)) = (args.fixed, args.moving) {
        return vec![Source { fixed, moving, poses: args.poses, truth: args.truth }];
    }
    match std::env::var_os("BUMPER_BENCH_DATA") {
        Some(directory) => [["m113", "audi"], ["audi", "audi"]]
            .map(|names| from_directory(Path::new(&directory), names))
            .into(),
        None => [["tracked", "car"], ["car", "car"]]
            .map(|names| {
                let [fixed, moving] = names.map(|name| format!("builtin:{name}"));
                Source { fixed, moving, poses: None, truth: None }
            })
            .into(),
    }
}

fn from_directory(directory: &Path, [fixed, moving]: [&str; 2]) -> Source {
    let mesh = |name: &str| directory.join(format!("meshes/{name}.ply")).display().to_string();
    let poses = |end: &str| Some(directory.join(format!("poses/{fixed}-{moving}{end}.csv")));
    let (poses, truth) = (poses(""), poses(".truth"));
    Source { fixed: mesh(fixed), moving: mesh(moving), poses, truth }
}
