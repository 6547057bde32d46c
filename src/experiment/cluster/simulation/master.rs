//! The simulated master: the client manager's loop, a step at a time.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use super::super::events::Time;
use super::super::load::SubtreeCost;
use super::super::machine::Copies;
use super::worker::{Fetch, Message};
use super::{Event, Simulation};
use crate::scheduler::local_client::{Analysis, LocalClient, NewTask};
use crate::scheduler::sources::Source;
use crate::wire::Job;

/// Bytes of a message without contents, to a worker or from it.
pub(super) const SMALL_MESSAGE: f64 = 64.0;
/// Subtrees of a task travel in so many bundles at least, if they are large: the first is put to its
/// place while the next is on its way.
const BUNDLES: f64 = 32.0;
const SMALLEST_BUNDLE: f64 = 65536.0;

/// What a worker says.
pub(super) enum Heard {
    TreeTaken { client: usize },
    Answers { client: usize, task: u64, scenarios: Vec<u32> },
}

#[derive(Default)]
pub(super) struct Master {
    inbox: VecDeque<Heard>,
    outbox: VecDeque<Outgoing>,
    step: Step,
    /// It takes what has come, rather than giving scenarios away.
    is_listening: bool,
    has_heard: bool,
    blocked_since: Time,
}

struct Outgoing {
    client: usize,
    message: Message,
    /// Of making it.
    make: Time,
}

#[derive(Default)]
enum Step {
    #[default]
    None,
    /// Sleeps until a message comes.
    Idle,
    Waking,
    Assigning,
    Sending(Outgoing),
    Blocked,
    Receiving(Heard),
}

impl Simulation<'_> {
    /// Every worker is told of both trees. Of workers with memory in common, one is told where
    /// everything lies.
    pub(super) fn introduce(&mut self) {
        let mut told = vec![false; self.nodes.len()];
        for client in 0..self.workers.len() {
            let node = self.workers[client].node;
            let is_short =
                self.cluster.is_in_place(node) || self.cluster.copies == Copies::Node && told[node];
            told[node] = true;
            for outline in self.load.outline_bytes {
                let bytes = if is_short { SMALL_MESSAGE } else { outline };
                self.assignment.change(client, LocalClient::told_of_tree);
                let message = Message::Tree { bytes };
                self.master.outbox.push_back(Outgoing { client, message, make: 0 });
            }
        }
    }

    /// The master takes its next step, or sleeps.
    pub(super) fn go_on(&mut self) {
        loop {
            if let Some(outgoing) = self.master.outbox.pop_front() {
                return self.send(outgoing);
            }
            if !self.master.is_listening {
                if self.assign_next() {
                    return;
                }
                self.take_tasks();
                self.master.is_listening = true;
            } else if let Some(heard) = self.master.inbox.pop_front() {
                self.master.has_heard = true;
                return self.receive(heard);
            } else if std::mem::take(&mut self.master.has_heard) {
                while self.results.pop().is_some() {}
                self.assignment.delivered(self.results.delivered());
                self.master.is_listening = false;
            } else {
                self.master.step = Step::Idle;
                return;
            }
        }
    }

    /// Begins to give the next scenario away, if somebody takes it.
    fn assign_next(&mut self) -> bool {
        let Some(scenario) = self.assignment.next_scenario() else { return false };
        if !self.assignment.can_assign() {
            return false;
        }
        let cost = self.load.scenario(scenario);
        let wants_scores = self.assignment.wants_scores();
        let is_analysed = wants_scores || !self.cluster.is_all_in_place();
        let mut analysis = Analysis::default();
        if is_analysed {
            analysis.indicators = cost.indicators.clone();
        }
        // Nobody sees the choice before the step is over.
        let choice = self.assignment.assign(scenario, analysis).expect("somebody takes it");
        let analysing = if is_analysed { cost.analysis } else { 0 };
        let scores = if wants_scores { choice.scored } else { 0 };
        let matching = scores as f64 * f64::from(cost.roots) * self.cluster.messages.score_root;
        self.tally.analysis += analysing;
        self.tally.matching += matching as Time;
        self.take_step(Step::Assigning, analysing + matching as Time);
        true
    }

    fn take_step(&mut self, step: Step, work: Time) {
        self.master.step = step;
        self.begin(self.workers.len(), work);
    }

    /// The step is over.
    pub(super) fn step_done(&mut self) {
        match std::mem::take(&mut self.master.step) {
            Step::Assigning => self.take_tasks(),
            Step::Sending(outgoing) => {
                if self.depart(outgoing) {
                    return;
                }
            }
            Step::Receiving(heard) => self.take_note(heard),
            Step::None | Step::Idle | Step::Waking | Step::Blocked => {
                unreachable!("nothing that takes the processor")
            }
        }
        self.go_on();
    }

    fn take_tasks(&mut self) {
        self.tell_time();
        while let Some((client, task)) = self.assignment.take_task() {
            self.tally.first_task.get_or_insert(self.events.now());
            self.tally.tasks += 1;
            self.add_subtrees(client, &task);
            let pairs =
                task.batch.iter().map(|b| self.load.scenario(b.scenario).root_pairs as usize);
            let pairs = if self.cluster.is_all_in_place() { 0 } else { pairs.sum() };
            let scenarios: Vec<_> = task.batch.iter().map(|b| b.scenario).collect();
            let bytes = Job::batch_bytes(scenarios.len(), pairs) as f64;
            let after = self.nodes[self.workers[client].node].sent;
            let message = Message::Task { number: task.number, scenarios, bytes, after };
            self.master.outbox.push_back(Outgoing { client, message, make: 0 });
        }
    }

    /// The subtrees that go ahead of a task, in bundles: what other nodes give, and what the master
    /// does.
    fn add_subtrees(&mut self, client: usize, task: &NewTask) {
        if self.cluster.is_in_place(self.workers[client].node) {
            return;
        }
        let load = self.load;
        let subtrees = [0, 1].into_iter().flat_map(|tree: usize| {
            task.subtrees[tree].iter().map(move |&root| &load.subtrees[tree][root as usize])
        });
        let (mut own, mut of_others) = (Vec::new(), BTreeMap::<usize, Vec<_>>::new());
        let node = self.assignment.nodes.of(client);
        let mut sources = match &mut self.sources {
            Some(sources) => sources.send(node, task),
            None => Vec::new(),
        }
        .into_iter();
        for subtree in subtrees {
            match sources.next().unwrap_or(Source::Master) {
                Source::Master => own.push(subtree),
                Source::Node(from) => of_others.entry(from).or_default().push(subtree),
            }
        }
        for (from, subtrees) in of_others {
            for (bundle, _) in bundles(&subtrees) {
                self.tally.bytes_fetched += bundle.bytes;
                self.add_bundle(client, Message::Fetch(Fetch { from, bundle }), 0);
            }
        }
        for (bundle, make) in bundles(&own) {
            self.tally.bytes_sent += bundle.bytes;
            self.add_bundle(client, Message::Subtrees(bundle), make);
        }
    }

    fn add_bundle(&mut self, client: usize, message: Message, make: Time) {
        self.nodes[self.workers[client].node].sent += 1;
        self.master.outbox.push_back(Outgoing { client, message, make });
    }

    fn send(&mut self, outgoing: Outgoing) {
        let messages = &self.cluster.messages;
        let (count, bytes) = (outgoing.message.count(), outgoing.message.bytes());
        let work = outgoing.make + messages.of_sending(count, bytes);
        self.tally.sending += work;
        self.take_step(Step::Sending(outgoing), work);
    }

    /// The message is on its way. Returns whether the master waits until it is taken.
    fn depart(&mut self, Outgoing { client, message, .. }: Outgoing) -> bool {
        let (from, to) = (self.cluster.master_node(), self.workers[client].node);
        self.memory.take(from, message.bytes());
        let (end, at) = self.transfer(from, to, message.bytes());
        self.events.put(at, Event::ToWorker { worker: client, message });
        let waits = self.cluster.link.is_blocking() && from != to;
        if waits {
            self.master.step = Step::Blocked;
            self.master.blocked_since = self.events.now();
            self.events.put(end, Event::Unblocked);
        }
        waits
    }

    pub(super) fn unblocked(&mut self) {
        self.tally.blocked += self.events.now() - self.master.blocked_since;
        self.go_on();
    }

    pub(super) fn master_hears(&mut self, heard: Heard) {
        self.master.inbox.push_back(heard);
        if matches!(self.master.step, Step::Idle) {
            self.master.step = Step::Waking;
            let at = self.events.now() + self.cluster.messages.wake_up;
            self.events.put(at, Event::MasterAwake);
        }
    }

    fn receive(&mut self, heard: Heard) {
        let messages = &self.cluster.messages;
        let results = match &heard {
            Heard::TreeTaken { .. } => 0,
            Heard::Answers { scenarios, .. } => scenarios.len(),
        };
        let work =
            messages.of_receiving(1, reply_bytes(results)) + results as Time * messages.delivery;
        self.tally.receiving += work;
        self.take_step(Step::Receiving(heard), work);
    }

    fn tell_time(&mut self) {
        self.assignment.now_is(Duration::from_nanos(self.events.now()));
    }

    fn take_note(&mut self, heard: Heard) {
        self.tell_time();
        match heard {
            Heard::TreeTaken { client } => self.assignment.change(client, LocalClient::took_tree),
            Heard::Answers { client, task, scenarios } => {
                self.tally.last_answer = self.events.now();
                if let Some(sources) = &mut self.sources {
                    sources.answered(task);
                }
                self.assignment.change(client, |state| {
                    for &scenario in &scenarios {
                        state.answered(task, scenario).expect("it was given the scenario");
                    }
                    state.end_task(task).expect("all its scenarios are answered");
                });
                (self.progress)(scenarios.len());
                scenarios.into_iter().for_each(|scenario| self.results.insert(scenario, ()));
            }
        }
    }
}

/// Bundles of these subtrees, and what making their messages takes.
fn bundles(subtrees: &[&SubtreeCost]) -> Vec<(Bundle, Time)> {
    let bytes: f64 = subtrees.iter().map(|subtree| subtree.sent_bytes).sum();
    let full = (bytes / BUNDLES).max(SMALLEST_BUNDLE);
    let mut bundles = vec![(Bundle::default(), 0)];
    for subtree in subtrees {
        let is_full = bundles.last().is_some_and(|(bundle, _)| bundle.bytes >= full);
        if is_full {
            bundles.push((Bundle::default(), 0));
        }
        let (bundle, make) = bundles.last_mut().expect("there is one");
        bundle.count += 1;
        bundle.bytes += subtree.sent_bytes;
        bundle.memory_bytes += subtree.memory_bytes;
        bundle.place += subtree.place;
        *make += subtree.make;
    }
    bundles.retain(|(bundle, _)| bundle.count > 0);
    bundles
}

/// Bytes of a reply with so many answers.
pub(super) fn reply_bytes(answers: usize) -> f64 {
    (size_of::<crate::wire::ReplyHeader>() + answers * size_of::<crate::wire::AnswerRecord>())
        as f64
}

/// Subtrees that travel together.
#[derive(Default)]
pub(super) struct Bundle {
    pub count: Time,
    pub bytes: f64,
    pub memory_bytes: f64,
    /// Of putting them to their places.
    pub place: Time,
}
