//! One run, from the first process started to the last result delivered.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{EngineError, EngineOptions, ResultSink, ScenarioResult, Work};
use crate::scheduler::assignment::Assignment;
use crate::scheduler::collection::{Collection, Outcome, Said};
use crate::scheduler::engine_report::{EngineReport, WorkerReport};
use crate::scheduler::jobs_submitter::JobsSubmitter;
use crate::scheduler::local_client::Indicators;
use crate::scheduler::worker_process::WorkerProcess;
use crate::transport::{MasterEnd, WorkerId};
use crate::tree::roots::PreAnalysis;
use crate::wire::{JobHeader, ScenarioRecord, TreeHashes};
use crate::workers::{FIXED_MESH, MOVING_MESH};

/// How soon an interrupt and a late worker are noticed. Everything else wakes the master.
const TICK: Duration = Duration::from_millis(100);
/// Attaching and validating both trees takes milliseconds; a machine under load gets its time.
const READY_DEADLINE: Duration = Duration::from_secs(30);

/// A worker as a process, beside the [`LocalClient`] of the same index.
pub(super) struct Worker {
    pub(super) id: WorkerId,
    /// `None` once it has ended and been reaped.
    pub(super) process: Option<WorkerProcess>,
    pub(super) started: Instant,
}

pub(super) struct Session<'a, T> {
    /// Before the transport, so that no worker is alive when its files are removed.
    pub(super) workers: Vec<Worker>,
    pub(super) transport: T,
    work: Work<'a>,
    options: &'a EngineOptions,
    pub(super) assignment: Assignment,
    pub(super) collection: Collection,
    /// With one worker there is nothing to match.
    submitter: Option<JobsSubmitter<'a>>,
    pub(super) report: EngineReport,
    pre_analysis: Duration,
    start: Option<Instant>,
    first_batch: Option<Instant>,
    last_answers: Option<Instant>,
    pub(super) ready_deadline: Duration,
    /// Of the worker that died last.
    pub(super) last_words: String,
}

impl<'a, T: MasterEnd> Session<'a, T> {
    pub(super) fn new(
        transport: T,
        work: Work<'a>,
        options: &'a EngineOptions,
    ) -> Result<Self, EngineError> {
        let scenarios = u32::try_from(work.poses.len())
            .map_err(|_| EngineError::TooManyScenarios(work.poses.len()))?;
        let workers = options.workers_for(work.poses.len()) as usize;
        let trees = TreeHashes { fixed: work.fixed.hash(), moving: work.moving.hash() };
        let report = EngineReport {
            transport: transport.name(),
            workers: vec![WorkerReport::default(); workers],
            ..EngineReport::default()
        };
        let submitter = (workers > 1).then(|| {
            let (fixed_depth, moving_depth) = (options.fixed_depth, options.moving_depth);
            let analysis = PreAnalysis::new(work.fixed, fixed_depth, work.moving, moving_depth);
            JobsSubmitter::new(analysis)
        });
        Ok(Self {
            workers: Vec::with_capacity(workers),
            transport,
            work,
            options,
            assignment: Assignment::new(workers, scenarios, options.buffer_scenarios.get()),
            collection: Collection::new(workers, trees, options.send_pairs),
            submitter,
            report,
            pre_analysis: Duration::ZERO,
            start: None,
            first_batch: None,
            last_answers: None,
            ready_deadline: READY_DEADLINE,
            last_words: String::new(),
        })
    }

    pub(super) fn start_workers(&mut self) -> Result<(), EngineError> {
        self.start = Some(Instant::now());
        for slot in 0..self.options.workers_for(self.work.poses.len()) {
            let id = WorkerId { slot, incarnation: 0 };
            let attach = self.transport.open(id)?;
            let program = &self.options.worker_program;
            let process = WorkerProcess::start(program, &attach)
                .map_err(|source| EngineError::StartWorker { program: program.clone(), source })?;
            tracing::debug!("worker {id} is process {}", process.pid());
            self.workers.push(Worker { id, process: Some(process), started: Instant::now() });
        }
        Ok(())
    }

    /// After the workers were started: their attaching overlaps with it.
    pub(super) fn publish(&mut self) -> Result<(), EngineError> {
        let begin = Instant::now();
        for (mesh, tree) in [(FIXED_MESH, self.work.fixed), (MOVING_MESH, self.work.moving)] {
            self.report.bytes_published +=
                self.transport.publish(mesh, bytemuck::cast_slice(tree.blocks()))?;
        }
        self.report.publish_s = begin.elapsed().as_secs_f64();
        Ok(())
    }

    /// Returns whether it was interrupted.
    pub(super) fn serve(
        &mut self,
        sink: &mut dyn ResultSink,
        interrupt: &AtomicBool,
    ) -> Result<bool, EngineError> {
        while !self.is_everything_answered() {
            if interrupt.load(Ordering::Relaxed) {
                self.assignment.stop_at(0);
                return Ok(true);
            }
            self.give_work()?;
            self.wait(TICK)?;
            self.collect()?;
            self.bury_the_dead()?;
            self.deliver(sink)?;
            self.assignment.delivered(self.collection.delivered());
            if !self.assignment.is_anyone_alive() && !self.is_everything_answered() {
                let (completed, last) = (self.report.completed, self.last_words.clone());
                return Err(EngineError::AllWorkersDied { completed, last });
            }
            self.end_late_starters();
        }
        Ok(false)
    }

    fn is_everything_answered(&self) -> bool {
        self.collection.delivered() as usize == self.work.poses.len()
    }

    /// Fills the buffers of unclaimed clients, and sends those that are full.
    fn give_work(&mut self) -> Result<(), EngineError> {
        while self.assignment.is_anyone_unclaimed() {
            let Some(scenario) = self.assignment.next_scenario() else { break };
            let indicators = self.pre_analyse(scenario);
            self.assignment.assign(scenario, &indicators).expect("somebody is unclaimed");
            self.send_tasks()?;
        }
        self.send_tasks()
    }

    /// Which geometry a scenario needs matters only to the choice of a client. A worker has all of
    /// it in place: what it was given without a match is not noted.
    fn pre_analyse(&mut self, scenario: u32) -> Indicators {
        match &mut self.submitter {
            Some(submitter) if self.assignment.has_choice() => {
                let begin = Instant::now();
                let indicators = submitter.indicators(&self.work.poses[scenario as usize]);
                self.pre_analysis += begin.elapsed();
                indicators
            }
            _ => Indicators::default(),
        }
    }

    /// To every client with a full buffer: what counts as full changes for all of them.
    fn send_tasks(&mut self) -> Result<(), EngineError> {
        (0..self.workers.len()).try_for_each(|client| self.send_task(client))
    }

    fn send_task(&mut self, client: usize) -> Result<(), EngineError> {
        let Some((task, scenarios)) = self.assignment.take_task(client) else { return Ok(()) };
        let pose = |scenario: u32| self.work.poses[scenario as usize];
        let records: Vec<_> = scenarios.iter().map(|&s| ScenarioRecord::new(s, pose(s))).collect();
        let header = JobHeader::scenarios(task, records.len() as u32, self.options.send_pairs);
        self.first_batch.get_or_insert_with(Instant::now);
        self.report.workers[client].batches += 1;
        let parts = [bytemuck::bytes_of(&header), bytemuck::cast_slice(&records)];
        self.send_or_kill(client, &parts)
    }

    pub(super) fn wait(&mut self, limit: Duration) -> Result<(), EngineError> {
        let processes = self.workers.iter().filter_map(|worker| worker.process.as_ref());
        let watched: Vec<_> = processes.map(WorkerProcess::death_notice).collect();
        Ok(self.transport.wait(&watched, limit)?)
    }

    pub(super) fn collect(&mut self) -> Result<(), EngineError> {
        (0..self.workers.len()).try_for_each(|client| self.collect_from(client))
    }

    pub(super) fn collect_from(&mut self, client: usize) -> Result<(), EngineError> {
        let Worker { id, process: Some(_), .. } = self.workers[client] else { return Ok(()) };
        let (collection, assignment) = (&mut self.collection, &mut self.assignment);
        let mut outcome = Ok(None);
        self.transport.receive(id, &mut |message| {
            if outcome.is_ok() {
                outcome = collection.take(client, message, assignment).map(Some);
            }
        })?;
        match outcome {
            Ok(None) => {}
            Ok(Some(Said::Answers)) => self.last_answers = Some(Instant::now()),
            Ok(Some(Said::Ready)) => {
                let since = self.start.expect("a ready worker was started");
                self.report.start_workers_s = since.elapsed().as_secs_f64();
            }
            Err(source) => return Err(EngineError::BadReply { worker: id, source }),
        }
        Ok(())
    }

    pub(super) fn deliver(&mut self, sink: &mut dyn ResultSink) -> Result<(), EngineError> {
        while let Some((scenario, outcome)) = self.collection.pop() {
            let (client, record, pairs) = match outcome {
                Outcome::Answered { client, record, pairs } => (client, record, pairs),
                Outcome::Overflow { triangle } => {
                    return Err(EngineError::Overflow { scenario, triangle });
                }
            };
            let report = &mut self.report.workers[client];
            report.scenarios += 1;
            report.compute_s += Duration::from_nanos(record.compute_ns).as_secs_f64();
            let result = ScenarioResult {
                scenario,
                pair_count: record.pair_count,
                pairs_fnv1a64: record.pairs_fnv1a64,
                compute_ns: record.compute_ns,
                worker: client as u32,
                pairs: &pairs,
            };
            sink.accept(result).map_err(EngineError::Sink)?;
            self.report.completed += 1;
        }
        Ok(())
    }

    pub(super) fn into_report(mut self, interrupted: bool) -> EngineReport {
        self.report.interrupted = interrupted;
        self.report.pre_analysis_s = self.pre_analysis.as_secs_f64();
        if let (Some(first), Some(last)) = (self.first_batch, self.last_answers) {
            self.report.scenarios_s = last.saturating_duration_since(first).as_secs_f64();
        }
        self.report
    }
}
