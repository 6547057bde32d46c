//! `bumper bench`: what a transport costs, and what an engine gets done.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, anyhow};
use serde::Serialize;

use super::args::{BenchEngineArgs, BenchTransportArgs};
use super::failure::Failure;
use super::prepare::{self, Poses};
use super::request::scene_of;
use super::{files, interrupt, report, terminal};
use crate::experiment::latency::{self, LatencyError, LatencyOptions, LatencyRow};
use crate::experiment::throughput::{self, Load, ThroughputError, ThroughputRow};
use crate::report::source::Source;
use crate::report::{Machine, Versions};
use crate::scene::{EngineOptions, MatchRule, Transport};
use crate::transport::WakeUp;
use crate::tree::{Accuracy, BuildOptions};

/// What is printed with `--json`, and written to `--out`.
#[derive(Serialize)]
struct Report<'a, R> {
    schema_version: u32,
    versions: Versions,
    machine: Machine,
    rows: &'a [R],
}

const SCHEMA_VERSION: u32 = 1;

fn to_json<R: Serialize>(rows: &[R]) -> String {
    let machine = Machine::this();
    let report =
        Report { schema_version: SCHEMA_VERSION, versions: Versions::this(), machine, rows };
    serde_json::to_string_pretty(&report).expect("string keys and plain values") + "\n"
}

/// Where figures go, beside the terminal.
struct Files<'a> {
    out: Option<&'a Path>,
    /// Of the first figure.
    svg: Option<&'a Path>,
}

impl Files<'_> {
    /// Before anything takes its time.
    fn prepare(&self) -> anyhow::Result<()> {
        self.out.map_or(Ok(()), files::make_folder)
    }

    fn write(&self, source: Source, json: &str) -> anyhow::Result<()> {
        let drawings = match (self.out, self.svg) {
            (Some(folder), _) => report::write_output(folder, source, json)?,
            (None, Some(_)) => source.section(Path::new(""), json.to_owned())?.drawings,
            (None, None) => return Ok(()),
        };
        match (self.svg, drawings.first()) {
            (Some(path), Some(drawing)) => files::write(path, &drawing.to_svg()?),
            _ => Ok(()),
        }
    }
}

pub(super) fn transport(args: BenchTransportArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let files = Files { out: args.out.as_deref(), svg: args.svg.as_deref() };
    files.prepare()?;
    let options = LatencyOptions {
        transports: or_all(args.transport, &Transport::ALL),
        wake_ups: or_all(args.wake_up, &WakeUp::ALL),
        sizes: args.bytes,
        time: Duration::from_secs_f64(args.seconds),
        program: std::env::current_exe().context("cannot find my own executable")?,
    };
    let activity = terminal::activity("measuring");
    let mut rows = Vec::new();
    let measured = latency::measure(&options, &interrupt, &mut |row| {
        activity.set_message(format!(
            "{} {} {} bytes",
            row.transport.name(),
            row.wake_up,
            row.bytes
        ));
        rows.push(row);
    });
    activity.finish_and_clear();
    measured.map_err(|error| match error {
        LatencyError::Interrupted => interrupt::before_results(),
        other => other.into(),
    })?;
    let json = to_json(&rows);
    files.write(Source::BenchTransport, &json)?;
    let text = if args.json { json } else { latency_table(&rows) };
    Ok(terminal::print(&text).context("cannot print the figures")?)
}

fn or_all<T: Copy>(wanted: Vec<T>, all: &[T]) -> Vec<T> {
    if wanted.is_empty() { all.to_vec() } else { wanted }
}

fn latency_table(rows: &[LatencyRow]) -> String {
    let mut text = format!(
        "{:9} {:16} {:>10} {:>7}  {:>30}  {:>30} {:>10} {:>11}\n",
        "", "", "", "", "one way, us", "there and back, us", "", "published",
    );
    text += &format!(
        "{:9} {:16} {:>10} {:>7}  {:>10}{:>10}{:>10}  {:>10}{:>10}{:>10} {:>10} {:>11}\n",
        "transport",
        "wake-up",
        "bytes",
        "count",
        "median",
        "p99",
        "p99.9",
        "median",
        "p99",
        "p99.9",
        "MB/s",
        "once, us",
    );
    for row in rows {
        let LatencyRow { one_way: there, round_trip: back, .. } = row;
        text += &format!(
            "{:9} {:16} {:>10} {:>7}  {:>10.1}{:>10.1}{:>10.1}  {:>10.1}{:>10.1}{:>10.1} {:>10.0} {:>11.1}\n",
            row.transport.name(),
            row.wake_up,
            row.bytes,
            row.count,
            there.median,
            there.p99,
            there.p99_9,
            back.median,
            back.p99,
            back.p99_9,
            row.megabytes_per_s,
            row.publish_us,
        );
    }
    text
}

pub(super) fn engine(args: BenchEngineArgs) -> Result<(), Failure> {
    let interrupt = interrupt::on_ctrl_c().context("cannot listen to Ctrl-C")?;
    let transports = or_all(args.over, &Transport::ALL);
    let mut asked = args.scene;
    asked.engine.transport = transports.first().copied();
    let scene = scene_of(&asked)?;
    for &transport in &transports {
        let engine = EngineOptions { transport, ..scene.engine.clone() };
        engine.check().map_err(Failure::usage)?;
    }
    if scene.accuracy != Accuracy::EXACT {
        return Err(Failure::usage(anyhow!(
            "accuracy {}: engines are compared with exact answers only; see `bumper accuracy`",
            scene.accuracy
        )));
    }
    let poses = Poses::of(&scene.scenarios)?;
    let files = Files { out: args.out.as_deref(), svg: args.svg.as_deref() };
    files.prepare()?;
    let meshes = prepare::load(&scene)?;
    let trees = prepare::build(&meshes, BuildOptions { kind: scene.tree }, None);
    let poses = poses.place(&meshes, &trees, &interrupt)?;
    interrupt::check(&interrupt)?;
    let [fixed_cut, moving_cut] = scene.cuts();
    let load = Load {
        fixed: (Arc::clone(&trees.fixed().image), fixed_cut),
        moving: (Arc::clone(&trees.moving().image), moving_cut),
        poses: &poses,
        engine: scene.engine.clone(),
        program: std::env::current_exe().context("cannot find my own executable")?,
    };
    let time = Duration::from_secs_f64(args.seconds);
    let workers = match args.worker_counts {
        counts if counts.is_empty() => vec![1, scene.engine.worker_count().get()],
        counts => counts.iter().map(|count| count.get().get()).collect(),
    };
    let match_rules = or_all(args.match_rules, &MatchRule::ALL);
    let mut rows = Vec::new();
    for transport in transports {
        for &matchmaker in &match_rules {
            for &workers in &workers {
                let activity = terminal::activity("measuring");
                let combination = (transport, matchmaker, workers);
                let row = throughput::measure(&load, combination, time, &interrupt);
                activity.finish_and_clear();
                rows.push(row.map_err(|error| match error {
                    ThroughputError::Interrupted => interrupt::before_results(),
                    other => other.into(),
                })?);
            }
        }
    }
    let json = to_json(&rows);
    files.write(Source::BenchEngine, &json)?;
    let text = if args.json { json } else { throughput_table(&rows) };
    Ok(terminal::print(&text).context("cannot print the figures")?)
}

fn throughput_table(rows: &[ThroughputRow]) -> String {
    let mut text = format!(
        "{:9} {:10} {:>7} {:>5} {:>12} {:>11} {:>10} {:>13} {:>13} {:>12}\n",
        "transport",
        "matchmaker",
        "workers",
        "runs",
        "scenarios/s",
        "over serial",
        "start, ms",
        "1st result,ms",
        "data transfer",
        "master, us",
    );
    for row in rows {
        text += &format!(
            "{:9} {:10} {:>7} {:>5} {:>12.0} {:>11.2} {:>10.1} {:>13.2} {:>13.3} {:>12.1}\n",
            row.transport.name(),
            row.matchmaker.name(),
            row.workers,
            row.runs,
            row.scenarios_per_s,
            row.over_serial,
            1e3 * row.start_workers_s,
            1e3 * row.first_result_s,
            row.relative_data_transfer,
            row.pre_analysis_us + row.matching_us,
        );
    }
    text
}
