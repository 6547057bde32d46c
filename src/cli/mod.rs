//! The command line: arguments in, exit code out.

mod accuracy;
mod args;
mod bench;
mod check;
mod check_ccd;
mod clean;
mod cluster;
mod compare;
mod deform;
mod experiment;
mod failure;
mod files;
mod interrupt;
mod mesh_info;
mod page_server;
mod plan;
mod prepare;
mod ranks;
mod renumber;
mod report;
mod request;
mod run;
mod summary_text;
mod terminal;
mod view;

use std::process::ExitCode;

use clap::Parser;

use self::args::{BenchVerb, Cli, MeshVerb, RunArgs, Verb};
use crate::workers;

/// Runs what the command line asks for. Exit codes: 0 it ran, 1 it failed, 2 it was asked for
/// something that makes no sense, 130 Ctrl-C.
pub fn main() -> ExitCode {
    let outcome = match Cli::parse().verb.unwrap_or(Verb::Run(RunArgs::default())) {
        Verb::Worker { args } => return workers::main(&args),
        Verb::Run(args) => terminal::log_to_stderr().and_then(|()| run::run(args)),
        Verb::Accuracy(args) => terminal::log_to_stderr().and_then(|()| accuracy::run(*args)),
        Verb::Cluster(args) => terminal::log_to_stderr().and_then(|()| cluster::run(&args)),
        Verb::Plan(args) => terminal::log_to_stderr().and_then(|()| plan::plan(&args)),
        Verb::View(args) => terminal::log_to_stderr().and_then(|()| view::view(*args)),
        Verb::Experiment(args) => terminal::log_to_stderr().and_then(|()| experiment::run(*args)),
        Verb::Mesh(MeshVerb::Info(args)) => mesh_info::run(&args),
        Verb::Bench(BenchVerb::Transport(args)) => bench::transport(args),
        Verb::Bench(BenchVerb::Engine(args)) => {
            terminal::log_to_stderr().and_then(|()| bench::engine(*args))
        }
        Verb::Report(args) => report::run(&args),
        Verb::Check(args) => check::run(&args),
        Verb::Clean(args) => clean::run(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
