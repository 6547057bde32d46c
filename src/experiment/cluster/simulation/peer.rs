//! Subtrees that workers give each other (section 8 of the paper): who gives what to whom, the
//! scheduler's [`Sources`](crate::scheduler::sources::Sources) say.

use super::super::events::nanoseconds;
use super::super::machine::Copies;
use super::master::Bundle;
use super::worker::{Fetch, Message};
use super::{Event, Simulation};

impl Simulation<'_> {
    /// The computer of a node of the scheduler's.
    fn computer(&self, node: usize) -> usize {
        match self.cluster.copies {
            Copies::Process => self.workers[node].node,
            Copies::Node => node,
        }
    }

    /// The worker waits until it has what it asks for.
    pub(super) fn ask_peer(&mut self, worker: usize, fetch: Fetch) {
        self.workers[worker].is_fetching = true;
        let is_near = self.computer(fetch.from) == self.workers[worker].node;
        let latency = if is_near { 0 } else { self.cluster.link.latency };
        self.events.put(self.events.now() + latency, Event::ToPeer { of: worker, fetch });
    }

    /// A thread beside whatever the peer does: it copies, but makes nothing.
    pub(super) fn serve(&mut self, of: usize, fetch: Fetch) {
        let messages = &self.cluster.messages;
        let copying = nanoseconds(fetch.bundle.bytes / messages.copy_bytes_per_s);
        let work = fetch.bundle.count * (messages.receive + messages.send) + copying;
        let (node, process) = (self.computer(fetch.from), self.next_server);
        self.next_server += 1;
        self.serving.insert(process, (of, fetch));
        self.begin_on(node, process, work);
    }

    pub(super) fn served(&mut self, process: usize) {
        let (worker, fetch) = self.serving.remove(&process).expect("it was begun");
        let (from, to) = (self.computer(fetch.from), self.workers[worker].node);
        let (_, at) = self.transfer(from, to, fetch.bundle.bytes);
        self.events.put(at, Event::Fetched { worker, bundle: fetch.bundle });
    }

    pub(super) fn fetched(&mut self, worker: usize, bundle: Bundle) {
        self.memory.take(self.home(worker), bundle.bytes);
        let state = &mut self.workers[worker];
        state.is_fetching = false;
        state.inbox.push_front(Message::Subtrees(bundle));
        self.work_on(worker);
    }
}
