//! The simulation against the engine: the same scene over the same number of workers of this machine.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use serde::Serialize;

use super::config::Config;
use super::events::{Time, nanoseconds};
use super::load::Load;
use super::machine::{Cluster, Copies, MessageCosts};
use super::recording::Recording;
use super::simulation::{Policy, simulate};
use crate::experiment::latency::{self, LatencyError, LatencyOptions, LatencyRow, stream};
use crate::experiment::throughput::{self, ThroughputError};
use crate::scene::{Compression, SubtreesFrom, Transport};
use crate::scheduler::assignment::BufferLimits;
use crate::scheduler::local_client::OUTSTANDING_TASKS;
use crate::transport::WakeUp;

/// With subtrees that are sent, and with geometry in place.
const TRANSPORTS: [Transport; 2] = [Transport::Pipe, Transport::Iceoryx2];
/// Times each transport is measured, in turn with the other.
const ROUNDS: usize = 5;
/// Bytes of a message that is as good as empty.
const SMALL: usize = 64;
/// Of measuring each hand-over, and each stream.
const HAND_OVER_TIME: Duration = Duration::from_millis(300);

/// One transport, simulated and measured. Times in seconds: first task sent to last answer received.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Validated {
    pub transport: Transport,
    pub workers: usize,
    /// The least of one thread without an engine, measured in turn: more than was recorded tells of a
    /// machine that has other things to do.
    pub serial_s: f64,
    pub simulated_s: f64,
    /// The least of several measurements.
    pub best_s: f64,
    pub median_s: f64,
    /// Simulated over the best measured.
    pub over_best: f64,
    pub over_median: f64,
    pub messages: MessageCosts,
}

#[derive(Debug, thiserror::Error)]
pub enum ValidateError {
    #[error(transparent)]
    Latency(#[from] LatencyError),
    #[error(transparent)]
    Throughput(#[from] ThroughputError),
}

/// `load` is what the recording was made of.
pub fn validate(
    config: &Config,
    recording: &Recording,
    load: &throughput::Load<'_>,
    interrupt: &AtomicBool,
) -> Result<Vec<Validated>, ValidateError> {
    let workers = cluster(config, Copies::Process, config.messages).workers();
    let mut measured = TRANSPORTS.map(|_| Vec::new());
    let mut serial_s = [f64::INFINITY; TRANSPORTS.len()];
    let mut messages = Vec::new();
    let subtree = mean_subtree(config, recording);
    for transport in TRANSPORTS {
        messages.push(calibrated(transport, recording, subtree, &load.program, interrupt)?);
    }
    for _ in 0..ROUNDS {
        for (at, transport) in TRANSPORTS.into_iter().enumerate() {
            let combination = (transport, config.run.matchmakers[0], workers as u32);
            let row = throughput::measure(load, combination, Duration::ZERO, interrupt)?;
            measured[at].push(row.scenarios_s);
            serial_s[at] = serial_s[at].min(row.over_serial * row.scenarios_s);
        }
    }
    let rows = TRANSPORTS.into_iter().zip(messages).zip(measured).zip(serial_s);
    Ok(rows
        .map(|(((transport, messages), mut times), serial_s)| {
            times.sort_by(f64::total_cmp);
            let simulated_s = simulated(config, recording, transport, messages);
            let (best_s, median_s) = (times[0], times[times.len() / 2]);
            Validated {
                transport,
                workers,
                serial_s,
                simulated_s,
                best_s,
                median_s,
                over_best: simulated_s / best_s,
                over_median: simulated_s / median_s,
                messages,
            }
        })
        .collect())
}

/// Bytes.
fn mean_subtree(config: &Config, recording: &Recording) -> usize {
    let cut = recording.cut(config.run.point.depths).expect("the recording has every cut");
    let bytes = || cut.subtrees.iter().flat_map(|subtrees| &subtrees.bytes);
    bytes().sum::<u64>() as usize / bytes().count().max(1)
}

fn simulated(
    config: &Config,
    recording: &Recording,
    transport: Transport,
    messages: MessageCosts,
) -> f64 {
    let copies = match transport {
        Transport::Iceoryx2 | Transport::Threads => Copies::Node,
        Transport::Pipe | Transport::Socket => Copies::Process,
    };
    let cut = recording.cut(config.run.point.depths).expect("the recording has every cut");
    let load = Load::of(recording, cut, Compression::None, &config.scale);
    let (rule, scenarios) = (config.run.matchmakers[0], config.run.point.buffer.get());
    let buffer = BufferLimits { scenarios, bytes: config.run.buffer_bytes };
    let (most_tasks, from, seed) = (OUTSTANDING_TASKS, SubtreesFrom::Master, config.run.match_seed);
    let policy = Policy { rule, most_tasks, from, seed, buffer, holds_back: false };
    let cluster = cluster(config, copies, messages);
    simulate(&load, &cluster, &policy, recording.serial_ns.len() as u32, &|_| {}).time_s
}

fn cluster(config: &Config, copies: Copies, messages: MessageCosts) -> Cluster {
    Cluster {
        nodes: config.nodes(&config.run.point.nodes),
        master: config.master,
        link: config.link,
        messages,
        copies,
        memory: config.memory,
    }
}

/// What messages cost. By handing a short one over to a worker that sleeps: its sender, waking its
/// receiver, and its receiver a third each. Where subtrees are sent, by streams as well: what goes
/// together with others, and copying, of which the master's and the worker's part is the mean of both.
fn calibrated(
    transport: Transport,
    recording: &Recording,
    subtree: usize,
    program: &Path,
    interrupt: &AtomicBool,
) -> Result<MessageCosts, LatencyError> {
    // On a thread of its own: it is pinned to a core, and whoever it starts would be.
    let measuring = || -> Result<_, LatencyError> {
        let third = nanoseconds(one_way_s(transport, program, interrupt)? / 3.0);
        let (gathered, copy_bytes_per_s) = match transport {
            Transport::Pipe => in_streams(subtree, program, interrupt)?,
            _ => (third, f64::INFINITY),
        };
        Ok(MessageCosts {
            send: third,
            receive: third,
            gathered,
            copy_bytes_per_s,
            wake_up: third,
            score_root: recording.score_root_ns,
            delivery: 0,
        })
    };
    let measured = std::thread::scope(|scope| scope.spawn(measuring).join());
    measured.expect("measuring does not panic")
}

fn one_way_s(
    transport: Transport,
    program: &Path,
    interrupt: &AtomicBool,
) -> Result<f64, LatencyError> {
    let options = LatencyOptions {
        transports: vec![transport],
        wake_ups: vec![WakeUp::Block],
        sizes: vec![SMALL],
        time: HAND_OVER_TIME,
        program: program.to_owned(),
    };
    let mut one_way_s = 0.0;
    let mut take = |row: LatencyRow| one_way_s = row.one_way.median * 1e-6;
    latency::measure(&options, interrupt, &mut take)?;
    Ok(one_way_s)
}

/// Of a message without contents, and the rate of copying, by messages of as many bytes as a subtree.
fn in_streams(
    subtree: usize,
    program: &Path,
    interrupt: &AtomicBool,
) -> Result<(Time, f64), LatencyError> {
    let sizes = [SMALL, subtree.max(2 * SMALL)];
    let streams = stream::through_a_pipe(&sizes, HAND_OVER_TIME, program.to_owned(), interrupt)?;
    let cost = |at: usize| (streams[at].master_ns + streams[at].worker_ns) / 2.0;
    let copying_s = 1e-9 * (cost(1) - cost(0));
    let bytes = (streams[1].bytes - streams[0].bytes) as f64;
    let rate = if copying_s > 0.0 { bytes / copying_s } else { f64::INFINITY };
    Ok((cost(0) as Time, rate))
}
