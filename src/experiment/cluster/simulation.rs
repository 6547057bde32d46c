//! A run of the scheduler by discrete events: what decides is [`Assignment`] itself, as in a real run;
//! clock, processors, links and workers are simulated.
//!
//! The master does what the client manager's loop does, in its order: it gives scenarios away while
//! somebody takes them, sends every buffer that is full, then takes what has come. Each step takes
//! its time on a core. Workers do what they are sent in the order in which it comes.

mod master;
mod peer;
mod worker;

use std::collections::BTreeMap;
use std::ops::Range;

use super::events::{Events, Time, seconds};
use super::load::Load;
use super::machine::{Cluster, Copies, Node};
use super::memory::Memory;
use super::outcome::{Outcome, Tally, Utilisation};
use super::processors::{Forecast, Processors};
use crate::scene::{MatchRule, SubtreesFrom};
use crate::scheduler::assignment::{Assignment, BufferLimits};
use crate::scheduler::local_client::LocalClient;
use crate::scheduler::matchmaker::Matchmaker;
use crate::scheduler::node::Nodes;
use crate::scheduler::result_order::ResultOrder;
use crate::scheduler::sources::Sources;
use master::{Bundle, Heard, Master};
use worker::{Fetch, Message, Worker};

/// How scenarios are given away.
#[derive(Clone, Copy, Debug)]
pub struct Policy {
    pub rule: MatchRule,
    /// That a client may have before it is claimed.
    pub most_tasks: usize,
    pub from: SubtreesFrom,
    /// Of the random matchmaker.
    pub seed: u64,
    pub buffer: BufferLimits,
    /// Nodes other than the master's are held back (see [`crate::scheduler::pace`]).
    pub holds_back: bool,
}

/// Simulates the first so many scenarios of the load, at least one. `progress` is told how many have
/// been answered since it was last told.
pub fn simulate(
    load: &Load,
    cluster: &Cluster,
    policy: &Policy,
    scenarios: u32,
    progress: &dyn Fn(usize),
) -> Outcome {
    let mut simulation = Simulation::new(load, cluster, policy, scenarios, progress);
    simulation.run();
    simulation.outcome()
}

enum Event {
    /// Somebody may be done on the cores of a node.
    Cores {
        node: usize,
        forecast: Forecast,
    },
    ToWorker {
        worker: usize,
        message: Message,
    },
    ToMaster(Heard),
    WorkerAwake(usize),
    MasterAwake,
    /// What the master has sent is taken.
    Unblocked,
    /// A worker is asked for what another fetches.
    ToPeer {
        of: usize,
        fetch: Fetch,
    },
    Fetched {
        worker: usize,
        bundle: Bundle,
    },
}

struct Simulation<'a> {
    load: &'a Load,
    cluster: &'a Cluster,
    scenarios: u32,
    progress: &'a dyn Fn(usize),
    events: Events<Event>,
    assignment: Assignment,
    results: ResultOrder<()>,
    /// Where workers fetch from each other.
    sources: Option<Sources>,
    /// What workers are giving to others, by the process that does so.
    serving: BTreeMap<usize, (usize, Fetch)>,
    next_server: usize,
    /// Of all computers.
    nodes: Vec<NodeState>,
    workers: Vec<Worker>,
    master: Master,
    memory: Memory,
    tally: Tally,
}

struct NodeState {
    processors: Processors,
    /// When each direction of its link is free: out, and in.
    free: [Time; 2],
    /// Bundles of subtrees that were sent to it, and that are in their place.
    sent: u64,
    placed: u64,
    /// Of it, who follow each other.
    workers: Range<usize>,
}

impl<'a> Simulation<'a> {
    fn new(
        load: &'a Load,
        cluster: &'a Cluster,
        policy: &Policy,
        scenarios: u32,
        progress: &'a dyn Fn(usize),
    ) -> Self {
        let of = cluster.worker_nodes();
        let computers = cluster.computers();
        let client = |_: &usize| LocalClient::with_most_tasks(policy.most_tasks);
        let mut clients: Vec<_> = of.iter().map(client).collect();
        clients.iter_mut().for_each(|client| client.ready().expect("it is a new one"));
        let nodes = match cluster.copies {
            Copies::Process => Nodes::private(of.len()),
            Copies::Node => Nodes::shared(of.clone()),
        };
        let q = policy.buffer.scenarios as usize;
        let matchmaker = Matchmaker::new(policy.rule, q, policy.seed);
        let bytes =
            if cluster.is_all_in_place() { Default::default() } else { load.subtree_bytes() };
        let sources = (policy.from != SubtreesFrom::Master).then(|| {
            let mut sources = Sources::new(&nodes, load.subtree_bytes(), policy.from);
            let fetched_from = |&node: &usize| match cluster.copies {
                Copies::Process => true,
                Copies::Node => !cluster.is_in_place(node),
            };
            (0..nodes.count()).filter(fetched_from).for_each(|node| sources.opens(node));
            sources
        });
        let has_link = |node: usize| {
            let computer = match cluster.copies {
                Copies::Process => of[node],
                Copies::Node => node,
            };
            policy.holds_back && computer != cluster.master_node()
        };
        let assignment =
            Assignment::new(clients, nodes, scenarios, policy.buffer, matchmaker, bytes)
                .holding_back(has_link);
        let state = |(number, node): (usize, &Node)| NodeState {
            processors: Processors::new(node.cores, node.speed),
            free: [0; 2],
            sent: 0,
            placed: 0,
            workers: of.partition_point(|&of| of < number)..of.partition_point(|&of| of <= number),
        };
        Self {
            load,
            cluster,
            scenarios,
            progress,
            events: Events::default(),
            assignment,
            results: ResultOrder::default(),
            sources,
            serving: BTreeMap::new(),
            next_server: of.len() + 1,
            nodes: computers.iter().enumerate().map(state).collect(),
            workers: of.iter().map(|&node| Worker::on(node)).collect(),
            master: Master::default(),
            memory: Memory::new(computers.len()),
            tally: Tally::default(),
        }
    }

    fn run(&mut self) {
        self.settle_in();
        self.introduce();
        self.go_on();
        while self.results.delivered() < self.scenarios {
            let event = self.events.take().expect("somebody is at work until all is answered");
            self.happens(event);
        }
    }

    fn happens(&mut self, event: Event) {
        match event {
            Event::Cores { node, forecast } => {
                let now = self.events.now();
                let (done, next) = self.nodes[node].processors.done(now, forecast);
                if let Some(forecast) = next {
                    self.events.put(forecast.at, Event::Cores { node, forecast });
                }
                done.into_iter().for_each(|process| self.done(process));
            }
            Event::ToWorker { worker, message } => self.worker_gets(worker, message),
            Event::ToMaster(heard) => self.master_hears(heard),
            Event::WorkerAwake(worker) => self.worker_awakes(worker),
            Event::MasterAwake => self.go_on(),
            Event::Unblocked => self.unblocked(),
            Event::ToPeer { of, fetch } => self.serve(of, fetch),
            Event::Fetched { worker, bundle } => self.fetched(worker, bundle),
        }
    }

    /// A process is done with what it did.
    fn done(&mut self, process: usize) {
        if process < self.workers.len() {
            self.work_done(process);
        } else if process == self.workers.len() {
            self.step_done();
        } else {
            self.served(process);
        }
    }

    /// Processes, and the trees in the master.
    fn settle_in(&mut self) {
        let (master, process) = (self.cluster.master_node(), self.cluster.memory.process_bytes);
        let trees = self.load.subtrees.iter().flatten();
        let trees = trees.map(|subtree| subtree.memory_bytes + subtree.kept_bytes);
        self.memory.take(master, process + trees.sum::<f64>());
        for worker in 0..self.workers.len() {
            self.memory.take(self.home(worker), process);
        }
    }

    /// A process works for so long on a core of speed 1. The master comes after all workers.
    fn begin(&mut self, process: usize, work: Time) {
        let node = match self.workers.get(process) {
            Some(worker) => worker.node,
            None => self.cluster.master_node(),
        };
        self.begin_on(node, process, work);
    }

    fn begin_on(&mut self, node: usize, process: usize, work: Time) {
        let now = self.events.now();
        let forecast = self.nodes[node].processors.begin(now, process, work);
        self.events.put(forecast.at, Event::Cores { node, forecast });
    }

    /// Sends bytes from one node to another as soon as both links have room: when these are free
    /// again, and when the bytes are there. Within a node, at once.
    fn transfer(&mut self, from: usize, to: usize, bytes: f64) -> (Time, Time) {
        let now = self.events.now();
        if from == to {
            return (now, now);
        }
        let link = &self.cluster.link;
        let occupied = link.occupied(bytes);
        let end = now.max(self.nodes[from].free[0]).max(self.nodes[to].free[1]) + occupied;
        self.nodes[from].free[0] = end;
        self.nodes[to].free[1] = end;
        if from == self.cluster.master_node() {
            self.tally.link += occupied;
        }
        (end, end + link.latency)
    }

    fn outcome(&self) -> Outcome {
        let Self { load, cluster, tally, .. } = self;
        let first = tally.first_task.expect("there was a scenario");
        let time_s = seconds(tally.last_answer - first);
        let serial_s = seconds(load.serial(self.scenarios));
        let speed = cluster.nodes[0].speed;
        let part = |time: Time| time as f64 / tally.last_answer as f64;
        let of_workers = |time: Time| part(time) / self.workers.len() as f64;
        // Steps are counted as they are on a core of speed 1.
        let master = |time: Time| part(time) / speed;
        let busy = tally.analysis + tally.matching + tally.sending + tally.receiving;
        Outcome {
            time_s,
            speedup: serial_s * cluster.weighted_time() / time_s,
            over_first: serial_s / speed / time_s,
            bound: cluster.bound(),
            speedup_bound: cluster.bound() * cluster.weighted_time() * speed,
            bytes_sent: tally.bytes_sent,
            bytes_fetched: tally.bytes_fetched,
            relative_data_transfer: tally.bytes_sent / load.tree_bytes,
            packing_s: seconds(load.packing) / speed,
            tasks: tally.tasks,
            utilisation: Utilisation {
                master: master(busy),
                master_analysis: master(tally.analysis),
                master_matching: master(tally.matching),
                master_sending: master(tally.sending),
                master_blocked: part(tally.blocked),
                link: part(tally.link),
                computing: of_workers(tally.computing),
                placing: of_workers(tally.placing),
            },
            memory: self.memory.most(&cluster.computers()),
        }
    }
}

#[cfg(test)]
mod tests;
