//! Which scenario is with which client: the state of a run, without clock or processes.

mod held;

use std::collections::{BTreeMap, BTreeSet};

use super::indicator::TreeIndicator;
use super::local_client::{Analysis, LocalClient, NewTask, SubtreeBytes};
use super::matchmaker::{Choice, Matchmaker};
use super::node::Nodes;
use super::takers::{Standing, Takers, Unclaimed};
use held::Held;

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
    clients: Vec<LocalClient>,
    /// Those of them that take scenarios.
    unclaimed: Unclaimed,
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
    /// Nodes whose next task brings V bytes or more.
    heavy: BTreeSet<usize>,
    /// Scenarios in all buffers together.
    buffered: usize,
    /// Clients that are alive.
    alive: usize,
    /// Who is given nothing for now. Absent: nobody is held.
    held: Option<Held>,
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
        let unclaimed = Unclaimed::new(clients.len(), nodes.count());
        let mut assignment = Self {
            clients,
            unclaimed,
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
            heavy: BTreeSet::new(),
            buffered: 0,
            alive,
            held: None,
        };
        (0..assignment.clients.len()).for_each(|client| assignment.file(client));
        assignment
    }

    pub fn clients(&self) -> &[LocalClient] {
        &self.clients
    }

    pub fn into_clients(self) -> (Vec<LocalClient>, Nodes) {
        (self.clients, self.nodes)
    }

    /// Whatever happens to a client goes through here, or who is unclaimed would not be known.
    pub fn change<R>(&mut self, client: usize, change: impl FnOnce(&mut LocalClient) -> R) -> R {
        let before = self.seen(client);
        let outcome = change(&mut self.clients[client]);
        self.take_note(client, before);
        self.file(client);
        outcome
    }

    fn file(&mut self, client: usize) {
        let is_held = self.is_held(client);
        let state = &self.clients[client];
        let standing = || Standing { tasks: state.tasks(), load: state.buffered() };
        let standing = (!state.is_claimed() && !is_held).then(standing);
        self.unclaimed.file(client, self.nodes.of(client), standing);
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
        self.matchmaker.rule().needs_scores()
            && self.unclaimed.takers().map_or(0, Takers::count) > 1
    }

    pub fn is_anyone_alive(&self) -> bool {
        self.alive > 0
    }

    /// Whether somebody takes a scenario now.
    pub fn can_assign(&mut self) -> bool {
        while let Some((_, client)) = self.unclaimed.takers().and_then(|it| it.emptiest().next()) {
            if self.still_takes(client) {
                return true;
            }
        }
        false
    }

    /// Buffers the scenario, which is the next, with the client that the matchmaker picks; with no
    /// takers there is nobody.
    pub fn assign(&mut self, scenario: u32, analysis: Analysis) -> Option<Choice> {
        let Analysis { indicators, root_pairs } = analysis;
        let highest = indicators.iter().map(TreeIndicator::triangles).sum();
        let choice = loop {
            let takers = self.unclaimed.takers()?;
            let score = |client: usize| self.nodes.of_client(client).score(&indicators);
            let choice = self.matchmaker.pick(takers, highest, score)?;
            if self.still_takes(choice.client) {
                break choice;
            }
        };
        let chosen = choice.client;
        self.change(chosen, |client| client.push(scenario, root_pairs));
        self.nodes.of_client_mut(chosen).give(&indicators, &self.subtree_bytes);
        self.weigh(self.nodes.of(chosen));
        self.buffered += 1;
        if !(self.returned.remove(&scenario) || self.deferred.remove(&scenario)) {
            self.next = scenario + 1;
        }
        Some(choice)
    }

    fn weigh(&mut self, node: usize) {
        if self.nodes.all()[node].added_bytes() >= self.limits.bytes {
            self.heavy.insert(node);
        } else {
            self.heavy.remove(&node);
        }
    }

    /// Turns a buffer that is full, or that nothing more comes for now, into a task of its client.
    pub fn take_task(&mut self) -> Option<(usize, NewTask)> {
        // What is suspicious does not go with the others.
        let is_last = self.next_scenario().is_none_or(|next| self.deferred.contains(&next));
        let full = if is_last { 1 } else { self.full_buffer() };
        let heavy = self.heavy.iter().filter_map(|&node| self.unclaimed.first_of(node));
        // To who is held nothing more comes for now.
        let held = self.held.as_ref().and_then(Held::first_with_scenarios);
        let client = heavy.chain(self.unclaimed.first_with(full)).chain(held).min()?;
        let number = self.next_task;
        self.next_task += 1;
        self.buffered -= self.clients[client].buffered();
        let batch = self.change(client, |state| state.begin_task(number));
        let subtrees = self.nodes.of_client_mut(client).take_added();
        self.weigh(self.nodes.of(client));
        Some((client, NewTask { number, batch, subtrees }))
    }

    /// Another worker is started in the place of a dead one.
    pub fn restart(&mut self, client: usize) {
        self.change(client, LocalClient::restart);
        self.alive += 1;
    }

    /// Takes back what a dead client has not answered. The scenario it died `at`, if it was at one,
    /// may have been its end: at the second such death it goes after all others, and at the third
    /// not at all. Returns whether it is so set aside.
    pub fn client_died(&mut self, client: usize, at: Option<u32>) -> Option<u32> {
        let mut set_aside = None;
        self.alive -= usize::from(self.clients[client].is_alive());
        self.buffered -= self.clients[client].buffered();
        self.nodes.client_died(client);
        self.weigh(self.nodes.of(client));
        for scenario in self.change(client, LocalClient::die) {
            let deaths = self.deaths.entry(scenario).or_default();
            *deaths += u32::from(at == Some(scenario));
            match *deaths {
                0 | 1 => drop(self.returned.insert(scenario)),
                MOST_DEATHS.. => set_aside = Some(scenario),
                _ => drop(self.deferred.insert(scenario)),
            }
        }
        self.file_held();
        set_aside
    }

    /// q, but less towards the end: with that few left, full buffers would leave some workers with
    /// nothing while another still has a whole buffer to answer. Guided self-scheduling
    /// (Polychronopoulos & Kuck 1987), counted in the tasks that all clients can hold.
    fn full_buffer(&self) -> usize {
        let left = self.buffered + self.returned.len() + self.untouched();
        let most_tasks = self.clients.first().map_or(1, LocalClient::most_tasks);
        let share = left.div_ceil((most_tasks * self.alive).max(1));
        share.clamp(1, self.limits.scenarios as usize)
    }

    /// Scenarios that nobody was given ever.
    fn untouched(&self) -> usize {
        self.end.saturating_sub(self.next) as usize
    }
}

#[cfg(test)]
mod choices;
#[cfg(test)]
mod slow_links;
#[cfg(test)]
mod tests;
