//! One run: what is with whom, and what has come back.

mod tasks;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::engine::{Engine, TreeKey};
use super::planned::Planned;
use super::supply::{Published, Supply, Way};
use super::{EngineError, ResultSink, ScenarioResult, Work};
use crate::scene::SubtreesFrom;
use crate::scheduler::assignment::{Assignment, BufferLimits};
use crate::scheduler::collection::{BadReply, Collection, Outcome, Said};
use crate::scheduler::engine_report::{EngineReport, NodeReport, TransferReport, WorkerReport};
use crate::scheduler::jobs_submitter::JobsSubmitter;
use crate::scheduler::launch::Launch;
use crate::scheduler::local_client::{LocalClient, SubtreeBytes};
use crate::scheduler::matchmaker::Matchmaker;
use crate::scheduler::memory;
use crate::scheduler::node::Nodes;
use crate::scheduler::sources::Sources;
use crate::transport::peer::PeerName;
use crate::transport::{MasterEnd, Traffic};
use crate::tree::roots::PreAnalysis;
use crate::tree::{Accuracy, TreeImage};
use crate::wire::Wanted;

/// How soon an interrupt and a late or silent worker are noticed. Everything else wakes the master.
pub(super) const TICK: Duration = Duration::from_millis(100);
/// After an interrupt, for what workers are at to be answered.
const GRACE: Duration = Duration::from_secs(1);

pub(super) struct Session<'e, T: MasterEnd, L: Launch<T::Attach>> {
    engine: &'e mut Engine<T, L>,
    work: &'e Work<'e>,
    /// The fixed and the moving one.
    trees: [u32; 2],
    supply: Supply<'e>,
    planned: Option<Planned>,
    wanted: Wanted,
    assignment: Assignment,
    /// Absent: subtrees come from the master alone.
    sources: Option<Sources>,
    collection: Collection,
    submitter: JobsSubmitter<'e>,
    report: EngineReport,
    /// Bytes of both trees.
    tree_bytes: usize,
    /// Of each worker's place, when the run began.
    traffic_before: Vec<Traffic>,
    restarts_before: Vec<u32>,
    pre_analysis: Duration,
    matching: Duration,
    begin: Instant,
    first_batch: Option<Instant>,
    last_answers: Option<Instant>,
    /// When patience was last looked to.
    looked: Instant,
    /// After an interrupt nobody is replaced any more.
    is_ending: bool,
    /// Per client those that its node has published, and that it may not have taken yet.
    long_batches: Vec<VecDeque<u32>>,
}

impl<'e, T: MasterEnd, L: Launch<T::Attach>> Session<'e, T, L> {
    /// Takes the engine's clients for the time of the run.
    pub(super) fn new(
        engine: &'e mut Engine<T, L>,
        work: &'e Work<'e>,
        keys: [TreeKey; 2],
        trees: [u32; 2],
        images: [&'e TreeImage; 2],
        planned: Option<Planned>,
    ) -> Result<Self, EngineError> {
        let cuts = keys.map(|key| key.cut);
        if let Accuracy::BoxesAt(depth) = work.wanted.accuracy
            && cuts != [depth.cut(); 2]
        {
            return Err(EngineError::BoxesElsewhere { accuracy: work.wanted.accuracy });
        }
        let scenarios = u32::try_from(work.poses.len())
            .map_err(|_| EngineError::TooManyScenarios(work.poses.len()))?;
        let options = &engine.options;
        let published = Published::of(&mut engine.crew.transport);
        let views = images.map(TreeImage::view);
        let (supply, transfer) =
            Supply::new(published, keys, options.start_from, views, options.compress)?;
        let workers = engine.crew.len();
        let limits = BufferLimits {
            scenarios: options.buffer_scenarios.get(),
            bytes: options
                .buffer_kilobytes
                .map_or_else(|| memory::free() / workers as u64, |v| 1000 * v.get()),
        };
        let matchmaker =
            Matchmaker::new(options.matchmaker, limits.scenarios as usize, options.match_seed);
        let report = EngineReport {
            transport: engine.crew.transport.name(),
            matchmaker: options.matchmaker,
            start_from: supply.start_from(),
            completed: 0,
            interrupted: false,
            set_aside: Vec::new(),
            bytes_published: engine.bytes_published,
            bytes_sent: 0,
            relative_data_transfer: 0.0,
            transfer: TransferReport { subtrees_from: options.subtrees_from, ..transfer },
            publish_s: engine.publish_s,
            start_workers_s: 0.0,
            first_result_s: 0.0,
            scenarios_s: 0.0,
            pre_analysis_s: 0.0,
            matching_s: 0.0,
            workers: vec![WorkerReport::default(); workers],
            nodes: vec![NodeReport::default(); engine.nodes.count()],
        };
        let layout = planned.as_ref().map(|planned| planned.layout.clone()).unwrap_or_default();
        let plan = planned.as_ref().map(|planned| planned.number);
        let wanted = Wanted { plan, ..work.wanted };
        let clients = std::mem::take(&mut engine.clients);
        let mut nodes = std::mem::take(&mut engine.nodes);
        let subtree_bytes = supply.subtree_bytes();
        if published == Published::InThisNode {
            nodes.all_mut()[0].give_all(subtree_bytes.each_ref().map(Vec::len));
        }
        let sources = sources(engine, &nodes, published, &subtree_bytes);
        // With effects a node has all before any scenario.
        let is_sent_more =
            |node: usize| planned.is_none() && matches!(supply.way(node), Way::ByNode(_));
        let assignment =
            Assignment::new(clients, nodes, scenarios, limits, matchmaker, subtree_bytes)
                .holding_back(is_sent_more);
        let traffic_before = (0..workers).map(|client| engine.crew.traffic(client)).collect();
        let restarts_before = (0..workers).map(|client| engine.crew.restarts(client)).collect();
        Ok(Self {
            engine,
            work,
            trees,
            supply,
            planned,
            wanted,
            assignment,
            sources,
            collection: Collection::new(workers, trees, views, wanted, layout),
            submitter: JobsSubmitter::new(PreAnalysis::new(
                views[0],
                keys[0].cut,
                views[1],
                keys[1].cut,
            )),
            report,
            tree_bytes: images.iter().map(|image| size_of_val(image.blocks())).sum(),
            traffic_before,
            restarts_before,
            pre_analysis: Duration::ZERO,
            matching: Duration::ZERO,
            begin: Instant::now(),
            first_batch: None,
            last_answers: None,
            looked: Instant::now(),
            is_ending: false,
            long_batches: vec![VecDeque::new(); workers],
        })
    }

    /// Gives the clients back, and their nodes.
    pub(super) fn into_clients(self) -> (Vec<LocalClient>, Nodes) {
        self.assignment.into_clients()
    }

    /// Returns whether it was interrupted.
    pub(super) fn serve(
        &mut self,
        sink: &mut dyn ResultSink,
        interrupt: &AtomicBool,
    ) -> Result<bool, EngineError> {
        for client in 0..self.engine.crew.len() {
            self.introduce(client)?;
        }
        while !self.is_everything_answered() {
            if interrupt.load(Ordering::Relaxed) {
                self.assignment.stop_at(0);
                return Ok(true);
            }
            self.give_work()?;
            self.listen(TICK, sink)?;
            if !self.assignment.is_anyone_alive() && !self.is_everything_answered() {
                let last = self.engine.crew.last_words.clone();
                return Err(EngineError::AllWorkersDied { completed: self.report.completed, last });
            }
            self.lose_patience();
        }
        Ok(false)
    }

    /// Takes what comes, and deals with who has died.
    fn listen(&mut self, limit: Duration, sink: &mut dyn ResultSink) -> Result<(), EngineError> {
        self.engine.crew.wait(limit)?;
        self.assignment.now_is(self.begin.elapsed());
        for client in 0..self.engine.crew.len() {
            self.collect_from(client)?;
            self.bury(client)?;
        }
        self.deliver(sink)?;
        self.assignment.delivered(self.collection.delivered());
        Ok(())
    }

    fn is_everything_answered(&self) -> bool {
        self.collection.delivered() as usize == self.work.poses.len()
    }

    fn collect_from(&mut self, client: usize) -> Result<(), EngineError> {
        let (collection, assignment) = (&mut self.collection, &mut self.assignment);
        let mut heard = Heard::default();
        self.engine.crew.receive(client, &mut |message| {
            heard.take(collection.take(client, message, assignment));
        })?;
        self.act_on(client, heard)
    }

    fn act_on(&mut self, client: usize, heard: Heard) -> Result<(), EngineError> {
        if heard.is_ready && self.engine.crew.restarts(client) == 0 {
            let since_start = self.engine.started.elapsed().as_secs_f64();
            self.report.start_workers_s = self.report.start_workers_s.max(since_start);
        }
        if heard.is_ready {
            self.introduce(client)?;
        }
        if let Some(name) = heard.name {
            self.engine.crew.serves(client, name);
            let node = self.assignment.nodes.of(client);
            self.sources.iter_mut().for_each(|sources| sources.opens(node));
        }
        for (tree, root) in heard.not_fetched {
            self.send_instead(client, tree, root)?;
        }
        for task in &heard.answered {
            let fetched = self.sources.as_mut().map_or(0, |sources| sources.answered(*task));
            *self.bytes_from_others(client) += fetched;
        }
        if !heard.answered.is_empty() {
            let now = Instant::now();
            if self.last_answers.replace(now).is_none() {
                self.report.first_result_s = (now - self.begin).as_secs_f64();
            }
        }
        match heard.bad {
            None => Ok(()),
            Some(source) => {
                Err(EngineError::BadReply { worker: self.engine.crew.id(client), source })
            }
        }
    }

    /// Results first, then what is left of the work: a worker's last replies outlive it.
    fn bury(&mut self, client: usize) -> Result<(), EngineError> {
        let Some(how) = self.engine.crew.ended(client)? else { return Ok(()) };
        self.engine.crew.obituary(client, &how);
        let at = self.engine.crew.scenario(client);
        let (collection, assignment) = (&mut self.collection, &mut self.assignment);
        let mut heard = Heard::default();
        self.engine.crew.let_go(client, &mut |message| {
            heard.take(collection.take(client, message, assignment));
        })?;
        // What it could not fetch, or could give to others, matters no more.
        let heard = Heard { is_ready: false, name: None, not_fetched: Vec::new(), ..heard };
        self.act_on(client, heard)?;
        self.report.workers[client].died = true;
        if let Some(node) = self.assignment.nodes.lost_with(client) {
            self.engine.forget_given(node);
            self.sources.iter_mut().for_each(|sources| sources.lost(node));
        }
        self.collection.client_died(client);
        if let Some(scenario) = self.assignment.client_died(client, at) {
            tracing::warn!("scenario {scenario} is set aside: every worker at it has died");
            self.collection.set_aside(scenario);
        }
        if !self.is_ending && self.engine.crew.replace(client) {
            self.assignment.restart(client);
        }
        Ok(())
    }

    /// Time in which the master itself did not listen, because it was stopped or a sink was slow, is
    /// nobody's fault.
    fn lose_patience(&mut self) {
        let away = std::mem::replace(&mut self.looked, Instant::now()).elapsed();
        self.engine.crew.forgive(away.saturating_sub(2 * TICK));
        for (client, state) in self.assignment.clients().iter().enumerate() {
            if state.is_starting() {
                self.engine.crew.end_late_starter(client);
            } else if state.tasks() > 0 || state.awaits_trees() {
                self.engine.crew.end_silent(client, self.engine.options.patience);
            }
        }
    }

    fn deliver(&mut self, sink: &mut dyn ResultSink) -> Result<(), EngineError> {
        while let Some((scenario, outcome)) = self.collection.pop() {
            match outcome {
                Outcome::Overflow { triangle, corner } => {
                    return Err(EngineError::Overflow { scenario, triangle, corner });
                }
                Outcome::SetAside => {
                    sink.set_aside(scenario).map_err(EngineError::Sink)?;
                    self.report.set_aside.push(scenario);
                }
                Outcome::Answered { client, record, cost, pairs, effects } => {
                    let report = &mut self.report.workers[client];
                    report.scenarios += 1;
                    report.compute_s += Duration::from_nanos(record.compute_ns).as_secs_f64();
                    let layout = self.collection.layout();
                    let effects = layout.read(&effects).expect("checked as it came");
                    let result = ScenarioResult {
                        scenario,
                        pair_count: record.pair_count,
                        pairs_fnv1a64: record.pairs_fnv1a64,
                        compute_ns: record.compute_ns,
                        cost,
                        worker: client as u32,
                        pairs: &pairs,
                        effects,
                    };
                    sink.accept(result).map_err(EngineError::Sink)?;
                    self.report.completed += 1;
                }
            }
        }
        Ok(())
    }

    /// After an interrupt waits a little for what workers are at.
    pub(super) fn end(
        &mut self,
        sink: &mut dyn ResultSink,
        interrupted: bool,
    ) -> Result<EngineReport, EngineError> {
        self.is_ending = true;
        let deadline = Instant::now() + GRACE;
        while interrupted && self.assignment.clients().iter().any(|client| client.tasks() > 0) {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            self.listen(left, sink)?;
        }
        for number in std::mem::take(&mut self.long_batches).into_iter().flatten() {
            self.engine.take_from_nodes(number)?;
        }
        let mut report = self.report.clone();
        report.interrupted = interrupted;
        report.pre_analysis_s = self.pre_analysis.as_secs_f64();
        report.matching_s = self.matching.as_secs_f64();
        if let (Some(first), Some(last)) = (self.first_batch, self.last_answers) {
            report.scenarios_s = last.saturating_duration_since(first).as_secs_f64();
        }
        for (client, worker) in report.workers.iter_mut().enumerate() {
            let (now, before) = (self.engine.crew.traffic(client), self.traffic_before[client]);
            worker.message_bytes =
                now.to_worker + now.from_worker - before.to_worker - before.from_worker;
            worker.restarts = self.engine.crew.restarts(client) - self.restarts_before[client];
        }
        report.nodes = self.nodes_report();
        let to_workers = report.workers.iter().map(|worker| worker.geometry_bytes_copied);
        let to_nodes = report.nodes.iter().map(|node| node.geometry_bytes_copied);
        report.bytes_sent = to_workers.chain(to_nodes).sum();
        let by_workers = report.workers.iter().map(|worker| worker.bytes_from_workers);
        let by_nodes = report.nodes.iter().map(|node| node.bytes_from_nodes);
        report.transfer.bytes_from_workers = by_workers.chain(by_nodes).sum();
        report.relative_data_transfer = report.bytes_sent as f64 / self.tree_bytes as f64;
        Ok(report)
    }
}

impl<T: MasterEnd, L: Launch<T::Attach>> Session<'_, T, L> {
    /// Empty where all workers are on one machine.
    fn nodes_report(&mut self) -> Vec<NodeReport> {
        let workers = (0..self.engine.crew.len()).map(|client| self.assignment.nodes.of(client));
        let Some(others) = self.engine.crew.transport.other_nodes() else { return Vec::new() };
        let mut nodes = self.report.nodes.clone();
        workers.for_each(|node| nodes[node].workers += 1);
        for (number, node) in nodes.iter_mut().enumerate() {
            let Traffic { to_worker, from_worker } = others.traffic_of_node(number);
            let relative = node.geometry_bytes_copied as f64 / self.tree_bytes as f64;
            node.host = others.host(number);
            node.relative_data_transfer = relative;
            (node.link_bytes_sent, node.link_bytes_received) = (to_worker, from_worker);
        }
        nodes
    }
}

/// As earlier runs have left them, where there is anything to choose from.
fn sources<T: MasterEnd, L: Launch<T::Attach>>(
    engine: &Engine<T, L>,
    nodes: &Nodes,
    published: Published,
    bytes: &SubtreeBytes,
) -> Option<Sources> {
    let (crew, from) = (&engine.crew, engine.options.subtrees_from);
    if published == Published::Everywhere || from == SubtreesFrom::Master {
        return None;
    }
    let mut sources = Sources::new(nodes, bytes.clone(), from);
    match published {
        // Their leaders were told at the beginning, and answer when they can.
        Published::InThisNode => nodes.others().for_each(|node| sources.opens_early(node)),
        _ => {
            let serving = (0..crew.len()).filter(|&client| crew.name(client).is_some());
            serving.for_each(|client| sources.opens(nodes.of(client)));
        }
    }
    Some(sources)
}

/// What a worker's messages said.
#[derive(Default)]
struct Heard {
    is_ready: bool,
    /// Tasks that there are answers to.
    answered: Vec<u64>,
    name: Option<PeerName>,
    /// Subtrees by tree and root.
    not_fetched: Vec<(usize, u32)>,
    bad: Option<BadReply>,
}

impl Heard {
    fn take(&mut self, said: Result<Said, BadReply>) {
        match said {
            Ok(Said::Ready) => self.is_ready = true,
            Ok(Said::Tree) => {}
            Ok(Said::Answers { task }) => self.answered.push(task),
            Ok(Said::Serves(name)) => self.name = Some(name),
            Ok(Said::NotFetched { tree, root }) => self.not_fetched.push((tree, root)),
            Err(bad) => self.bad = self.bad.take().or(Some(bad)),
        }
    }
}
