//! Which scenario is with which client: the state of a run, without clock or processes.

use std::collections::BTreeSet;

use super::local_client::{Indicators, LocalClient, OUTSTANDING_TASKS};
use super::matchmaker::best_match;

/// How far scenarios are given away beyond the first that has not been answered, in full buffers
/// for each client. Results wait in memory for all before them, so a client that is stuck must not
/// let the others run on without end.
const BUFFERS_AHEAD: u32 = 64;

#[derive(Debug)]
pub struct Assignment {
    pub clients: Vec<LocalClient>,
    /// q: scenarios that fill a buffer.
    buffer_scenarios: usize,
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
    next_task: u64,
}

impl Assignment {
    pub fn new(clients: usize, scenarios: u32, buffer_scenarios: u32) -> Self {
        let buffers_ahead = BUFFERS_AHEAD.saturating_mul(clients as u32);
        Self {
            clients: (0..clients).map(|_| LocalClient::default()).collect(),
            buffer_scenarios: buffer_scenarios as usize,
            next: 0,
            end: scenarios,
            delivered: 0,
            ahead: buffers_ahead.saturating_mul(buffer_scenarios),
            returned: BTreeSet::new(),
            next_task: 0,
        }
    }

    /// The scenario to be assigned next: the first of all, because results are delivered in order.
    /// `None` if all are given away, or if it is too far ahead of the results.
    pub fn next_scenario(&self) -> Option<u32> {
        let first = self.returned.first().copied().unwrap_or(self.next);
        (first < self.end.min(self.delivered.saturating_add(self.ahead))).then_some(first)
    }

    /// Gives away no scenario from `end` on any more.
    pub fn stop_at(&mut self, end: u32) {
        self.end = self.end.min(end);
    }

    /// Takes note that all scenarios below this one were delivered.
    pub fn delivered(&mut self, scenarios: u32) {
        self.delivered = scenarios;
    }

    /// Whether there are several clients to choose from, so that a match is worth its cost.
    pub fn has_choice(&self) -> bool {
        self.candidates().count() > 1
    }

    pub fn is_anyone_alive(&self) -> bool {
        self.clients.iter().any(LocalClient::is_alive)
    }

    pub fn is_anyone_unclaimed(&self) -> bool {
        self.clients.iter().any(|client| !client.is_claimed())
    }

    /// Buffers the next scenario with the candidate that matches best.
    pub fn assign(&mut self, scenario: u32, indicators: &Indicators) -> Option<usize> {
        let candidates = self.candidates().map(|(index, c)| c.candidate(index, indicators));
        let chosen = best_match(candidates)?;
        self.clients[chosen].push(scenario, indicators);
        if !self.returned.remove(&scenario) {
            self.next = scenario + 1;
        }
        Some(chosen)
    }

    /// Turns the buffer of a client into a task if it is full, or if nothing more comes for now.
    /// Returns the task's number and its scenarios, ascending.
    pub fn take_task(&mut self, client: usize) -> Option<(u64, &[u32])> {
        let buffered = self.clients[client].buffered();
        let is_full = buffered >= self.full_buffer() || self.next_scenario().is_none();
        if buffered == 0 || !is_full || self.clients[client].is_claimed() {
            return None;
        }
        let number = self.next_task;
        self.next_task += 1;
        Some((number, self.clients[client].begin_task(number)))
    }

    /// Takes back what a dead client has not answered.
    pub fn client_died(&mut self, client: usize) {
        self.returned.extend(self.clients[client].die());
    }

    /// The unclaimed clients with the fewest tasks: who has nothing to do comes before those whose
    /// next task would have to wait.
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
        share.clamp(1, self.buffer_scenarios)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::indicator::tests::row;
    use super::*;

    fn run_of(clients: usize, scenarios: u32, q: u32) -> Assignment {
        let mut assignment = Assignment::new(clients, scenarios, q);
        assignment.clients.iter_mut().for_each(|client| client.ready().unwrap());
        assignment
    }

    fn assign_next(assignment: &mut Assignment) -> Option<usize> {
        let scenario = assignment.next_scenario()?;
        assignment.assign(scenario, &Indicators::default())
    }

    #[test]
    fn scenarios_of_table_1_go_to_the_client_that_has_their_geometry() {
        let mut assignment = run_of(2, 1000, 20);
        let rows = [
            [row(0, &[0, 0, 0, 0, 1, 4]), row(1, &[2, 0, 14, 6])],
            [row(0, &[0, 11, 0, 1, 1, 0]), row(1, &[2, 1, 14, 6])],
            [row(0, &[0, 0, 0, 0, 0, 0]), row(1, &[0, 0, 0, 0])],
            [row(0, &[0, 11, 0, 1, 1, 0]), row(1, &[0, 1, 0, 6])],
        ];
        // The third matches nobody and goes to the emptier buffer, the others to what they know.
        let chosen: Vec<_> =
            (0..).zip(&rows).map(|(n, row)| assignment.assign(n, row).unwrap()).collect();
        assert_eq!(chosen, [0, 0, 1, 0]);
    }

    #[test]
    fn a_buffer_is_sent_when_it_holds_q_scenarios() {
        let mut assignment = run_of(1, 1000, 3);
        for count in 1..=3 {
            assert!(assignment.take_task(0).is_none(), "sent with {}", count - 1);
            assign_next(&mut assignment);
        }
        assert_eq!(assignment.take_task(0), Some((0, &[0, 1, 2][..])));
    }

    #[test]
    fn tasks_shrink_towards_the_end() {
        let mut assignment = run_of(2, 100, 20);
        let mut sizes = Vec::new();
        let mut answer_all = |assignment: &mut Assignment, client: usize| {
            let Some((task, scenarios)) = assignment.take_task(client) else { return };
            let scenarios = scenarios.to_vec();
            for &scenario in &scenarios {
                assignment.clients[client].answered(task, scenario).unwrap();
            }
            assignment.clients[client].end_task(task).unwrap();
            sizes.push(scenarios.len());
        };
        while assign_next(&mut assignment).is_some() {
            (0..2).for_each(|client| answer_all(&mut assignment, client));
        }
        assert_eq!(sizes.iter().sum::<usize>(), 100);
        assert!(sizes.is_sorted_by(|a, b| a >= b), "{sizes:?}");
        assert_eq!((sizes[0], sizes[sizes.len() - 1]), (20, 1), "{sizes:?}");
    }

    #[test]
    fn idle_clients_come_before_better_matching_busy_ones() {
        let mut assignment = run_of(2, 1000, 1);
        let geometry = [row(0, &[0, 11, 0, 0, 0, 0]), row(1, &[2, 0, 0, 0])];
        assert_eq!(assignment.assign(0, &geometry), Some(0));
        assert!(assignment.take_task(0).is_some());
        assert_eq!(assignment.assign(1, &geometry), Some(1));
    }

    #[test]
    fn there_is_a_choice_only_among_clients_that_could_take_the_scenario_equally_soon() {
        let mut assignment = run_of(2, 1000, 1);
        assert!(assignment.has_choice());
        assert_eq!(assign_next(&mut assignment), Some(0));
        assert!(assignment.take_task(0).is_some());
        assert!(!assignment.has_choice(), "one is idle, the other has a task");
        assert_eq!(assign_next(&mut assignment), Some(1));
        assert!(assignment.take_task(1).is_some());
        assert!(assignment.has_choice());
        assignment.client_died(1);
        assert!(!assignment.has_choice());
    }

    #[test]
    fn what_a_dead_client_had_goes_first_to_the_others() {
        let mut assignment = run_of(2, 1000, 2);
        assign_next(&mut assignment);
        assignment.clients[1].push(1, &Indicators::default());
        assignment.next = 2;
        assignment.client_died(0);
        assert_eq!(assignment.next_scenario(), Some(0));
        assert_eq!(assign_next(&mut assignment), Some(1));
        assert_eq!(assignment.next_scenario(), Some(2));
        assignment.client_died(1);
        assert!(!assignment.is_anyone_alive());
        assert_eq!(assign_next(&mut assignment), None);
    }

    #[test]
    fn nothing_beyond_the_end_is_given_away() {
        let mut assignment = run_of(1, 1000, 2);
        assign_next(&mut assignment);
        assignment.stop_at(1);
        assert_eq!(assignment.next_scenario(), None);
        assert_eq!(assignment.take_task(0), Some((0, &[0][..])), "nothing more will come");
    }

    #[test]
    fn nothing_is_given_away_far_ahead_of_a_missing_result() {
        let mut assignment = run_of(2, u32::MAX, 3);
        assignment.ahead = 10;
        (0..3).for_each(|scenario| assignment.clients[0].push(scenario, &Indicators::default()));
        assignment.next = 3;
        assert_eq!(assignment.take_task(0), Some((0, &[0, 1, 2][..])));
        for scenarios in [&[3, 4, 5][..], &[6, 7, 8], &[9]] {
            scenarios.iter().for_each(|_| assert_eq!(assign_next(&mut assignment), Some(1)));
            let (task, sent) = assignment.take_task(1).unwrap();
            assert_eq!(sent, scenarios, "a buffer that nothing more comes for is not held back");
            for &scenario in scenarios {
                assignment.clients[1].answered(task, scenario).unwrap();
            }
            assignment.clients[1].end_task(task).unwrap();
        }
        assert_eq!(assignment.next_scenario(), None);
        assignment.delivered(1);
        assert_eq!(assignment.next_scenario(), Some(10));
    }

    proptest! {
        /// Any order of answers and deaths: every scenario is answered exactly once, unless all
        /// clients die.
        #[test]
        fn every_scenario_is_answered_exactly_once(
            clients in 1_usize..5,
            scenarios in 0_u32..60,
            q in 1_u32..8,
            ahead in 1_u32..80,
            events in prop::collection::vec((0_usize..5, 0_u8..10), 0..400),
        ) {
            let mut assignment = run_of(clients, scenarios, q);
            assignment.ahead = ahead;
            let mut out: Vec<Vec<(u64, Vec<u32>)>> = vec![Vec::new(); clients];
            let mut answers = vec![0; scenarios as usize];
            // Random events first, then everybody answers until the end.
            let rest = (0..clients).cycle().map(|client| (client, 9)).take(1000);
            for (client, what) in events.into_iter().chain(rest) {
                let client = client % clients;
                let mut take_tasks = |assignment: &mut Assignment| {
                    for (client, tasks) in out.iter_mut().enumerate() {
                        let task = assignment.take_task(client);
                        tasks.extend(task.map(|(task, batch)| (task, batch.to_vec())));
                    }
                };
                while assign_next(&mut assignment).is_some() {
                    take_tasks(&mut assignment);
                }
                take_tasks(&mut assignment);
                let alive = assignment.clients.iter().filter(|client| client.is_alive()).count();
                if what == 0 && alive > 1 {
                    assignment.client_died(client);
                    out[client].clear();
                } else if let Some((task, batch)) = out[client].first_mut() {
                    let scenario = batch.remove(0);
                    assignment.clients[client].answered(*task, scenario).unwrap();
                    answers[scenario as usize] += 1;
                    let delivered = answers.iter().take_while(|&&count| count == 1).count() as u32;
                    assignment.delivered(delivered);
                    prop_assert!(assignment.next <= delivered + ahead);
                    if batch.is_empty() {
                        assignment.clients[client].end_task(*task).unwrap();
                        out[client].remove(0);
                    }
                }
            }
            prop_assert!(answers.iter().all(|&count| count == 1), "{:?}", answers);
        }
    }
}
