//! Who is given nothing for now, by [`Pace`]: filed as nobody who takes scenarios.
//!
//! Who is held waits for an answer of others: as long as nobody has anything to answer, nobody is held.
//! A look at a client costs little, but there can be thousands. So a client is looked at when something
//! happens to it and when it is about to be given a scenario, and again, as long as it is held, when one of
//! its node ends a task, when a client dies, and when all together have become slower.

use std::collections::BTreeSet;
use std::time::Duration;

use super::Assignment;
use crate::scheduler::pace::{Pace, Queue};

#[derive(Debug)]
pub(super) struct Held {
    pace: Pace,
    /// Scenarios without an answer that were sent or buffered: of each node, and of all.
    unanswered: Vec<usize>,
    all_unanswered: usize,
    /// Clients of each node.
    mates: Vec<Vec<usize>>,
    /// Unclaimed clients that are held.
    clients: BTreeSet<usize>,
    /// Of those the ones with scenarios in their buffers.
    with_scenarios: BTreeSet<usize>,
}

/// Of a client, before something happens to it.
pub(super) struct Seen {
    unanswered: usize,
    buffered: usize,
    tasks: usize,
    awaits_trees: bool,
}

impl Held {
    pub(super) fn first_with_scenarios(&self) -> Option<usize> {
        self.with_scenarios.first().copied()
    }
}

impl Assignment {
    /// From the beginning on, clients are held of nodes that have to be sent geometry over a link.
    pub fn holding_back(mut self, has_link: impl Fn(usize) -> bool) -> Self {
        let nodes = self.nodes.count();
        if !(0..nodes).any(&has_link) {
            return self;
        }
        let clients = || self.clients.iter().enumerate();
        let of = clients().map(|(number, client)| (self.nodes.of(number), client.tasks()));
        let mut mates = vec![Vec::new(); nodes];
        clients().for_each(|(number, _)| mates[self.nodes.of(number)].push(number));
        let held = Held {
            pace: Pace::new(of, (0..nodes).map(has_link)),
            unanswered: vec![0; nodes],
            all_unanswered: 0,
            mates,
            clients: BTreeSet::new(),
            with_scenarios: BTreeSet::new(),
        };
        self.held = Some(held);
        self
    }

    /// All that follows happens so long after the run's beginning.
    pub fn now_is(&mut self, now: Duration) {
        if let Some(held) = &mut self.held {
            held.pace.now_is(now.as_nanos() as u64);
        }
    }

    /// Whether the client is held, which is kept.
    pub(super) fn is_held(&mut self, client: usize) -> bool {
        let left = self.untouched() + self.returned.len() + self.deferred.len();
        let Some(held) = &mut self.held else { return false };
        let (state, node) = (&self.clients[client], self.nodes.of(client));
        let own = state.unanswered();
        let of_others = left + held.all_unanswered - own;
        let queue = Queue { own, of_node: held.unanswered[node], of_others };
        let waits = !state.is_claimed() && held.all_unanswered > 0;
        let is_held = waits && held.pace.holds(client, queue);
        keep(&mut held.clients, client, is_held);
        keep(&mut held.with_scenarios, client, is_held && state.buffered() > 0);
        is_held
    }

    /// Of a client that is filed as one that takes scenarios.
    pub(super) fn still_takes(&mut self, client: usize) -> bool {
        if self.held.is_some() {
            self.file(client);
        }
        self.unclaimed.has(client)
    }

    /// Absent if nobody is held.
    pub(super) fn seen(&self, client: usize) -> Option<Seen> {
        self.held.as_ref()?;
        let state = &self.clients[client];
        Some(Seen {
            unanswered: state.unanswered(),
            buffered: state.buffered(),
            tasks: state.tasks(),
            awaits_trees: state.awaits_trees(),
        })
    }

    /// Of what has happened to the client since it was seen, which is filed after that.
    pub(super) fn take_note(&mut self, client: usize, before: Option<Seen>) {
        let (Some(before), Some(now)) = (before, self.seen(client)) else { return };
        let Some(held) = &mut self.held else { return };
        let pace = &mut held.pace;
        for sum in [&mut held.unanswered[self.nodes.of(client)], &mut held.all_unanswered] {
            *sum = *sum + now.unanswered - before.unanswered;
        }
        match (before.awaits_trees, now.awaits_trees) {
            (false, true) => pace.told_of_trees(client),
            (true, false) => pace.took_trees(client),
            _ => {}
        }
        if !self.clients[client].is_alive() {
            pace.died(client, self.nodes.lost_with(client).is_some());
        } else if now.tasks > before.tasks {
            pace.sent(client, before.buffered);
        } else if now.tasks < before.tasks {
            pace.answered(client);
            match held.all_unanswered == 0 || pace.has_slowed() {
                true => self.file_held(),
                false => self.file_mates(client),
            }
        } else if now.buffered > before.buffered && pace.given(client) {
            self.file_mates(client);
        }
    }

    /// Whoever is held may take scenarios again.
    pub(super) fn file_held(&mut self) {
        let held = self.held.iter().flat_map(|held| &held.clients);
        let held: Vec<_> = held.copied().collect();
        held.into_iter().for_each(|client| self.file(client));
    }

    /// So may clients of the same node, or none of them any more.
    fn file_mates(&mut self, client: usize) {
        let node = self.nodes.of(client);
        let mates = self.held.as_mut().map(|held| std::mem::take(&mut held.mates[node]));
        for &mate in mates.iter().flatten() {
            self.file(mate);
        }
        if let (Some(held), Some(mates)) = (&mut self.held, mates) {
            held.mates[node] = mates;
        }
    }
}

fn keep(set: &mut BTreeSet<usize>, client: usize, is_in: bool) {
    if is_in {
        set.insert(client);
    } else {
        set.remove(&client);
    }
}
