//! Which scenario is with which client: the state of a run, without clock or processes.

use std::collections::{BTreeMap, BTreeSet};

use super::local_client::{Analysis, Indicators, LocalClient, NewTask, SubtreeBytes};
use super::matchmaker::{Candidate, Matchmaker};
use super::node::Nodes;

/// How far scenarios are given away beyond the first that has not been answered, in full buffers
/// for each client. Results wait in memory for all before them, so a client that is stuck must not
/// let the others run on without end.
const BUFFERS_AHEAD: u32 = 64;

/// Workers that a scenario may take with it before it is set aside.
pub const MOST_DEATHS: u32 = 3;

/// When a buffer is full (section 6.4.3 of the paper).
#[derive(Clone, Copy, Debug)]
pub struct BufferLimits {
    /// q
    pub scenarios: u32,
    /// V: bytes of the subtrees that its task brings.
    pub bytes: u64,
}

#[derive(Debug)]
pub struct Assignment {
    pub clients: Vec<LocalClient>,
    /// Where the geometry is that they were given.
    pub nodes: Nodes,
    matchmaker: Matchmaker,
    limits: BufferLimits,
    subtree_bytes: SubtreeBytes,
    /// The first scenario that nobody has been given yet.
    next: u32,
    /// Scenarios from here on are not given to anybody.
    end: u32,
    /// All scenarios below were delivered.
    delivered: u32,
    /// Only so many from there on are given to anybody.
    ahead: u32,
    /// Given once to a client that died.
    returned: BTreeSet<u32>,
    /// As `returned`, but so suspicious that all others come first.
    deferred: BTreeSet<u32>,
    /// Clients that died at this scenario.
    deaths: BTreeMap<u32, u32>,
    next_task: u64,
    /// Clients with something in their buffers.
    buffering: BTreeSet<usize>,
    /// Scenarios in all buffers together.
    buffered: usize,
    /// Clients that are alive.
    alive: usize,
}

impl Assignment {
    pub fn new(
        clients: Vec<LocalClient>,
        nodes: Nodes,
        scenarios: u32,
        limits: BufferLimits,
        matchmaker: Matchmaker,
        subtree_bytes: SubtreeBytes,
    ) -> Self {
        let buffers_ahead = BUFFERS_AHEAD.saturating_mul(clients.len() as u32);
        let alive = clients.iter().filter(|client| client.is_alive()).count();
        Self {
            clients,
            nodes,
            matchmaker,
            limits,
            subtree_bytes,
            next: 0,
            end: scenarios,
            delivered: 0,
            ahead: buffers_ahead.saturating_mul(limits.scenarios),
            returned: BTreeSet::new(),
            deferred: BTreeSet::new(),
            deaths: BTreeMap::new(),
            next_task: 0,
            buffering: BTreeSet::new(),
            buffered: 0,
            alive,
        }
    }

    /// The scenario to be assigned next: the first of all, because results are delivered in order.
    /// `None` if all are given away, or if it is too far ahead of the results.
    pub fn next_scenario(&self) -> Option<u32> {
        let limit = self.end.min(self.delivered.saturating_add(self.ahead));
        let first = self.returned.first().copied().unwrap_or(self.next);
        let candidates = [Some(first), self.deferred.first().copied()];
        candidates.into_iter().flatten().find(|&scenario| scenario < limit)
    }

    /// Gives away no scenario from `end` on any more.
    pub fn stop_at(&mut self, end: u32) {
        self.end = self.end.min(end);
    }

    /// Takes note that all scenarios below this one were delivered.
    pub fn delivered(&mut self, scenarios: u32) {
        self.delivered = scenarios;
    }

    /// Whether a scenario's geometry matters to the choice of its client: there is a choice, and
    /// the rule looks at it.
    pub fn wants_scores(&self) -> bool {
        self.matchmaker.rule().needs_scores() && self.candidates().count() > 1
    }

    pub fn is_anyone_alive(&self) -> bool {
        self.alive > 0
    }

    /// Whether somebody takes a scenario now.
    pub fn can_assign(&self) -> bool {
        self.candidates().next().is_some()
    }

    /// Buffers the scenario, which is the next, with the candidate that the matchmaker picks; with
    /// none there is nobody who takes it.
    pub fn assign(&mut self, scenario: u32, analysis: Analysis) -> Option<usize> {
        let Analysis { indicators, root_pairs } = analysis;
        let candidates = self.scored(&indicators);
        let chosen = self.matchmaker.pick(&candidates)?;
        self.clients[chosen].push(scenario, root_pairs);
        self.nodes.of_client_mut(chosen).give(&indicators, &self.subtree_bytes);
        self.buffering.insert(chosen);
        self.buffered += 1;
        if !(self.returned.remove(&scenario) || self.deferred.remove(&scenario)) {
            self.next = scenario + 1;
        }
        Some(chosen)
    }

    /// Clients of one node score alike: the choice is of the node, and in it of the emptiest buffer.
    fn scored(&self, indicators: &Indicators) -> Vec<Candidate> {
        let mut scores = vec![None; self.nodes.count()];
        let scored = |(client, state): (usize, &LocalClient)| {
            let score = scores[self.nodes.of(client)]
                .get_or_insert_with(|| self.nodes.of_client(client).score(indicators));
            Candidate { client, score: *score, load: state.buffered() }
        };
        self.candidates().map(scored).collect()
    }

    /// Turns a buffer that is full, or that nothing more comes for now, into a task of its client.
    pub fn take_task(&mut self) -> Option<(usize, NewTask)> {
        let full = self.full_buffer();
        // What is suspicious does not go with the others.
        let is_last = self.next_scenario().is_none_or(|next| self.deferred.contains(&next));
        let is_due = |&&client: &&usize| {
            let state = &self.clients[client];
            let is_full = || {
                state.buffered() >= full
                    || self.nodes.of_client(client).added_bytes() >= self.limits.bytes
            };
            state.has_room_for_task() && (is_last || is_full())
        };
        let client = *self.buffering.iter().find(is_due)?;
        let number = self.next_task;
        self.next_task += 1;
        self.empty_buffer(client);
        let batch = self.clients[client].begin_task(number);
        let subtrees = self.nodes.of_client_mut(client).take_added();
        Some((client, NewTask { number, batch, subtrees }))
    }

    fn empty_buffer(&mut self, client: usize) {
        if self.buffering.remove(&client) {
            self.buffered -= self.clients[client].buffered();
        }
    }

    /// Another worker is started in the place of a dead one.
    pub fn restart(&mut self, client: usize) {
        self.clients[client].restart();
        self.alive += 1;
    }

    /// Takes back what a dead client has not answered. The scenario it died `at`, if it was at one,
    /// may have been its end: at the second such death it goes after all others, and at the third
    /// not at all. Returns whether it is so set aside.
    pub fn client_died(&mut self, client: usize, at: Option<u32>) -> Option<u32> {
        let mut set_aside = None;
        self.alive -= usize::from(self.clients[client].is_alive());
        self.empty_buffer(client);
        self.nodes.client_died(client);
        for scenario in self.clients[client].die() {
            let deaths = self.deaths.entry(scenario).or_default();
            *deaths += u32::from(at == Some(scenario));
            match *deaths {
                0 | 1 => drop(self.returned.insert(scenario)),
                MOST_DEATHS.. => set_aside = Some(scenario),
                _ => drop(self.deferred.insert(scenario)),
            }
        }
        set_aside
    }

    /// Who takes a scenario: the unclaimed clients with the fewest tasks. Who has nothing to do
    /// comes before those whose next task would have to wait.
    fn candidates(&self) -> impl Iterator<Item = (usize, &LocalClient)> {
        let unclaimed = || self.clients.iter().enumerate().filter(|(_, c)| !c.is_claimed());
        let fewest = unclaimed().map(|(_, client)| client.tasks()).min();
        unclaimed().filter(move |(_, client)| Some(client.tasks()) == fewest)
    }

    /// q, but less towards the end: with that few left, full buffers would leave some workers with
    /// nothing while another still has a whole buffer to answer. Guided self-scheduling
    /// (Polychronopoulos & Kuck 1987), counted in the tasks that all clients can hold.
    fn full_buffer(&self) -> usize {
        let untouched = self.end.saturating_sub(self.next) as usize;
        let left = self.buffered + self.returned.len() + untouched;
        let most_tasks = self.clients.first().map_or(1, LocalClient::most_tasks);
        let share = left.div_ceil((most_tasks * self.alive).max(1));
        share.clamp(1, self.limits.scenarios as usize)
    }
}

#[cfg(test)]
mod tests;
