use std::collections::VecDeque;

use proptest::prelude::*;

use super::super::indicator::tests::row;
use super::super::local_client::Indicators;
use super::*;
use crate::scene::MatchRule;

fn run_of(clients: usize, scenarios: u32, q: u32) -> Assignment {
    run_on(Nodes::private(clients), clients, scenarios, q)
}

fn run_on(nodes: Nodes, clients: usize, scenarios: u32, q: u32) -> Assignment {
    let clients = (0..clients).map(|_| LocalClient::default()).collect();
    let limits = BufferLimits { scenarios: q, bytes: u64::MAX };
    let matchmaker = Matchmaker::new(MatchRule::Best, q as usize, 0);
    let mut assignment =
        Assignment::new(clients, nodes, scenarios, limits, matchmaker, SubtreeBytes::default());
    for client in 0..assignment.clients.len() {
        assignment.change(client, LocalClient::ready).unwrap();
    }
    assignment
}

fn assign_next(assignment: &mut Assignment) -> Option<usize> {
    let scenario = assignment.next_scenario()?;
    assign(assignment, scenario, Analysis::default())
}

/// To whom the scenario goes.
fn assign(assignment: &mut Assignment, scenario: u32, analysis: Analysis) -> Option<usize> {
    assignment.assign(scenario, analysis).map(|choice| choice.client)
}

fn of(indicators: &Indicators) -> Analysis {
    Analysis { indicators: indicators.clone(), root_pairs: Vec::new() }
}

/// The next task, if it is the client's: its number and scenarios.
fn take_task(assignment: &mut Assignment, client: usize) -> Option<(u64, Vec<u32>)> {
    let (whose, task) = assignment.take_task()?;
    assert_eq!(whose, client);
    Some((task.number, task.batch.iter().map(|buffered| buffered.scenario).collect()))
}

fn answer_all(assignment: &mut Assignment, client: usize, (task, scenarios): (u64, Vec<u32>)) {
    for scenario in scenarios {
        assignment.change(client, |state| state.answered(task, scenario)).unwrap();
    }
    assignment.change(client, |state| state.end_task(task)).unwrap();
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
        (0..).zip(&rows).map(|(n, row)| assign(&mut assignment, n, of(row)).unwrap()).collect();
    assert_eq!(chosen, [0, 0, 1, 0]);
}

#[test]
fn a_buffer_is_sent_when_it_holds_q_scenarios() {
    let mut assignment = run_of(1, 1000, 3);
    for count in 1..=3 {
        assert!(assignment.take_task().is_none(), "sent with {}", count - 1);
        assign_next(&mut assignment);
    }
    assert_eq!(take_task(&mut assignment, 0), Some((0, vec![0, 1, 2])));
}

#[test]
fn tasks_shrink_towards_the_end() {
    let mut assignment = run_of(2, 100, 20);
    let mut sizes = Vec::new();
    while assign_next(&mut assignment).is_some() {
        while let Some((client, task)) = assignment.take_task() {
            let batch: Vec<_> = task.batch.iter().map(|buffered| buffered.scenario).collect();
            sizes.push(batch.len());
            answer_all(&mut assignment, client, (task.number, batch));
        }
    }
    assert_eq!(sizes.iter().sum::<usize>(), 100);
    assert!(sizes.is_sorted_by(|a, b| a >= b), "{sizes:?}");
    assert_eq!((sizes[0], sizes[sizes.len() - 1]), (20, 1), "{sizes:?}");
}

#[test]
fn idle_clients_come_before_better_matching_busy_ones() {
    let mut assignment = run_of(2, 1000, 1);
    let geometry = [row(0, &[0, 11, 0, 0, 0, 0]), row(1, &[2, 0, 0, 0])];
    assert_eq!(assign(&mut assignment, 0, of(&geometry)), Some(0));
    assert!(take_task(&mut assignment, 0).is_some());
    assert_eq!(assign(&mut assignment, 1, of(&geometry)), Some(1));
}

#[test]
fn there_is_a_choice_only_among_clients_that_could_take_the_scenario_equally_soon() {
    let mut assignment = run_of(2, 1000, 1);
    assert!(assignment.wants_scores());
    assert_eq!(assign_next(&mut assignment), Some(0));
    assert!(take_task(&mut assignment, 0).is_some());
    assert!(!assignment.wants_scores(), "one is idle, the other has a task");
    assert_eq!(assign_next(&mut assignment), Some(1));
    assert!(take_task(&mut assignment, 1).is_some());
    assert!(assignment.wants_scores());
    assignment.client_died(1, None);
    assert!(!assignment.wants_scores());
}

#[test]
fn what_a_dead_client_had_goes_first_to_the_others() {
    let mut assignment = run_of(2, 1000, 2);
    assign_next(&mut assignment);
    assert_eq!(assign_next(&mut assignment), Some(1));
    assignment.client_died(0, None);
    assert_eq!(assignment.next_scenario(), Some(0));
    assert_eq!(assign_next(&mut assignment), Some(1));
    assert_eq!(assignment.next_scenario(), Some(2));
    assignment.client_died(1, None);
    assert!(!assignment.is_anyone_alive());
    assert_eq!(assign_next(&mut assignment), None);
}

#[test]
fn nothing_beyond_the_end_is_given_away() {
    let mut assignment = run_of(1, 1000, 2);
    assign_next(&mut assignment);
    assignment.stop_at(1);
    assert_eq!(assignment.next_scenario(), None);
    assert_eq!(take_task(&mut assignment, 0), Some((0, vec![0])), "nothing more will come");
}

#[test]
fn nothing_is_given_away_far_ahead_of_a_missing_result() {
    let mut assignment = run_of(2, u32::MAX, 3);
    assignment.ahead = 10;
    let geometry = [row(0, &[0, 11, 0, 0, 0, 0]), row(1, &[2, 0, 0, 0])];
    for scenario in 0..3 {
        assert_eq!(assign(&mut assignment, scenario, of(&geometry)), Some(0));
    }
    assert_eq!(take_task(&mut assignment, 0), Some((0, vec![0, 1, 2])));
    for scenarios in [&[3, 4, 5][..], &[6, 7, 8], &[9]] {
        scenarios.iter().for_each(|_| assert_eq!(assign_next(&mut assignment), Some(1)));
        let task = take_task(&mut assignment, 1).unwrap();
        assert_eq!(task.1, scenarios, "a buffer that nothing more comes for is not held back");
        answer_all(&mut assignment, 1, task);
    }
    assert_eq!(assignment.next_scenario(), None);
    assignment.delivered(1);
    assert_eq!(assignment.next_scenario(), Some(10));
}

#[test]
fn a_buffer_is_sent_when_its_subtrees_make_v_bytes() {
    let mut assignment = run_of(1, 1000, 20);
    assignment.limits.bytes = 5000;
    assignment.subtree_bytes = [vec![1000; 6], vec![1000; 4]];
    let geometry = |first: &[u32]| of(&[row(0, first), row(1, &[0, 0, 14, 6])]);
    assign(&mut assignment, 0, geometry(&[1, 0, 0, 0, 0, 0]));
    assert!(assignment.take_task().is_none(), "3000 bytes");
    assign(&mut assignment, 1, geometry(&[1, 11, 0, 0, 0, 0]));
    assert!(assignment.take_task().is_none(), "4000 bytes, the others are there already");
    assign(&mut assignment, 2, geometry(&[0, 0, 1, 0, 0, 0]));
    assert_eq!(take_task(&mut assignment, 0), Some((0, vec![0, 1, 2])));
}

#[test]
fn a_subtree_goes_once_to_a_node_with_the_first_task_that_is_sent_there() {
    let mut assignment = run_on(Nodes::shared(vec![0, 0, 1]), 3, 1000, 2);
    assignment.subtree_bytes = [vec![1000; 6], vec![1000; 4]];
    let geometry = |first: &[u32]| of(&[row(0, first), row(1, &[0, 0, 14, 6])]);
    assert_eq!(assign(&mut assignment, 0, geometry(&[1, 0, 0, 0, 0, 0])), Some(0));
    assert_eq!(
        assign(&mut assignment, 1, geometry(&[1, 11, 0, 0, 0, 0])),
        Some(1),
        "the same node"
    );
    assert_eq!(
        assign(&mut assignment, 2, geometry(&[0, 0, 1, 0, 0, 0])),
        Some(0),
        "of equal buffers"
    );
    let (client, task) = assignment.take_task().unwrap();
    assert_eq!(
        (client, task.subtrees),
        (0, [vec![0, 1, 2], vec![2, 3]]),
        "what its mate needs too"
    );
    assert_eq!(assign(&mut assignment, 3, geometry(&[1, 11, 1, 0, 0, 0])), Some(1));
    let (client, task) = assignment.take_task().unwrap();
    assert_eq!((client, task.subtrees.concat()), (1, vec![]));
    assignment.client_died(0, None);
    assignment.restart(0);
    assignment.change(0, LocalClient::ready).unwrap();
    for expected in [0, 0] {
        let scenario = assignment.next_scenario().unwrap();
        assert_eq!(
            assign(&mut assignment, scenario, geometry(&[1, 0, 1, 0, 0, 0])),
            Some(expected)
        );
    }
    let (_, task) = assignment.take_task().unwrap();
    assert!(task.subtrees.iter().all(Vec::is_empty), "they are still there");
}

/// The scenarios in the order in which one client answers them, up to the one that ends it.
fn answers_until(assignment: &mut Assignment, end: u32) -> Vec<u32> {
    let mut order = Vec::new();
    let mut tasks = VecDeque::new();
    loop {
        while assignment.can_assign() && assign_next(assignment).is_some() {
            tasks.extend(take_task(assignment, 0));
        }
        let task: (u64, Vec<u32>) = tasks.pop_front().unwrap();
        for &scenario in &task.1 {
            if scenario == end {
                return order;
            }
            assignment.change(0, |state| state.answered(task.0, scenario)).unwrap();
            order.push(scenario);
        }
        assignment.change(0, |state| state.end_task(task.0)).unwrap();
    }
}

#[test]
fn a_scenario_that_clients_die_at_goes_first_then_last_and_then_not_at_all() {
    let mut assignment = run_of(1, 10, 3);
    let restart = |assignment: &mut Assignment| {
        assignment.restart(0);
        assignment.change(0, LocalClient::ready).unwrap();
    };
    assert_eq!(answers_until(&mut assignment, 4), [0, 1, 2, 3]);
    assert_eq!(assignment.client_died(0, Some(4)), None);
    restart(&mut assignment);
    assert_eq!(answers_until(&mut assignment, 4), [0; 0]);
    assert_eq!(assignment.client_died(0, Some(4)), None);
    restart(&mut assignment);
    assert_eq!(answers_until(&mut assignment, 4), [5, 6, 7, 8, 9]);
    assert_eq!(assignment.client_died(0, Some(4)), Some(4), "the third death");
    assert_eq!(assignment.next_scenario(), None);
}

#[test]
fn a_scenario_is_not_blamed_for_deaths_at_another_or_at_none() {
    let mut assignment = run_of(1, 3, 3);
    for at in [None, Some(1), Some(2), Some(700), None, Some(1), Some(2)] {
        assert_eq!(answers_until(&mut assignment, 0), [0; 0]);
        assert_eq!(assignment.client_died(0, at), None);
        assignment.restart(0);
        assignment.change(0, LocalClient::ready).unwrap();
    }
    assert_eq!(assignment.next_scenario(), Some(0));
    assert_eq!(answers_until(&mut assignment, 2), [0, 1]);
}

proptest! {
    /// Any order of answers, deaths and restarts: every scenario is answered or set aside, and
    /// that exactly once, unless all clients die.
    #[test]
    fn every_scenario_is_answered_or_set_aside_exactly_once(
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
        let mut set_aside = Vec::new();
        // Random events first, then everybody answers until the end.
        let rest = (0..clients).cycle().map(|client| (client, 9)).take(1000);
        for (client, what) in events.into_iter().chain(rest) {
            let client = client % clients;
            let mut take_tasks = |assignment: &mut Assignment| {
                while let Some((client, task)) = assignment.take_task() {
                    let batch = task.batch.iter().map(|buffered| buffered.scenario).collect();
                    out[client].push((task.number, batch));
                }
            };
            while assign_next(&mut assignment).is_some() {
                take_tasks(&mut assignment);
            }
            take_tasks(&mut assignment);
            let alive = assignment.clients.iter().filter(|client| client.is_alive()).count();
            if what == 0 && alive > 1 {
                // It may have been at what it has to answer next, or have been idle.
                let next = out[client].first().map(|(_, batch)| batch[0]);
                let at = next.filter(|scenario| scenario % 3 > 0);
                if let Some(scenario) = assignment.client_died(client, at) {
                    set_aside.push(scenario);
                    answers[scenario as usize] += 1;
                }
                let delivered = answers.iter().take_while(|&&count| count == 1).count() as u32;
                assignment.delivered(delivered);
                out[client].clear();
            } else if what == 1 && !assignment.clients[client].is_alive() {
                assignment.restart(client);
                assignment.change(client, LocalClient::ready).unwrap();
            } else if let Some((task, batch)) = out[client].first_mut() {
                let scenario = batch.remove(0);
                assignment.change(client, |state| state.answered(*task, scenario)).unwrap();
                answers[scenario as usize] += 1;
                let delivered = answers.iter().take_while(|&&count| count == 1).count() as u32;
                assignment.delivered(delivered);
                prop_assert!(assignment.next <= delivered + ahead);
                if batch.is_empty() {
                    assignment.change(client, |state| state.end_task(*task)).unwrap();
                    out[client].remove(0);
                }
            }
        }
        prop_assert!(answers.iter().all(|&count| count == 1), "{:?}", answers);
        prop_assert!(set_aside.iter().all(|s| assignment.deaths[s] == MOST_DEATHS));
    }
}
