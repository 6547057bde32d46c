//! Which scenario is with which client: the state of a run, without clock or processes.

use std::collections::{BTreeMap, BTreeSet};

use super::local_client::{
    Analysis, Indicators, LocalClient, NewTask, OUTSTANDING_TASKS, SubtreeBytes,
};
use super::matchmaker::{Candidate, Matchmaker};

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
}

impl Assignment {
    pub fn new(
        clients: Vec<LocalClient>,
        scenarios: u32,
        limits: BufferLimits,
        matchmaker: Matchmaker,
        subtree_bytes: SubtreeBytes,
    ) -> Self {
        let buffers_ahead = BUFFERS_AHEAD.saturating_mul(clients.len() as u32);
        Self {
            clients,
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
        self.clients.iter().any(LocalClient::is_alive)
    }

    /// Whether somebody takes a scenario now.
    pub fn can_assign(&self) -> bool {
        self.candidates().next().is_some()
    }

    /// Buffers the scenario, which is the next, with the candidate that the matchmaker picks; with
    /// none there is nobody who takes it.
    pub fn assign(&mut self, scenario: u32, analysis: Analysis) -> Option<usize> {
        let candidates = self.scored(&analysis.indicators);
        let chosen = self.matchmaker.pick(&candidates)?;
        let client = &mut self.clients[chosen];
        client.push(scenario, analysis, &self.subtree_bytes);
        if !(self.returned.remove(&scenario) || self.deferred.remove(&scenario)) {
            self.next = scenario + 1;
        }
        Some(chosen)
    }

    fn scored(&self, indicators: &Indicators) -> Vec<Candidate> {
        self.candidates().map(|(index, c)| c.candidate(index, indicators)).collect()
    }

    /// Turns the buffer of a client into a task if it is full, or if nothing more comes for now.
    pub fn take_task(&mut self, client: usize) -> Option<NewTask> {
        if self.clients[client].buffered() == 0 || !self.clients[client].has_room_for_task() {
            return None;
        }
        if !self.is_full(client) {
            return None;
        }
        let number = self.next_task;
        self.next_task += 1;
        Some(self.clients[client].begin_task(number))
    }

    fn is_full(&self, client: usize) -> bool {
        let client = &self.clients[client];
        client.buffered() >= self.full_buffer()
            || client.buffered_bytes() >= self.limits.bytes
            // What is suspicious does not go with the others.
            || self.next_scenario().is_none_or(|next| self.deferred.contains(&next))
    }

    /// Takes back what a dead client has not answered. The scenario it died `at`, if it was at one,
    /// may have been its end: at the second such death it goes after all others, and at the third
    /// not at all. Returns whether it is so set aside.
    pub fn client_died(&mut self, client: usize, at: Option<u32>) -> Option<u32> {
        let mut set_aside = None;
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
        let alive = self.clients.iter().filter(|client| client.is_alive()).count();
        let buffered: usize = self.clients.iter().map(LocalClient::buffered).sum();
        let untouched = self.end.saturating_sub(self.next) as usize;
        let left = buffered + self.returned.len() + untouched;
        let share = left.div_ceil((OUTSTANDING_TASKS * alive).max(1));
        share.clamp(1, self.limits.scenarios as usize)
    }
}

#[cfg(test)]
mod tests;
