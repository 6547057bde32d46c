//! The simulation against the engine: the same scene over the same number of workers of this machine.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use serde::Serialize;

use super::config::Config;
use super::events::{Time, nanoseconds};
use super::load::Load;
use super::machine::{Cluster, Copies, MessageCosts};
use super::recording::Recording;
use super::simulation::{Policy, simulate};
use crate::experiment::latency::{self, LatencyError, LatencyOptions, LatencyRow};
use crate::experiment::throughput::{self, ThroughputError};
use crate::scene::{Compression, SubtreesFrom, Transport};
use crate::scheduler::assignment::BufferLimits;
use crate::scheduler::local_client::OUTSTANDING_TASKS;
use crate::transport::WakeUp;

/// With subtrees that are sent, and with geometry in place.
const TRANSPORTS: [Transport; 2] = [Transport::Pipe, Transport::Iceoryx2];
/// Times each transport is measured, in turn with the other.
const ROUNDS: usize = 5;
/// By whose hand-over messages are calibrated, in bytes.
const SMALL: usize = 64;
const LARGE: usize = 1 << 20;
/// Of measuring each hand-over.
const HAND_OVER_TIME: Duration = Duration::from_millis(300);

/// One transport, simulated and measured. Times in seconds: first task sent to last answer received.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Validated {
    pub transport: Transport,
    pub workers: usize,
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
    let mut messages = Vec::new();
    for transport in TRANSPORTS {
        messages.push(calibrated(transport, recording, load.program.clone(), interrupt)?);
    }
    for _ in 0..ROUNDS {
        for (times, transport) in measured.iter_mut().zip(TRANSPORTS) {
            let combination = (transport, config.run.matchmakers[0], workers as u32);
            times.push(
                throughput::measure(load, combination, Duration::ZERO, interrupt)?.scenarios_s,
            );
        }
    }
    let rows = TRANSPORTS.into_iter().zip(messages).zip(measured);
    Ok(rows
        .map(|((transport, messages), mut times)| {
            times.sort_by(f64::total_cmp);
            let simulated_s = simulated(config, recording, transport, messages);
            let (best_s, median_s) = (times[0], times[times.len() / 2]);
            Validated {
                transport,
                workers,
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
    let policy = Policy { rule, most_tasks, from, seed, buffer };
    let cluster = cluster(config, copies, messages);
    simulate(&load, &cluster, &policy, recording.serial_ns.len() as u32).time_s
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

/// What messages cost, by handing over to a worker that sleeps. A message without contents takes its
/// sender, waking its receiver, and its receiver a third each; contents are copied twice, into the
/// stream and out of it.
fn calibrated(
    transport: Transport,
    recording: &Recording,
    program: PathBuf,
    interrupt: &AtomicBool,
) -> Result<MessageCosts, LatencyError> {
    let options = LatencyOptions {
        transports: vec![transport],
        wake_ups: vec![WakeUp::Block],
        sizes: vec![SMALL, LARGE],
        time: HAND_OVER_TIME,
        program,
    };
    // On a thread of its own: it is pinned to a core, and whoever it starts would be.
    let measuring = || -> Result<Vec<f64>, LatencyError> {
        let mut one_way_s = Vec::new();
        let mut take = |row: LatencyRow| one_way_s.push(row.one_way.median * 1e-6);
        latency::measure(&options, interrupt, &mut take)?;
        Ok(one_way_s)
    };
    let measured = std::thread::scope(|scope| scope.spawn(measuring).join());
    let one_way_s = measured.expect("measuring does not panic")?;
    let (small, large) = (one_way_s[0], one_way_s[1]);
    let third: Time = nanoseconds(small / 3.0);
    let copying = (large - small) / 2.0;
    let is_copied = matches!(transport, Transport::Pipe | Transport::Socket) && copying > 0.0;
    Ok(MessageCosts {
        send: third,
        receive: third,
        copy_bytes_per_s: if is_copied { LARGE as f64 / copying } else { f64::INFINITY },
        wake_up: third,
        score_root: recording.score_root_ns,
        delivery: 0,
    })
}
