//! What is filed beside the clients changes no choice: a look at every client makes the same.

use std::cmp::Reverse;
use std::collections::VecDeque;

use proptest::prelude::*;

use super::super::local_client::Indicators;
use super::*;
use crate::scene::MatchRule;

/// Who takes a scenario: the unclaimed clients with the fewest tasks.
fn plain_takers(assignment: &Assignment) -> Vec<usize> {
    let clients = assignment.clients();
    let unclaimed = || (0..clients.len()).filter(|&client| !clients[client].is_claimed());
    let fewest = unclaimed().map(|client| clients[client].tasks()).min();
    unclaimed().filter(|&client| Some(clients[client].tasks()) == fewest).collect()
}

/// By every rule but the random one, whose draws the matchmaker's own test follows.
fn plain_choice(
    assignment: &Assignment,
    rule: MatchRule,
    indicators: &Indicators,
) -> Option<usize> {
    let by = |&client: &usize| {
        let score = u128::from(assignment.nodes.of_client(client).score(indicators));
        let load = assignment.clients()[client].buffered();
        let room = assignment.limits.scenarios.saturating_sub(load as u32);
        let value = match rule {
            MatchRule::Best => score,
            MatchRule::Lowest => u128::MAX - score,
            MatchRule::BestLoad => score * u128::from(room),
            MatchRule::Random => unreachable!("it has no value"),
        };
        (Reverse(value), load, client)
    };
    plain_takers(assignment).into_iter().min_by_key(by)
}

/// The first client whose buffer is to be sent.
fn plain_due(assignment: &Assignment) -> Option<usize> {
    let next = assignment.next_scenario();
    let is_last = next.is_none_or(|next| assignment.deferred.contains(&next));
    let full = assignment.full_buffer();
    let is_due = |&client: &usize| {
        let state = &assignment.clients()[client];
        let brings = assignment.nodes.of_client(client).added_bytes();
        let is_full = state.buffered() >= full || brings >= assignment.limits.bytes;
        state.buffered() > 0 && state.has_room_for_task() && (is_last || is_full)
    };
    (0..assignment.clients().len()).find(is_due)
}

/// Subtrees 0 to 9 of both trees that take part, by the bits.
fn indicators(bits: [u16; 2]) -> Indicators {
    bits.map(|bits| {
        let takes_part = |root: &u32| bits >> root & 1 == 1;
        TreeIndicator::of((0..10).filter(takes_part).map(|root| (root, 1 + root % 3)))
    })
}

fn assignment(of: &[usize], rule: MatchRule, limits: BufferLimits, tasks: usize) -> Assignment {
    let clients = of.iter().map(|_| LocalClient::with_most_tasks(tasks)).collect();
    // Numbers without a gap.
    let mut numbers = of.to_vec();
    numbers.sort_unstable();
    numbers.dedup();
    let of: Vec<_> = of.iter().map(|node| numbers.binary_search(node).unwrap()).collect();
    let nodes =
        if numbers.len() == of.len() { Nodes::private(of.len()) } else { Nodes::shared(of) };
    let matchmaker = Matchmaker::new(rule, limits.scenarios as usize, 1);
    let bytes = [vec![100; 10], vec![30; 10]];
    let mut assignment = Assignment::new(clients, nodes, 300, limits, matchmaker, bytes);
    for client in 0..assignment.clients().len() {
        assignment.change(client, LocalClient::ready).unwrap();
    }
    assignment
}

/// Gives scenarios away up to the next that nobody takes, and holds every choice against the plain one.
fn fill(
    assignment: &mut Assignment,
    rule: MatchRule,
    needs: &[[u16; 2]],
    out: &mut [VecDeque<(u64, Vec<u32>)>],
) {
    loop {
        loop {
            let due = plain_due(assignment);
            let task = assignment.take_task();
            assert_eq!(task.as_ref().map(|(client, _)| *client), due);
            let Some((client, task)) = task else { break };
            let batch = task.batch.iter().map(|buffered| buffered.scenario).collect();
            out[client].push_back((task.number, batch));
        }
        let Some(scenario) = assignment.next_scenario() else { return };
        let takers = plain_takers(assignment);
        assert_eq!(assignment.can_assign(), !takers.is_empty());
        let needs_scores = rule != MatchRule::Random;
        assert_eq!(assignment.wants_scores(), needs_scores && takers.len() > 1);
        let indicators = indicators(needs[scenario as usize % needs.len()]);
        let expected = needs_scores.then(|| plain_choice(assignment, rule, &indicators));
        let analysis = Analysis { indicators, root_pairs: Vec::new() };
        let chosen = assignment.assign(scenario, analysis).map(|choice| choice.client);
        match expected {
            Some(expected) => assert_eq!(chosen, expected),
            None => assert!(chosen.is_none_or(|client| takers.contains(&client))),
        }
        if chosen.is_none() {
            return;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn choices_are_those_of_a_look_at_every_client(
        of in prop::collection::vec(0_usize..12, 1..12),
        rule in prop::sample::select(MatchRule::ALL.to_vec()),
        (q, tasks) in (1_u32..6, 1_usize..3),
        bytes in prop::sample::select(vec![0, 150, 400, u64::MAX]),
        needs in prop::collection::vec(any::<[u16; 2]>(), 1..30),
        events in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..10), 0..120),
    ) {
        let mut assignment = assignment(&of, rule, BufferLimits { scenarios: q, bytes }, tasks);
        let mut out = vec![VecDeque::new(); of.len()];
        for (client, what) in events {
            fill(&mut assignment, rule, &needs, &mut out);
            let client = client.index(of.len());
            if what == 0 && assignment.clients()[client].is_alive() {
                assignment.client_died(client, None);
                out[client].clear();
            } else if what == 1 && !assignment.clients()[client].is_alive() {
                assignment.restart(client);
                assignment.change(client, LocalClient::ready).unwrap();
            } else if let Some((task, batch)) = out[client].pop_front() {
                assignment.change(client, |state| {
                    batch.iter().for_each(|&scenario| state.answered(task, scenario).unwrap());
                    state.end_task(task).unwrap();
                });
            }
        }
    }
}
