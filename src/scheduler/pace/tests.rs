use proptest::prelude::*;

use super::*;

const SECOND: Nanoseconds = 1_000_000_000;

/// Two clients of the master's node and two of another.
fn two_nodes() -> Pace {
    let clients = [(0, 0), (0, 0), (1, 0), (1, 0)];
    Pace::new(clients.into_iter(), [false, true].into_iter())
}

/// The client is sent a task and answers it.
fn answers(pace: &mut Pace, client: usize, scenarios: usize, [from, to]: [Nanoseconds; 2]) {
    pace.now_is(from * SECOND);
    pace.given(client);
    pace.sent(client, scenarios);
    pace.now_is(to * SECOND);
    pace.answered(client);
}

fn queue(own: usize, of_others: usize) -> Queue {
    Queue { own, of_node: own, of_others }
}

const EMPTY: Queue = Queue { own: 0, of_node: 0, of_others: 1000 };

#[test]
fn a_node_behind_a_link_gets_one_scenario_and_nothing_more_until_that_is_answered() {
    let mut pace = two_nodes();
    assert!((0..4).all(|client| !pace.holds(client, EMPTY)));
    assert!(!pace.given(0), "there is no link to try");
    assert!(pace.given(3));
    assert_eq!([0, 1, 2, 3].map(|client| pace.holds(client, EMPTY)), [false, false, true, true]);
    assert!(!pace.given(3), "it is on trial already");
    answers(&mut pace, 3, 1, [0, 2]);
    assert!((0..4).all(|client| !pace.holds(client, EMPTY)));
}

#[test]
fn the_trial_is_made_anew_when_its_client_dies_or_the_memory_of_the_node_is_lost() {
    let mut pace = two_nodes();
    pace.given(2);
    pace.died(3, false);
    assert!(pace.holds(3, EMPTY), "it was not with that one");
    pace.died(2, false);
    assert!(!pace.holds(3, EMPTY));
    assert!(pace.given(3), "the next one makes it");
    answers(&mut pace, 3, 1, [0, 1]);
    pace.died(3, false);
    assert!(!pace.given(2), "the link is known");
    pace.died(2, true);
    assert!(pace.given(2));
    pace.died(0, true);
    assert!(!pace.given(0), "what is lost there was not sent over a link");
}

#[test]
fn who_would_be_done_after_all_others_is_held() {
    let mut pace = two_nodes();
    // One scenario in one second each; two in one second together.
    answers(&mut pace, 0, 4, [0, 4]);
    answers(&mut pace, 1, 4, [0, 4]);
    answers(&mut pace, 2, 4, [0, 20]);
    // Five seconds for each of three, against 28 / 2 + 1, and 29 / 2 + 1.
    assert!(!pace.holds(2, queue(2, 28)));
    assert!(pace.holds(2, queue(3, 28)));
    assert!(pace.holds(2, queue(2, 27)));
    assert!(!pace.holds(0, queue(1000, 0)), "there is no link");
}

#[test]
fn who_has_answered_nothing_yet_waits_behind_its_whole_node() {
    let mut pace = two_nodes();
    answers(&mut pace, 0, 4, [0, 4]);
    answers(&mut pace, 2, 4, [0, 20]);
    let with_node = |of_node| Queue { own: 0, of_node, of_others: 18 };
    // The others' rate is 1.2 a second: 15 seconds, and one more.
    assert!(!pace.holds(3, with_node(2)));
    assert!(pace.holds(3, with_node(3)));
}

#[test]
fn few_answers_say_little_of_many_scenarios() {
    let mut pace = two_nodes();
    answers(&mut pace, 0, 4, [0, 4]);
    answers(&mut pace, 2, 1, [0, 1]);
    assert!(!pace.holds(2, queue(1, 1)));
    assert!(pace.holds(2, queue(2, 10)), "three, which may take twelve seconds");
    assert!(!pace.holds(2, queue(2, 12)));
}

#[test]
fn a_link_over_which_outlines_came_slowly_is_not_tried_at_the_end() {
    let mut pace = two_nodes();
    pace.told_of_trees(2);
    pace.now_is(2 * SECOND);
    pace.took_trees(2);
    assert!(!pace.holds(2, queue(0, 1)), "nobody knows how fast others are");
    answers(&mut pace, 0, 4, [2, 6]);
    assert!(!pace.holds(2, queue(0, 7)), "eight seconds, as the others");
    assert!(pace.holds(2, queue(0, 6)));
    assert!(!pace.holds(3, queue(0, 6)), "of whom nothing is known");
}

#[test]
fn who_is_at_its_first_task_without_a_link_is_taken_for_fast() {
    let mut pace = two_nodes();
    pace.sent(0, 18);
    assert!(!pace.holds(2, EMPTY), "the trial is made at once");
    answers(&mut pace, 2, 1, [0, 1]);
    assert!(!pace.has_slowed());
    assert!(pace.holds(2, EMPTY) && pace.holds(3, EMPTY));
    pace.now_is(36 * SECOND);
    pace.answered(0);
    assert!(pace.has_slowed(), "whoever is held may be free now");
    assert!(!pace.holds(2, EMPTY) && !pace.holds(3, EMPTY));
    pace.sent(1, 1);
    pace.sent(1, 1);
    assert!(pace.holds(2, EMPTY));
    pace.died(1, false);
    assert!(!pace.holds(2, EMPTY), "nothing comes of it");
}

#[test]
fn it_is_said_once_that_all_together_are_slower() {
    let mut pace = two_nodes();
    answers(&mut pace, 0, 100, [0, 1]);
    answers(&mut pace, 1, 100, [0, 1]);
    pace.has_slowed();
    answers(&mut pace, 1, 100, [1, 2]);
    assert!(!pace.has_slowed(), "as fast as before");
    answers(&mut pace, 1, 100, [2, 5]);
    assert!(pace.has_slowed());
    assert!(!pace.has_slowed());
    pace.died(0, false);
    assert!(pace.has_slowed());
}

#[test]
fn a_task_is_measured_from_when_it_was_sent_or_the_one_before_was_answered() {
    let mut measured = two_nodes();
    measured.sent(0, 2);
    measured.now_is(SECOND);
    measured.sent(0, 1);
    measured.now_is(10 * SECOND);
    measured.answered(0);
    assert_eq!(measured.paces.first(), Some(&(5 * SECOND, 0)));
    measured.now_is(11 * SECOND);
    measured.answered(0);
    // Ten seconds count half, and so do their two scenarios.
    assert_eq!(measured.paces.first(), Some(&(3 * SECOND, 0)));
    answers(&mut measured, 0, 1, [100, 107]);
    assert_eq!(measured.paces.first(), Some(&(5 * SECOND, 0)));
}

#[test]
fn what_is_left_of_an_earlier_run_is_not_measured() {
    let mut pace = Pace::new([(0, 1)].into_iter(), [true].into_iter());
    pace.given(0);
    pace.sent(0, 1);
    pace.now_is(3 * SECOND);
    pace.answered(0);
    assert!(pace.paces.is_empty() && pace.holds(0, EMPTY), "the trial is not answered");
    pace.now_is(5 * SECOND);
    pace.answered(0);
    assert_eq!(pace.paces.first(), Some(&(2 * SECOND, 0)));
}

proptest! {
    /// Sums that are kept are those of a look at every client.
    #[test]
    fn the_others_need_what_a_look_at_every_client_says(
        events in prop::collection::vec((0_usize..5, 0_u8..4, 1_usize..9, 0_u64..1000), 1..60),
        scenarios in 0_usize..1000,
    ) {
        let mut pace = Pace::new((0..5).map(|client| (client, 0)), [true; 5].into_iter());
        let mut plain: [Option<[f64; 2]>; 5] = [None; 5];
        let mut now = 0;
        for (client, what, count, passed) in events {
            pace.sent(client, count);
            now += 1 + passed;
            pace.now_is(now);
            if what == 0 {
                pace.died(client, false);
                plain[client] = None;
            } else {
                pace.answered(client);
                let [time, of] = plain[client].unwrap_or_default();
                plain[client] = Some([time / 2.0 + (1 + passed) as f64, of / 2.0 + count as f64]);
            }
        }
        for client in 0..5 {
            let others = || (0..5).filter(|&other| other != client).filter_map(|other| plain[other]);
            let pace_of = |[time, of]: [f64; 2]| (time / of).max(1.0).floor();
            let rate: f64 = others().map(|other| 1.0 / pace_of(other)).sum();
            let fastest = others().map(pace_of).reduce(f64::min);
            let found = pace.others_need(client, scenarios);
            prop_assert_eq!(found.is_some(), fastest.is_some());
            if let (Some(found), Some(fastest)) = (found, fastest) {
                let expected = scenarios as f64 / rate + fastest;
                prop_assert!((found as f64 - expected).abs() <= 1.0 + 1e-9 * expected);
            }
        }
    }
}
