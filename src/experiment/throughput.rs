//! The same scenarios over each transport, matchmaker and number of workers.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::effects::contacts::{contacts, pairs_fnv1a64};
use crate::geometry::Pose;
use crate::scene::{EngineOptions, MatchRule, Transport, WorkerCount};
use crate::scheduler::client_manager::{
    EngineError, EngineReport, ResultSink, ScenarioResult, Work, start,
};
use crate::tree::TreeImage;
use crate::tree::descent::{Descent, DescentError};
use crate::tree::roots::Cut;
use crate::wire::Wanted;

/// One combination; the best of its runs, as what disturbs a run only makes it slower.
#[derive(Clone, Debug, serde::Serialize)]
pub struct ThroughputRow {
    pub transport: Transport,
    pub matchmaker: MatchRule,
    pub workers: u32,
    pub runs: u32,
    /// First batch sent to last result received.
    pub scenarios_s: f64,
    pub scenarios_per_s: f64,
    /// Over one thread that answers the same without an engine, measured in turn.
    pub over_serial: f64,
    /// From when workers, trees and poses are there to the first result.
    pub first_result_s: f64,
    /// First process started to last worker ready.
    pub start_workers_s: f64,
    pub relative_data_transfer: f64,
    /// The master's time for each scenario, in microseconds.
    pub pre_analysis_us: f64,
    pub matching_us: f64,
}

/// What is run.
pub struct Load<'a> {
    pub fixed: (Arc<TreeImage>, Cut),
    pub moving: (Arc<TreeImage>, Cut),
    pub poses: &'a [Pose],
    pub engine: EngineOptions,
    pub program: PathBuf,
}

#[derive(Debug, thiserror::Error)]
pub enum ThroughputError {
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    Descent(#[from] DescentError),
    #[error(
        "{transport:?}, {matchmaker:?}, {workers} workers: scenario {scenario} has other pairs"
    )]
    Answers { transport: Transport, matchmaker: MatchRule, workers: u32, scenario: usize },
    #[error("interrupted")]
    Interrupted,
}

/// Number of pairs and their hash.
type Answer = (u32, u64);

/// One after the other on this thread, without an engine: what there is to answer, and the seconds
/// that it takes.
pub(super) fn serial(
    load: &Load<'_>,
    interrupt: &AtomicBool,
) -> Result<(Vec<Answer>, f64), ThroughputError> {
    let (mut descent, mut pairs) = (Descent::default(), Vec::new());
    let (fixed, moving) = (load.fixed.0.view(), load.moving.0.view());
    let begin = Instant::now();
    let answers: Result<Vec<_>, _> = load
        .poses
        .iter()
        .map(|pose| {
            if interrupt.load(Ordering::Relaxed) {
                return Err(ThroughputError::Interrupted);
            }
            contacts(&mut descent, &fixed, &moving, pose, &mut pairs)?;
            Ok((pairs.len() as u32, pairs_fnv1a64(&pairs)))
        })
        .collect();
    Ok((answers?, begin.elapsed().as_secs_f64()))
}

/// The serial answers, and a run of an engine that gave the same.
pub(super) struct Turn {
    pub answers: Vec<Answer>,
    pub serial_s: f64,
    pub report: EngineReport,
}

/// Both one right after the other, so that whatever else the machine does, it does to both.
pub(super) fn in_turn(
    load: &Load<'_>,
    engine: &EngineOptions,
    interrupt: &AtomicBool,
) -> Result<Turn, ThroughputError> {
    let (answers, serial_s) = serial(load, interrupt)?;
    let (report, found) = run(load, engine.clone(), interrupt)?;
    match first_difference(&answers, &found) {
        None => Ok(Turn { answers, serial_s, report }),
        Some(scenario) => {
            let EngineOptions { transport, matchmaker, .. } = *engine;
            let workers = engine.worker_count().get();
            Err(ThroughputError::Answers { transport, matchmaker, workers, scenario })
        }
    }
}

/// The first scenario that has another answer, or one too few or too many.
fn first_difference(answers: &[Answer], found: &[Answer]) -> Option<usize> {
    let longest = answers.len().max(found.len());
    (0..longest).find(|&scenario| answers.get(scenario) != found.get(scenario))
}

/// One combination, its answers checked, in turn with the serial engine, until the time is over.
pub fn measure(
    load: &Load<'_>,
    (transport, matchmaker, workers): (Transport, MatchRule, u32),
    time: Duration,
    interrupt: &AtomicBool,
) -> Result<ThroughputRow, ThroughputError> {
    let count = WorkerCount::new(workers.into()).expect("a number of workers");
    let engine =
        EngineOptions { workers: Some(count), transport, matchmaker, ..load.engine.clone() };
    let mut best: Option<EngineReport> = None;
    let (mut serial_s, mut runs) = (f64::INFINITY, 0);
    let begin = Instant::now();
    while runs < 2 || begin.elapsed() < time {
        let turn = in_turn(load, &engine, interrupt)?;
        serial_s = serial_s.min(turn.serial_s);
        runs += 1;
        if best.as_ref().is_none_or(|best| turn.report.scenarios_s < best.scenarios_s) {
            best = Some(turn.report);
        }
    }
    let report = best.expect("there was a run");
    let scenarios = load.poses.len().max(1) as f64;
    Ok(ThroughputRow {
        transport,
        matchmaker,
        workers,
        runs,
        scenarios_s: report.scenarios_s,
        scenarios_per_s: scenarios / report.scenarios_s,
        over_serial: serial_s / report.scenarios_s,
        first_result_s: report.first_result_s,
        start_workers_s: report.start_workers_s,
        relative_data_transfer: report.relative_data_transfer,
        pre_analysis_us: report.pre_analysis_s / scenarios * 1e6,
        matching_us: report.matching_s / scenarios * 1e6,
    })
}

fn run(
    load: &Load<'_>,
    options: EngineOptions,
    interrupt: &AtomicBool,
) -> Result<(EngineReport, Vec<Answer>), ThroughputError> {
    let mut engine = start(options, load.program.clone())?;
    let fixed = engine.add_mesh(Arc::clone(&load.fixed.0))?;
    let is_one = Arc::ptr_eq(&load.fixed.0, &load.moving.0);
    let moving = if is_one { fixed } else { engine.add_mesh(Arc::clone(&load.moving.0))? };
    let work = Work {
        effects: None,
        fixed: (fixed, load.fixed.1),
        moving: (moving, load.moving.1),
        poses: load.poses,
        wanted: Wanted::default(),
    };
    let mut answers = Answers(Vec::with_capacity(load.poses.len()));
    let report = engine.run(&work, &mut answers, interrupt)?;
    if report.interrupted { Err(ThroughputError::Interrupted) } else { Ok((report, answers.0)) }
}

struct Answers(Vec<Answer>);

impl ResultSink for Answers {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()> {
        self.0.push((result.pair_count, result.pairs_fnv1a64));
        Ok(())
    }

    fn set_aside(&mut self, scenario: u32) -> io::Result<()> {
        Err(io::Error::other(format!("every worker at scenario {scenario} has died")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_is_wrong_missing_or_too_many_is_found() {
        let right = [(0, 1), (2, 3), (4, 5)];
        assert_eq!(first_difference(&right, &right), None);
        assert_eq!(first_difference(&right, &[(0, 1), (3, 3), (4, 5)]), Some(1), "their number");
        assert_eq!(first_difference(&right, &[(0, 1), (2, 9), (4, 5)]), Some(1), "their hash");
        assert_eq!(first_difference(&right, &right[..2]), Some(2));
        assert_eq!(first_difference(&right[..2], &right), Some(2));
    }
}
