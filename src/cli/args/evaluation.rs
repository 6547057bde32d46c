//! Of the paper's evaluation: measured, and simulated.

use std::num::NonZeroU32;
use std::path::PathBuf;

use clap::Args;

use super::one_of;
use crate::mesh::MeshSource;
use crate::scene::{Transport, WorkerCount};

#[derive(Args)]
pub(in crate::cli) struct ExperimentArgs {
    /// serial (tables 2 and 3 of the paper), scenarios (figure 10), depth (11), buffer (12), units
    /// (13), or a file like those in config/experiments
    #[arg(value_name = "NAME|FILE")]
    pub experiment: PathBuf,

    /// Only these of its pairs of models
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub models: Vec<String>,

    /// In the place of the fixed mesh of one pair
    #[arg(long, value_name = "MESH")]
    pub fixed: Option<MeshSource>,

    /// In the place of the moving mesh of one pair
    #[arg(long, value_name = "MESH")]
    pub moving: Option<MeshSource>,

    /// In the place of the poses of one pair
    #[arg(long, value_name = "CSV")]
    pub poses: Option<PathBuf>,

    /// Scenarios of each pair
    #[arg(long, value_name = "N")]
    pub count: Option<NonZeroU32>,

    /// Samples of each point
    #[arg(long, value_name = "N")]
    pub samples: Option<NonZeroU32>,

    /// Workers, where they are not what is varied
    #[arg(long, value_name = "N")]
    pub workers: Option<WorkerCount>,

    /// How the master and its workers reach each other [default: what the experiment says, and that
    /// is pipe, by which subtrees are sent]
    #[arg(long, value_parser = one_of(Transport::ALL.map(|t| (t.name(), t))))]
    pub transport: Option<Transport>,

    /// Directory for points.jsonl, experiment.json and the figures, new or empty [default:
    /// experiment-NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Go on after the samples that are there
    #[arg(long)]
    pub resume: bool,

    /// Print experiment.json
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(in crate::cli) struct ClusterArgs {
    /// The cluster and what it is given to do (TOML)
    pub config: PathBuf,

    /// What the scene costs here, reused if it is of this scene and program, otherwise recorded
    /// anew and kept in this file
    #[arg(long, value_name = "FILE")]
    pub recording: Option<PathBuf>,

    /// Directory for cluster.json and a figure of each sweep; files of these names are replaced
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Run the scene for real too, over pipe and over iceoryx2, by as many workers as the cluster
    /// has, and compare
    #[arg(long)]
    pub validate: bool,

    /// Print cluster.json
    #[arg(long)]
    pub json: bool,
}
