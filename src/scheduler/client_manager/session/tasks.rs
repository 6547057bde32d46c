//! What workers are told and given: trees, the plan, scenarios.

use std::time::{Duration, Instant};

use super::super::EngineError;
use super::super::start::longest_batch;
use super::super::supply::Way;
use super::Session;
use crate::scene::{EngineOptions, StartFrom};
use crate::scheduler::launch::Launch;
use crate::scheduler::local_client::{
    Analysis, Buffered, LocalClient, NewTask, OUTSTANDING_TASKS, Unexpected,
};
use crate::scheduler::sources::Source;
use crate::transport::MasterEnd;
use crate::tree::descent::DescentError;
use crate::tree::roots::RootPair;
use crate::wire::{Fetch, Job, JobHeader, ScenarioRecord, SubtreeRequest, published_at};

impl<T: MasterEnd, L: Launch<T::Attach>> Session<'_, T, L> {
    /// Tells a worker that is ready of both trees. It gets no task before it has taken them.
    pub(super) fn introduce(&mut self, client: usize) -> Result<(), EngineError> {
        let way = self.way(client);
        if self.sources.is_some()
            && way == Way::Sent
            && self.assignment.clients()[client].is_ready()
            && self.engine.crew.tells_to_serve(client)
        {
            self.engine.crew.send(client, &[bytemuck::bytes_of(&JobHeader::serve())])?;
        }
        for (side, tree) in self.trees.into_iter().enumerate() {
            if !self.tells_of(client, tree) {
                continue;
            }
            let body = match way {
                Way::InPlace => self.supply.place(side),
                Way::Sent => self.supply.outline(side),
                Way::ByNode(node) => {
                    self.introduce_to_node(client, node, side)?;
                    Vec::new()
                }
            };
            let header = JobHeader::add_tree(tree);
            self.engine.crew.send(client, &[bytemuck::bytes_of(&header), &body])?;
            if way == Way::Sent {
                self.send_whole(client, side)?;
            }
        }
        let Some(planned) = &self.planned else { return Ok(()) };
        if !self.assignment.clients()[client].is_ready() {
            return Ok(());
        }
        let numbers: Vec<_> = planned.numbers().collect();
        for number in numbers {
            if self.tells_of(client, number) {
                self.tell(client, number, way)?;
            }
        }
        Ok(())
    }

    /// Tells a node's leader of a tree, before the first of the node's workers.
    fn introduce_to_node(
        &mut self,
        client: usize,
        node: usize,
        side: usize,
    ) -> Result<(), EngineError> {
        if self.engine.tells_node_of(node, self.trees[side]) {
            let header = JobHeader::add_tree(self.trees[side]);
            let body = self.supply.outline(side);
            self.engine.send_to_node(node, &[bytemuck::bytes_of(&header), &body])?;
            self.send_whole(client, side)?;
        }
        Ok(())
    }

    /// Effects look at whole trees.
    fn send_whole(&mut self, client: usize, side: usize) -> Result<(), EngineError> {
        if self.planned.is_some() {
            let way = self.way(client);
            let source = match (&mut self.sources, way) {
                (Some(sources), Way::ByNode(node)) => sources.send_ahead(node, side, 0),
                // What a worker cannot fetch it reports as of a task, and it has none yet.
                _ => Source::Master,
            };
            self.get_subtree(client, (side, 0), source)?;
            self.assignment.nodes.of_client_mut(client).give_whole(side);
        }
        Ok(())
    }

    /// Tells a worker, and before the first of a node's workers its leader, of a part of the plan.
    fn tell(&mut self, client: usize, number: u32, way: Way) -> Result<(), EngineError> {
        let planned = self.planned.as_ref().expect("a plan that has parts");
        let is_tree = planned.number != number;
        if let Way::ByNode(node) = way
            && self.engine.tells_node_of(node, number)
        {
            for message in planned.messages(number, Way::Sent) {
                let message: Vec<_> = message.iter().map(|part| &part[..]).collect();
                if is_tree {
                    self.report.nodes[node].geometry_bytes_copied += bytes_of(&message);
                }
                self.engine.send_to_node(node, &message)?;
            }
        }
        for message in planned.messages(number, way) {
            let message: Vec<_> = message.iter().map(|part| &part[..]).collect();
            if is_tree && way == Way::Sent {
                self.report.workers[client].geometry_bytes_copied += bytes_of(&message);
            }
            self.engine.crew.send(client, &message)?;
        }
        Ok(())
    }

    fn way(&self, client: usize) -> Way {
        self.supply.way(self.assignment.nodes.of(client))
    }

    /// Whether the client is to be told of something with this number, and from now on counts as
    /// told.
    fn tells_of(&mut self, client: usize, number: u32) -> bool {
        let is_ready = self.assignment.clients()[client].is_ready();
        let tells = is_ready && self.engine.crew.tells_of(client, number);
        if tells {
            self.assignment.change(client, LocalClient::told_of_tree);
            self.engine.crew.begins(client);
        }
        tells
    }

    fn get_subtree(
        &mut self,
        client: usize,
        (side, root): (usize, u32),
        source: Source,
    ) -> Result<(), EngineError> {
        match source {
            Source::Node(from) => self.tell_to_fetch(client, (side, root), from),
            Source::Master => self.send_subtree(client, side, root),
        }
    }

    /// To its node, if it has one; otherwise no later than the master waits, as tasks follow.
    fn send_subtree(&mut self, client: usize, side: usize, root: u32) -> Result<(), EngineError> {
        let header = JobHeader::add_subtree(self.trees[side]);
        let body = self.supply.subtree(side, root);
        let (message, bytes) = ([bytemuck::bytes_of(&header), &body], body.len() as u64);
        if let Way::ByNode(node) = self.way(client) {
            self.report.nodes[node].geometry_bytes_copied += bytes;
            return self.engine.send_to_node(node, &message);
        }
        self.report.workers[client].geometry_bytes_copied += bytes;
        self.engine.crew.send_ahead(client, &message)
    }

    /// Where bytes are counted that its node has not had from the master.
    pub(super) fn bytes_from_others(&mut self, client: usize) -> &mut u64 {
        match self.way(client) {
            Way::ByNode(node) => &mut self.report.nodes[node].bytes_from_nodes,
            _ => &mut self.report.workers[client].bytes_from_workers,
        }
    }

    /// From a node that has the subtree: leaders give each other what is for all of their workers.
    fn tell_to_fetch(
        &mut self,
        client: usize,
        (side, root): (usize, u32),
        from: usize,
    ) -> Result<(), EngineError> {
        let tree = self.trees[side];
        if let Way::ByNode(node) = self.way(client) {
            let request = SubtreeRequest { tree, root }.to_bytes();
            let others = self.engine.crew.transport.other_nodes().expect("a node of another");
            return Ok(others.send_to_fetch(node, from, &request)?);
        }
        // Elsewhere the memory of a node is that of its one client.
        let peer = self.engine.crew.name(from).expect("who is open has a name");
        let patience = fetch_patience(&self.engine.options, self.supply.length(side, root));
        let header = JobHeader::fetch_subtree(tree);
        let fetch = Fetch { root, peer, patience };
        self.engine.crew.send_ahead(client, &[bytemuck::bytes_of(&header), &fetch.to_bytes()])
    }

    /// What another worker was to give.
    pub(super) fn send_instead(
        &mut self,
        client: usize,
        side: usize,
        root: u32,
    ) -> Result<(), EngineError> {
        let node = self.assignment.nodes.of(client);
        let known = match &mut self.sources {
            Some(sources) => sources.not_fetched(node, side, root),
            None => Err(Unexpected::NotFetched { tree: side, root }),
        };
        known.map_err(|unexpected| EngineError::BadReply {
            worker: self.engine.crew.id(client),
            source: unexpected.into(),
        })?;
        self.report.transfer.not_fetched += 1;
        self.send_subtree(client, side, root)
    }

    /// Fills the buffers of unclaimed clients, and sends those that are full.
    pub(super) fn give_work(&mut self) -> Result<(), EngineError> {
        self.assignment.now_is(self.begin.elapsed());
        while let Some(scenario) = self.assignment.next_scenario() {
            if !self.assignment.can_assign() {
                break;
            }
            let analysis = match self.analyse(scenario) {
                Ok(analysis) => analysis,
                Err(DescentError::Overflow { triangle, corner }) => {
                    self.assignment.stop_at(scenario);
                    self.collection.overflow(scenario, triangle, corner);
                    break;
                }
                Err(other) => unreachable!("both trees are whole and of one kind: {other}"),
            };
            let begin = Instant::now();
            self.assignment.assign(scenario, analysis).expect("somebody takes it");
            self.matching += begin.elapsed();
            self.send_tasks()?;
        }
        self.send_tasks()
    }

    /// What is known of a scenario that is descended from the top and has one client to go to
    /// changes nothing: then nothing is found out.
    fn analyse(&mut self, scenario: u32) -> Result<Analysis, DescentError> {
        let from_roots = self.supply.start_from() == StartFrom::RootPairs;
        if !from_roots && !self.assignment.wants_scores() {
            return Ok(Analysis::default());
        }
        let begin = Instant::now();
        let pose = &self.work.poses[scenario as usize];
        let analysis = self.submitter.analyse(pose, from_roots);
        self.pre_analysis += begin.elapsed();
        analysis
    }

    fn send_tasks(&mut self) -> Result<(), EngineError> {
        while let Some((client, task)) = self.assignment.take_task() {
            self.send_task(client, &task)?;
        }
        Ok(())
    }

    /// The subtrees that the worker lacks, then the scenarios.
    fn send_task(&mut self, client: usize, task: &NewTask) -> Result<(), EngineError> {
        if self.assignment.clients()[client].tasks() == 1 {
            self.engine.crew.begins(client);
        }
        self.first_batch.get_or_insert_with(Instant::now);
        let node = self.assignment.nodes.of(client);
        let sources = self.sources.as_mut().map(|sources| sources.send(node, task));
        let fixed = task.subtrees[0].iter().map(|&root| (0, root));
        let subtrees = fixed.chain(task.subtrees[1].iter().map(|&root| (1, root)));
        for (index, (side, root)) in subtrees.enumerate() {
            let source = sources.as_ref().map_or(Source::Master, |sources| sources[index]);
            self.get_subtree(client, (side, root), source)?;
        }
        self.report.workers[client].batches += 1;
        self.send_batch(client, task)
    }

    fn send_batch(&mut self, client: usize, task: &NewTask) -> Result<(), EngineError> {
        let root_pairs = task.batch.iter().map(|buffered| buffered.root_pairs.len()).sum();
        let from_roots = match self.supply.start_from() {
            StartFrom::Top => false,
            // Who sees the whole trees can do without.
            StartFrom::RootPairs => {
                self.way(client) != Way::InPlace
                    || Job::batch_bytes(task.batch.len(), root_pairs)
                        <= longest_batch(&self.engine.options)
            }
        };
        let record = |scenario: u32, root_pairs: usize| {
            let pose = self.work.poses[scenario as usize];
            ScenarioRecord::new(scenario, pose, root_pairs as u32)
        };
        let roots_of = |buffered: &'_ Buffered| -> Vec<RootPair> {
            if from_roots { buffered.root_pairs.clone() } else { Vec::new() }
        };
        let roots: Vec<_> = task.batch.iter().map(roots_of).collect();
        let records: Vec<_> =
            task.batch.iter().zip(&roots).map(|(b, r)| record(b.scenario, r.len())).collect();
        let root_pairs = roots.concat();
        let count = records.len() as u32;
        let header = JobHeader::scenarios(task.number, self.trees, count, from_roots, self.wanted);
        let batch = [
            bytemuck::bytes_of(&header),
            bytemuck::cast_slice(&records),
            bytemuck::cast_slice(&root_pairs),
        ];
        match self.way(client) {
            Way::ByNode(node) if bytes_of(&batch) > longest_batch(&self.engine.options) as u64 => {
                self.send_long_batch(client, node, &batch)
            }
            _ => self.engine.crew.send(client, &batch),
        }
    }

    /// A batch that no queue has room for, with very many pairs of roots: its node publishes it.
    fn send_long_batch(
        &mut self,
        client: usize,
        node: usize,
        batch: &[&[u8]],
    ) -> Result<(), EngineError> {
        let number = self.engine.next_number();
        let header = JobHeader::plan(number);
        self.engine.tells_node_of(node, number);
        self.engine.send_to_node(node, &[&[bytemuck::bytes_of(&header)], batch].concat())?;
        let (header, place) = (JobHeader::elsewhere(), published_at(number));
        self.engine.crew.send(client, &[bytemuck::bytes_of(&header), &place])?;
        self.long_batches[client].push_back(number);
        // No client has more tasks: it has taken those before.
        if self.long_batches[client].len() > OUTSTANDING_TASKS {
            let taken = self.long_batches[client].pop_front().expect("there are some");
            self.engine.take_from_nodes(taken)?;
        }
        Ok(())
    }
}

fn bytes_of(message: &[&[u8]]) -> u64 {
    message.iter().map(|part| part.len() as u64).sum()
}

/// For a subtree of so many bytes to come from another worker: beyond what it takes, what a machine
/// under load may take to wake that one up. Less than what ends the one that waits for it.
fn fetch_patience(options: &EngineOptions, bytes: u64) -> Duration {
    const WAKE_UP: Duration = Duration::from_millis(500);
    const SLOWEST_BYTES_PER_S: f64 = 50e6;
    let longest = WAKE_UP + Duration::from_secs_f64(bytes as f64 / SLOWEST_BYTES_PER_S);
    longest.min(options.patience / 4)
}
