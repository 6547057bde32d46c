//! The command line as clap sees it: declarations only. Each verb's file makes a checked request
//! of its arguments.

mod evaluation;

use std::ffi::OsString;
use std::num::{NonZeroU32, NonZeroU64};
use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};

pub(super) use self::evaluation::{ClusterArgs, ExperimentArgs};
use super::page_server::Loopback;
use crate::mesh::MeshSource;
use crate::scene::{
    self, Compression, Distribution, MatchRule, Slowdown, StartFrom, SubtreesFrom, Transport,
    WorkerCount,
};
use crate::transport::WakeUp;
use crate::tree::Accuracy;

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
    /// Say what a scene calls for, what is left out, and what a scenario is likely to cost
    Plan(Box<PlanArgs>),
    /// Make a page to look at a scene, or at the results of a run, in a browser
    View(Box<ViewArgs>),
    /// What accuracy costs in time, and what is wrong without it: the same scenarios at every level
    Accuracy(Box<AccuracyArgs>),
    /// The paper's evaluation on this machine: what the amount of scenarios, the depth of subtrees, the
    /// buffer and the number of cores do to speedup and data transfer
    Experiment(Box<ExperimentArgs>),
    /// Simulate a cluster that runs a scene, from what the scene costs on this machine
    Cluster(ClusterArgs),
    /// Look at mesh files
    #[command(subcommand)]
    Mesh(MeshVerb),
    /// Measure transports and engines
    #[command(subcommand)]
    Bench(BenchVerb),
    /// Make one page to read of the outputs of run, bench, accuracy, experiment and cluster
    Report(ReportArgs),
    /// Answer hard cases in every way there is, and count wrong answers
    Check(CheckArgs),
    /// Remove what killed runs of yours left; living ones are not touched
    Clean(CleanArgs),
    /// What a run starts for each worker
    #[command(hide = true)]
    Worker {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        args: Vec<OsString>,
    },
}

/// What is computed, and how.
#[derive(Args, Default)]
pub(super) struct SceneArgs {
    /// Scene file (TOML); without one, the default scene. The options below replace its values
    pub scene: Option<PathBuf>,

    /// Mesh that stands still: a file, or builtin:car or builtin:tracked
    #[arg(long, value_name = "MESH")]
    pub fixed: Option<MeshSource>,

    /// Mesh that is moved: a file, or builtin:car or builtin:tracked
    #[arg(long, value_name = "MESH")]
    pub moving: Option<MeshSource>,

    /// Depth at which the fixed mesh's tree is cut into the subtrees that are handed out
    #[arg(long, value_name = "D", value_parser = depth, conflicts_with = "fixed_subtree_triangles")]
    pub fixed_depth: Option<Distribution>,

    /// Or the most triangles of a subtree
    #[arg(long, value_name = "N", value_parser = subtree_triangles)]
    pub fixed_subtree_triangles: Option<Distribution>,

    /// As --fixed-depth, of the moving mesh
    #[arg(long, value_name = "D", value_parser = depth, conflicts_with = "moving_subtree_triangles")]
    pub moving_depth: Option<Distribution>,

    /// As --fixed-subtree-triangles, of the moving mesh
    #[arg(long, value_name = "N", value_parser = subtree_triangles)]
    pub moving_subtree_triangles: Option<Distribution>,

    /// What is a pair: exact (never wrong), f64 or f32 (plain floating point), boxes (of two
    /// triangles), or boxes(D) (at depth D of the trees)
    #[arg(long, value_name = "LEVEL")]
    pub accuracy: Option<Accuracy>,

    /// Poses of the moving mesh, with the header qw,qx,qy,qz,tx,ty,tz
    #[arg(long, value_name = "CSV")]
    pub poses: Option<PathBuf>,

    /// Number of random scenarios, or of rows of the poses file, from the first
    #[arg(long, value_name = "N")]
    pub count: Option<NonZeroU32>,

    /// Which random scenarios: the same seed gives the same poses on every machine
    #[arg(long, value_name = "S", conflicts_with = "poses")]
    pub seed: Option<u64>,

    /// Workers [default: as many as cores]
    #[arg(long, value_name = "N")]
    pub workers: Option<WorkerCount>,

    #[command(flatten)]
    pub engine: EngineArgs,
}

#[derive(Args, Default)]
pub(super) struct RunArgs {
    #[command(flatten)]
    pub scene: SceneArgs,

    /// Directory for summary.json and scenarios.csv: new, empty, or of an earlier run, whose files
    /// are replaced
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Go on with the run that writes to this directory and was killed or interrupted. What is
    /// answered is kept; its scene is taken, and must be the same where it is given again, but for
    /// the options of the engine
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "contacts", "stats"])]
    pub resume: Option<PathBuf>,

    /// Write the touching triangles themselves too, as contacts.parquet
    #[arg(long, requires = "out")]
    pub contacts: bool,

    /// Print the summary as one JSON object
    #[arg(long)]
    pub json: bool,

    /// Run the scenarios with every kind of tree, and print the terms of T = N_b C_b + N_p C_p
    #[arg(long)]
    pub stats: bool,

    /// Where built trees are kept [default: bumper in the user's cache directory]
    #[arg(long, value_name = "DIR")]
    pub cache_dir: Option<PathBuf>,

    /// Build the trees anew, and keep none
    #[arg(long, conflicts_with = "cache_dir")]
    pub no_cache: bool,
}

#[derive(Args)]
pub(super) struct PlanArgs {
    #[command(flatten)]
    pub scene: SceneArgs,

    /// Scenarios that are measured, from the first
    #[arg(long, value_name = "N", default_value = "20")]
    pub sample: NonZeroU32,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(super) struct ViewArgs {
    #[command(flatten)]
    pub scene: SceneArgs,

    /// File for the page [default: bumper.html, if it is not served]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,

    /// Serve the page here until Ctrl-C, to this machine only: 127.0.0.1:8080, or port 0 for any
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub serve: Option<Loopback>,

    /// Where built trees are kept [default: bumper in the user's cache directory]
    #[arg(long, value_name = "DIR")]
    pub cache_dir: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct AccuracyArgs {
    #[command(flatten)]
    pub scene: SceneArgs,

    /// Levels to compare with exact, as for --accuracy [default: boxes at depths 2 to 14, and all
    /// others]
    #[arg(long, value_name = "LEVEL", value_delimiter = ',')]
    pub levels: Vec<Accuracy>,

    /// Directory for accuracy.json, accuracy.svg and depth.svg; files of these names are replaced
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// As in the scene's `[engine]`.
#[derive(Args, Default)]
#[command(next_help_heading = "Engine")]
pub(super) struct EngineArgs {
    /// How the master and its workers reach each other: on shared memory, as threads, or over pipes
    /// or sockets, by which subtrees are sent when they are needed
    #[arg(long, value_parser = one_of(Transport::ALL.map(|t| (t.name(), t))))]
    pub transport: Option<Transport>,

    /// Which worker a scenario goes to: with the most similar geometry, any, with the least similar,
    /// or the most similar weighed by load
    #[arg(long, value_parser = one_of(MatchRule::ALL.map(|m| (m.name(), m))))]
    pub matchmaker: Option<MatchRule>,

    /// Of the random matchmaker
    #[arg(long, value_name = "S")]
    pub match_seed: Option<u64>,

    /// Scenarios that are sent to a worker at a time
    #[arg(long, value_name = "Q", value_parser = buffer_scenarios)]
    pub buffer_scenarios: Option<NonZeroU32>,

    /// Kilobytes of subtrees that are sent to a worker at a time
    #[arg(long, value_name = "V", value_parser = buffer_kilobytes)]
    pub buffer_kilobytes: Option<NonZeroU64>,

    /// Where a worker starts a scenario: at the top of both trees, or at the pairs of subtrees that
    /// the master found
    #[arg(long, value_parser = one_of(StartFrom::ALL.map(|s| (s.name(), s))))]
    pub start_from: Option<StartFrom>,

    /// What is done to subtrees before they are sent, over pipes or sockets
    #[arg(long, value_parser = one_of(Compression::ALL.map(|c| (c.name(), c))))]
    pub compress: Option<Compression>,

    /// From whom a worker gets a subtree that it lacks, over pipes or sockets, or a machine, over several
    /// ranks: from the master, from another that has it, or from the least busy of all these
    #[arg(long, value_parser = one_of(SubtreesFrom::ALL.map(|s| (s.name(), s))))]
    pub subtrees_from: Option<SubtreesFrom>,

    /// How often another worker is started in the place of one that died
    #[arg(long, value_name = "N", value_parser = restarts)]
    pub restarts: Option<u32>,

    /// Seconds after which a worker that answers nothing is ended
    #[arg(long, value_name = "S", value_parser = patience)]
    pub patience: Option<Duration>,

    /// How many times slower than it could each worker is to be, from the first: to see balancing
    #[arg(long, value_name = "FACTOR", value_delimiter = ',')]
    pub slowdowns: Option<Vec<Slowdown>>,
}

/// One of the values with a name.
fn one_of<T: Copy + Send + Sync + 'static, const N: usize>(
    named: [(&'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(named.map(|(name, _)| name)).map(move |name| {
        let found = named.iter().find(|(known, _)| *known == name);
        found.expect("only these names are possible").1
    })
}

fn buffer_scenarios(text: &str) -> anyhow::Result<NonZeroU32> {
    Ok(scene::buffer_scenarios(text.parse()?)?)
}

fn buffer_kilobytes(text: &str) -> anyhow::Result<NonZeroU64> {
    Ok(scene::buffer_kilobytes(text.parse()?)?)
}

fn restarts(text: &str) -> anyhow::Result<u32> {
    Ok(scene::restarts(text.parse()?)?)
}

fn patience(text: &str) -> anyhow::Result<Duration> {
    Ok(scene::patience(text.parse()?)?)
}

fn depth(text: &str) -> anyhow::Result<Distribution> {
    Ok(Distribution::at_depth(text.parse()?)?)
}

fn subtree_triangles(text: &str) -> anyhow::Result<Distribution> {
    Ok(Distribution::by_triangles(text.parse()?)?)
}

#[derive(Subcommand)]
pub(super) enum BenchVerb {
    /// How long it takes to hand a subtree over to a worker, by size
    Transport(BenchTransportArgs),
    /// The same scenarios over each transport, matchmaker and number of workers
    Engine(Box<BenchEngineArgs>),
}

#[derive(Args)]
pub(super) struct BenchTransportArgs {
    /// Only these transports
    #[arg(long, value_delimiter = ',', value_parser = one_of(Transport::ALL.map(|t| (t.name(), t))))]
    pub transport: Vec<Transport>,

    /// Only these ways to wait for a message
    #[arg(long, value_delimiter = ',', value_parser = one_of(WakeUp::ALL.map(|w| (w.name(), w))))]
    pub wake_up: Vec<WakeUp>,

    /// Sizes of what is handed over
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        default_values_t = [64, 1024, 16 << 10, 256 << 10, 1 << 20, 8 << 20, 64 << 20]
    )]
    pub bytes: Vec<usize>,

    /// Seconds for each combination and size, which takes at least 30 hand-overs
    #[arg(long, default_value_t = 0.3, value_parser = seconds)]
    pub seconds: f64,

    /// Directory for bench_transport.json and its figures; files of these names are replaced
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Draw the one-way times
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(super) struct BenchEngineArgs {
    #[command(flatten)]
    pub scene: SceneArgs,

    /// Only these transports
    #[arg(long, value_delimiter = ',', value_parser = one_of(Transport::ALL.map(|t| (t.name(), t))))]
    pub over: Vec<Transport>,

    /// Only these matchmakers
    #[arg(long, value_delimiter = ',', value_parser = one_of(MatchRule::ALL.map(|m| (m.name(), m))))]
    pub match_rules: Vec<MatchRule>,

    /// With so many workers [default: 1, and as many as there are cores]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub worker_counts: Vec<WorkerCount>,

    /// Seconds for each combination, which takes at least two runs
    #[arg(long, default_value_t = 2.0, value_parser = seconds)]
    pub seconds: f64,

    /// Directory for bench_engine.json and its figures; files of these names are replaced
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Draw the scenarios a second
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

fn seconds(text: &str) -> anyhow::Result<f64> {
    Ok(scene::patience(text.parse()?)?.as_secs_f64())
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

#[derive(Args)]
pub(super) struct ReportArgs {
    /// Directories that those commands wrote to with --out
    #[arg(required = true, value_name = "DIR")]
    pub directories: Vec<PathBuf>,

    /// The page: one HTML file that needs nothing else
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    pub out: PathBuf,

    /// Directory for the figures as well, each an SVG file
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct CheckArgs {
    /// Files of cases [default: the built-in suite]
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub suite: Vec<PathBuf>,

    /// Files of continuous queries (when does a vertex meet a face, an edge an edge), instead
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "suite")]
    pub ccd: Vec<PathBuf>,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Args)]
pub(super) struct CleanArgs {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}
