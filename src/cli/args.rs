//! The command line as clap sees it: declarations only. Each verb's file makes a checked request
//! of its arguments.

use std::ffi::OsString;
use std::num::NonZeroU32;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::mesh::MeshSource;
use crate::scene::WorkerCount;

/// Finds exactly which triangles of two vehicle models touch, in thousands of poses.
///
/// Without a verb, runs the default scene: a tracked vehicle against a car.
#[derive(Parser)]
#[command(version)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub verb: Option<Verb>,
}

#[derive(Subcommand)]
pub(super) enum Verb {
    /// Find the contacts of all scenarios of a scene
    Run(RunArgs),
    /// Look at mesh files
    #[command(subcommand)]
    Mesh(MeshVerb),
    /// What a run starts for each worker
    #[command(hide = true)]
    Worker {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<OsString>,
    },
}

#[derive(Args, Default)]
pub(super) struct RunArgs {
    /// Scene file (TOML); without one, the default scene. The options below replace its values
    pub scene: Option<PathBuf>,

    /// Mesh that stands still: a file, or builtin:car or builtin:tracked
    #[arg(long, value_name = "MESH")]
    pub fixed: Option<MeshSource>,

    /// Mesh that is moved: a file, or builtin:car or builtin:tracked
    #[arg(long, value_name = "MESH")]
    pub moving: Option<MeshSource>,

    /// Poses of the moving mesh, with the header qw,qx,qy,qz,tx,ty,tz
    #[arg(long, value_name = "CSV")]
    pub poses: Option<PathBuf>,

    /// Number of random scenarios, or of rows of the poses file, from the first
    #[arg(long, value_name = "N")]
    pub count: Option<NonZeroU32>,

    /// Which random scenarios: the same seed gives the same poses on every machine
    #[arg(long, value_name = "S", conflicts_with = "poses")]
    pub seed: Option<u64>,

    /// Worker processes [default: as many as cores]
    #[arg(long, value_name = "N")]
    pub workers: Option<WorkerCount>,

    /// Directory for summary.json and scenarios.csv: new, empty, or of an earlier run, whose files
    /// are replaced
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Write the touching triangles themselves too, as contacts.parquet
    #[arg(long, requires = "out")]
    pub contacts: bool,

    /// Print the summary as one JSON object
    #[arg(long)]
    pub json: bool,

    /// Where built trees are kept [default: bumper in the user's cache directory]
    #[arg(long, value_name = "DIR")]
    pub cache_dir: Option<PathBuf>,

    /// Build the trees anew, and keep none
    #[arg(long, conflicts_with = "cache_dir")]
    pub no_cache: bool,
}

#[derive(Subcommand)]
pub(super) enum MeshVerb {
    /// Say what is in each mesh, and what is unusual about it
    Info(MeshInfoArgs),
}

#[derive(Args)]
pub(super) struct MeshInfoArgs {
    /// Mesh files, or builtin:car or builtin:tracked
    #[arg(required = true, value_name = "MESH")]
    pub meshes: Vec<MeshSource>,

    /// Print one JSON array
    #[arg(long)]
    pub json: bool,
}
