//! The simulated workers: one thing after the other, as it comes.

use std::collections::VecDeque;

use super::super::events::Time;
use super::super::machine::Copies;
use super::master::{Bundle, Heard, SMALL_MESSAGE, reply_bytes};
use super::{Event, Simulation};

/// What the master sends.
pub(super) enum Message {
    Tree {
        bytes: f64,
    },
    Subtrees(Bundle),
    Fetch(Fetch),
    Task {
        number: u64,
        scenarios: Vec<u32>,
        bytes: f64,
        /// Bundles that were sent to the worker's node before, and have to be in their place.
        after: u64,
    },
}

/// Subtrees that a worker gets from a node (of the scheduler's, see [`Sources`]).
///
/// [`Sources`]: crate::scheduler::sources::Sources
pub(super) struct Fetch {
    pub from: usize,
    pub bundle: Bundle,
}

impl Message {
    pub(super) fn bytes(&self) -> f64 {
        match self {
            Self::Tree { bytes } | Self::Task { bytes, .. } => *bytes,
            Self::Subtrees(bundle) => bundle.bytes,
            Self::Fetch(fetch) => SMALL_MESSAGE * fetch.bundle.count as f64,
        }
    }

    /// Messages that it stands for.
    pub(super) fn count(&self) -> Time {
        match self {
            Self::Tree { .. } | Self::Task { .. } => 1,
            Self::Subtrees(bundle) | Self::Fetch(Fetch { bundle, .. }) => bundle.count,
        }
    }
}

pub(super) struct Worker {
    pub node: usize,
    pub inbox: VecDeque<Message>,
    doing: Option<Message>,
    is_waking: bool,
    /// It waits for what another worker is to give.
    pub is_fetching: bool,
    /// It has answered a task.
    has_answered: bool,
    /// What of the geometry is in its memory.
    held_bytes: f64,
}

impl Worker {
    pub(super) fn on(node: usize) -> Self {
        Self {
            node,
            inbox: VecDeque::new(),
            doing: None,
            is_waking: false,
            is_fetching: false,
            has_answered: false,
            held_bytes: 0.0,
        }
    }
}

impl Simulation<'_> {
    /// In whose memory the worker is.
    pub(super) fn home(&self, worker: usize) -> usize {
        let Worker { node, has_answered, .. } = self.workers[worker];
        if self.cluster.memory.begin_on_master && !has_answered {
            self.cluster.master_node()
        } else {
            node
        }
    }

    pub(super) fn worker_gets(&mut self, worker: usize, message: Message) {
        self.memory.give_back(self.cluster.master_node(), message.bytes());
        self.memory.take(self.home(worker), message.bytes());
        let state = &mut self.workers[worker];
        let is_occupied = state.doing.is_some() || state.is_waking || state.is_fetching;
        let sleeps = !is_occupied && state.inbox.is_empty();
        state.inbox.push_back(message);
        if sleeps {
            state.is_waking = true;
            let at = self.events.now() + self.cluster.messages.wake_up;
            self.events.put(at, Event::WorkerAwake(worker));
        }
    }

    pub(super) fn worker_awakes(&mut self, worker: usize) {
        self.workers[worker].is_waking = false;
        self.work_on(worker);
    }

    /// Begins what came next, if the geometry for it is there.
    pub(super) fn work_on(&mut self, worker: usize) {
        let placed = self.nodes[self.workers[worker].node].placed;
        let state = &mut self.workers[worker];
        let is_ready = match state.inbox.front() {
            None => false,
            // What is private comes before the task, and is in its place by then.
            Some(Message::Task { after, .. }) => {
                self.cluster.copies == Copies::Process || *after <= placed
            }
            Some(_) => true,
        };
        let is_occupied = state.doing.is_some() || state.is_waking || state.is_fetching;
        if is_occupied || !is_ready {
            return;
        }
        let message = state.inbox.pop_front().expect("there is one");
        let work = self.work_of(worker, &message);
        self.workers[worker].doing = Some(message);
        self.begin(worker, work);
    }

    /// Time on a core of speed 1.
    fn work_of(&mut self, worker: usize, message: &Message) -> Time {
        let messages = &self.cluster.messages;
        let receiving = messages.of_receiving(message.count(), message.bytes());
        let speed = self.cluster.nodes[self.workers[worker].node].speed;
        let own = |work: Time| (work as f64 / speed) as Time;
        match message {
            Message::Tree { .. } => receiving + messages.of_sending(1, SMALL_MESSAGE),
            Message::Subtrees(bundle) => {
                let work = receiving + bundle.place;
                self.tally.placing += own(work);
                work
            }
            Message::Fetch(fetch) => receiving + fetch.bundle.count * messages.send,
            Message::Task { scenarios, .. } => {
                let in_place = self.cluster.is_all_in_place();
                let costs = scenarios.iter().map(|&scenario| self.load.scenario(scenario));
                let costs = costs.map(|cost| if in_place { cost.serial } else { cost.below });
                let computing: Time = costs.sum();
                self.tally.computing += own(computing);
                receiving + computing + messages.of_sending(1, reply_bytes(scenarios.len()))
            }
        }
    }

    pub(super) fn work_done(&mut self, worker: usize) {
        let message = self.workers[worker].doing.take().expect("it did something");
        let home = self.home(worker);
        self.memory.give_back(home, message.bytes());
        match message {
            Message::Tree { .. } => {
                self.reply(worker, SMALL_MESSAGE, Heard::TreeTaken { client: worker });
            }
            Message::Subtrees(bundle) => {
                self.memory.take(home, bundle.memory_bytes);
                self.workers[worker].held_bytes += bundle.memory_bytes;
                self.placed(self.workers[worker].node);
            }
            Message::Fetch(fetch) => return self.ask_peer(worker, fetch),
            Message::Task { number: task, scenarios, .. } => {
                self.moves_away(worker);
                let bytes = reply_bytes(scenarios.len());
                self.reply(worker, bytes, Heard::Answers { client: worker, task, scenarios });
            }
        }
        self.work_on(worker);
    }

    /// Whoever waits for geometry looks again.
    fn placed(&mut self, node: usize) {
        self.nodes[node].placed += 1;
        if self.cluster.copies == Copies::Node {
            self.nodes[node].workers.clone().for_each(|mate| self.work_on(mate));
        }
    }

    /// After its first task it is where it is to stay.
    fn moves_away(&mut self, worker: usize) {
        if self.workers[worker].has_answered {
            return;
        }
        let Worker { held_bytes, inbox, .. } = &self.workers[worker];
        let waiting = inbox.iter().map(Message::bytes).sum::<f64>();
        let bytes = held_bytes + waiting + self.cluster.memory.process_bytes;
        self.memory.give_back(self.home(worker), bytes);
        self.workers[worker].has_answered = true;
        self.memory.take(self.home(worker), bytes);
    }

    fn reply(&mut self, worker: usize, bytes: f64, heard: Heard) {
        let (from, to) = (self.workers[worker].node, self.cluster.master_node());
        let (_, at) = self.transfer(from, to, bytes);
        self.events.put(at, Event::ToMaster(heard));
    }
}
