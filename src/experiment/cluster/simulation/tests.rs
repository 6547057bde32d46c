use proptest::prelude::*;

use super::super::load::{ScenarioCost, SubtreeCost};
use super::super::machine::{Link, MasterPlace, MemoryRules, MessageCosts, Node};
use super::*;
use crate::scheduler::indicator::TreeIndicator;
use crate::scheduler::local_client::OUTSTANDING_TASKS;

const MS: Time = 1_000_000;
const NODE: Node = Node { cores: 1, speed: 1.0, memory_bytes: 1e9 };

/// Everything but computing is free, and the master is on a computer of its own.
fn ideal(nodes: Vec<Node>) -> Cluster {
    Cluster {
        nodes,
        master: MasterPlace::OwnNode,
        link: Link {
            bytes_per_s: f64::INFINITY,
            latency: 0,
            message_bytes: 0.0,
            window_bytes: None,
        },
        messages: MessageCosts {
            send: 0,
            receive: 0,
            gathered: 0,
            copy_bytes_per_s: f64::INFINITY,
            wake_up: 0,
            score_root: 0.0,
            delivery: 0,
        },
        copies: Copies::Process,
        memory: MemoryRules { process_bytes: 0.0, begin_on_master: false },
    }
}

/// Scenario s takes `ms[s]` milliseconds, of which the pre-analysis took none, and needs the fixed
/// tree's subtree s, modulo their number, of a million bytes.
fn load(ms: &[Time], subtrees: usize) -> Load {
    let subtree = SubtreeCost { memory_bytes: 1e6, sent_bytes: 1e6, ..SubtreeCost::default() };
    let scenario = |(s, &ms): (usize, &Time)| ScenarioCost {
        serial: ms * MS,
        below: ms * MS,
        analysis: 0,
        indicators: [
            TreeIndicator::of([((s % subtrees) as u32, 5)].into_iter()),
            TreeIndicator::default(),
        ],
        roots: 1,
        root_pairs: 1,
    };
    Load {
        scenarios: ms.iter().enumerate().map(scenario).collect(),
        subtrees: [vec![subtree; subtrees], Vec::new()],
        outline_bytes: [0.0; 2],
        tree_bytes: 1e6 * subtrees as f64,
        packing: 0,
    }
}

fn policy(rule: MatchRule, q: u32) -> Policy {
    Policy {
        rule,
        most_tasks: OUTSTANDING_TASKS,
        from: SubtreesFrom::Master,
        seed: 1,
        buffer: BufferLimits { scenarios: q, bytes: u64::MAX },
        holds_back: false,
    }
}

fn run(load: &Load, cluster: &Cluster, rule: MatchRule, q: u32) -> Outcome {
    simulate(load, cluster, &policy(rule, q), load.scenarios.len() as u32, &|_| {})
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} is not {expected}");
}

#[test]
fn one_worker_takes_the_sum_of_all_costs() {
    let load = load(&[3, 1, 4, 1, 5, 9, 2, 6], 3);
    for rule in MatchRule::ALL {
        let outcome = run(&load, &ideal(vec![NODE]), rule, 3);
        near(outcome.time_s, 31e-3);
        near(outcome.speedup, 1.0);
        near(outcome.relative_data_transfer, 1.0);
    }
}

#[test]
fn a_core_of_half_the_speed_takes_twice_as_long_and_the_bound_says_so() {
    let load = load(&[3, 1, 4], 3);
    let slow = Node { speed: 0.5, ..NODE };
    near(run(&load, &ideal(vec![slow]), MatchRule::Best, 1).time_s, 16e-3);
    let both = run(&load, &ideal(vec![NODE, slow]), MatchRule::Best, 1);
    near(both.bound, 1.5);
    near(both.speedup_bound, 1.5 * 1.5);
}

#[test]
fn equal_scenarios_on_equal_workers_take_equal_parts() {
    let outcome = run(&load(&[2; 40], 40), &ideal(vec![NODE; 4]), MatchRule::Best, 1);
    near(outcome.time_s, 20e-3);
    near(outcome.over_first, outcome.bound);
    near(outcome.utilisation.computing, 1.0);
}

#[test]
fn a_slow_link_takes_the_bytes_over_its_rate() {
    let cluster = ideal(vec![NODE]);
    let link = Link { bytes_per_s: 1e6, ..cluster.link };
    let cluster = Cluster { link, ..cluster };
    let outcome = run(&load(&[0; 50], 50), &cluster, MatchRule::Best, 10);
    assert!((50.0..50.2).contains(&outcome.time_s), "50 MB and some batches: {outcome:?}");
    near(outcome.bytes_sent, 50e6);
    assert!(outcome.utilisation.link > 0.99);
}

#[test]
fn a_master_that_waits_for_its_link_does_nothing_else_meanwhile() {
    let cluster = ideal(vec![NODE; 2]);
    let link = Link { bytes_per_s: 1e6, latency: MS, window_bytes: Some(1e5), ..cluster.link };
    let outcome = run(&load(&[0; 20], 20), &Cluster { link, ..cluster }, MatchRule::Best, 1);
    // Ten windows of a subtree, each there and back.
    assert!((20.4..20.6).contains(&outcome.time_s), "{outcome:?}");
    assert!(outcome.utilisation.master_blocked > 0.99);
}

#[test]
fn who_analyses_for_longer_than_all_compute_is_what_all_wait_for() {
    let mut load = load(&[1; 30], 3);
    load.scenarios.iter_mut().for_each(|scenario| scenario.analysis = 10 * MS);
    let outcome = run(&load, &ideal(vec![NODE; 4]), MatchRule::Best, 1);
    assert!((0.29..0.302).contains(&outcome.time_s), "{outcome:?}");
    assert!(outcome.utilisation.master > 0.98 && outcome.utilisation.link < 0.01);
}

#[test]
fn a_subtree_goes_once_to_each_process_or_once_to_a_node_for_all_of_its() {
    let two = Node { cores: 2, ..NODE };
    // All scenarios need the one subtree.
    let load = load(&[5; 40], 1);
    let a_process = run(&load, &ideal(vec![two; 3]), MatchRule::Best, 2);
    near(a_process.bytes_sent, 6e6);
    let shared = Cluster { copies: Copies::Node, ..ideal(vec![two; 3]) };
    let a_node = run(&load, &shared, MatchRule::Best, 2);
    near(a_node.bytes_sent, 3e6);
    assert!(a_node.memory.bytes < a_process.memory.bytes);
}

#[test]
fn where_geometry_is_in_place_nothing_is_sent_and_scenarios_start_from_the_top() {
    let mut load = load(&[3, 1, 4], 3);
    load.scenarios.iter_mut().for_each(|scenario| scenario.below = 1000 * MS);
    let cluster = ideal(vec![NODE]);
    let cluster = Cluster { master: MasterPlace::FirstNode, copies: Copies::Node, ..cluster };
    let outcome = run(&load, &cluster, MatchRule::Best, 2);
    near(outcome.time_s, 8e-3);
    near(outcome.bytes_sent, 0.0);
}

#[test]
fn a_master_that_shares_the_only_core_slows_its_worker() {
    let mut load = load(&[10; 10], 1);
    load.scenarios.iter_mut().for_each(|scenario| scenario.analysis = 10 * MS);
    let cluster = Cluster { master: MasterPlace::FirstNode, ..ideal(vec![NODE]) };
    near(run(&load, &cluster, MatchRule::Best, 1).time_s, 190e-3);
}

#[test]
fn a_node_without_enough_memory_is_found_out() {
    let small = Node { memory_bytes: 15e6, ..NODE };
    let cluster = ideal(vec![NODE, small]);
    let memory = |scenarios: usize| {
        run(&load(&vec![1; scenarios], scenarios), &cluster, MatchRule::Best, 20).memory
    };
    assert!(!memory(20).is_exceeded(), "half of twenty subtrees: {:?}", memory(20));
    assert!(memory(60).is_exceeded(), "half of sixty: {:?}", memory(60));
    assert_eq!(memory(60).fullest_node, 1);
}

#[test]
fn what_one_worker_has_others_fetch_from_it() {
    let load = load(&[5; 400], 40);
    let cluster = ideal(vec![NODE; 3]);
    let all_from_master = run(&load, &cluster, MatchRule::Random, 2);
    near(all_from_master.bytes_fetched, 0.0);
    let policy = Policy { from: SubtreesFrom::Workers, ..policy(MatchRule::Random, 2) };
    let outcome = simulate(&load, &cluster, &policy, 400, &|_| {});
    assert!(outcome.bytes_fetched > 0.0 && outcome.bytes_sent >= 40e6, "{outcome:?}");
    assert!(outcome.bytes_sent < all_from_master.bytes_sent, "{outcome:?}");
    let had = outcome.bytes_sent + outcome.bytes_fetched;
    assert!((40e6..=120e6).contains(&had), "each of three has each at most once: {outcome:?}");
}

/// So many hosts of two workers, the master on the first, at this link; 3744 scenarios of two milliseconds
/// and 40 megabytes of geometry.
fn hosts(count: usize, megabits_per_s: f64, holds_back: bool) -> f64 {
    let mut load = load(&[2; 3744], 40);
    load.outline_bytes = [5e5, 0.0];
    let cluster = ideal(vec![Node { cores: 2, ..NODE }; count]);
    let cluster = Cluster {
        link: Link { bytes_per_s: megabits_per_s * 1e6 / 8.0, latency: 50_000, ..cluster.link },
        copies: Copies::Node,
        master: MasterPlace::FirstNode,
        ..cluster
    };
    let policy = Policy { holds_back, ..policy(MatchRule::Best, 20) };
    simulate(&load, &cluster, &policy, 3744, &|_| {}).time_s
}

#[test]
fn a_host_behind_a_slow_link_does_not_make_a_run_much_longer_than_it_is_without() {
    let alone = hosts(1, 1000.0, true);
    near(alone, hosts(1, 1000.0, false));
    assert!(hosts(2, 10.0, false) > 6.0 * alone, "full buffers");
    for rate in [0.1, 1.0, 3.0, 10.0, 30.0] {
        let both = hosts(2, rate, true);
        assert!(both < 1.5 * alone, "{both} s at {rate} Mb/s, {alone} s without it");
    }
}

#[test]
fn a_host_behind_a_fast_link_is_not_slowed_by_its_trial() {
    for rate in [300.0, 1000.0, 10_000.0] {
        let (before, held_back) = (hosts(2, rate, false), hosts(2, rate, true));
        assert!(held_back < 1.03 * before, "{held_back} s, not {before} s, at {rate} Mb/s");
    }
}

/// Subtrees of first tasks are in the master's memory as long as these last.
#[test]
fn clients_that_begin_on_the_masters_node_take_its_memory() {
    let load = load(&[1000; 40], 40);
    let cluster = ideal(vec![NODE; 4]);
    let elsewhere = run(&load, &cluster, MatchRule::Best, 5).memory;
    let memory = MemoryRules { begin_on_master: true, ..cluster.memory };
    let here = run(&load, &Cluster { memory, ..cluster }, MatchRule::Best, 5).memory;
    assert!(here.fullest > elsewhere.fullest + 15e6 / 1e9, "{here:?} {elsewhere:?}");
    assert_eq!(here.fullest_node, 4, "the master's own");
}

fn any_cluster() -> impl Strategy<Value = Cluster> {
    let node = (1_u32..4, 1_u32..5).prop_map(|(cores, speed)| Node {
        cores,
        speed: f64::from(speed) / 2.0,
        memory_bytes: 1e9,
    });
    let nodes = prop::collection::vec(node, 1..4);
    let costs = (0_u64..50_000, 0_u64..50_000, 1_u32..100, any::<bool>());
    (nodes, costs, any::<[bool; 2]>()).prop_map(|(nodes, costs, [shared, here])| {
        let (latency, send, rate, waits) = costs;
        let cluster = ideal(nodes);
        let rate = f64::from(rate) * 1e7;
        let window_bytes = waits.then_some(65536.0);
        Cluster {
            link: Link { bytes_per_s: rate, latency, message_bytes: 66.0, window_bytes },
            messages: MessageCosts { send, receive: send, wake_up: send / 2, ..cluster.messages },
            copies: if shared { Copies::Node } else { Copies::Process },
            master: if here { MasterPlace::FirstNode } else { MasterPlace::OwnNode },
            ..cluster
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// With a free network, whoever is done finds work: Graham's bound (1966), with twice the longest,
    /// as a second task may wait behind a first.
    #[test]
    fn free_messages_make_it_list_scheduling(
        ms in prop::collection::vec(0_u64..20, 1..60),
        workers in 1_usize..6,
        rule in prop::sample::select(MatchRule::ALL.to_vec()),
    ) {
        let total = ms.iter().sum::<u64>() as f64;
        let longest = ms.iter().copied().max().unwrap_or(0) as f64;
        prop_assume!(total > 0.0);
        let outcome = run(&load(&ms, 7), &ideal(vec![NODE; workers]), rule, 1);
        let time_ms = 1e3 * outcome.time_s;
        let even = total / workers as f64;
        prop_assert!(time_ms >= even.max(longest) - 1e-6, "{time_ms} of {even}, {longest}");
        prop_assert!(time_ms <= even + 2.0 * longest + 1e-6, "{time_ms} of {even}, {longest}");
    }

    /// That every scenario is answered exactly once, the order of results itself makes sure of.
    #[test]
    fn all_is_computed_once_nothing_is_faster_than_it_can_be_and_it_repeats(
        ms in prop::collection::vec(1_u64..20, 1..60),
        cluster in any_cluster(),
        rule in prop::sample::select(MatchRule::ALL.to_vec()),
        q in 1_u32..8,
        holds_back in any::<bool>(),
    ) {
        let load = load(&ms, 9);
        let run = || {
            let policy = Policy { holds_back, ..policy(rule, q) };
            simulate(&load, &cluster, &policy, ms.len() as u32, &|_| {})
        };
        let outcome = run();
        prop_assert_eq!(&outcome, &run());
        prop_assert!(outcome.speedup <= outcome.speedup_bound * (1.0 + 1e-6), "{:?}", outcome);
        let needed = ms.len().min(9) as f64;
        let memories = match cluster.copies {
            Copies::Process => cluster.workers(),
            Copies::Node => cluster.nodes.len(),
        };
        let copies = outcome.bytes_sent / 1e6;
        prop_assert!(copies <= needed * memories as f64 + 1e-6, "{:?}", outcome);
        let is_in_place = (0..cluster.nodes.len()).any(|node| cluster.is_in_place(node));
        prop_assert!(is_in_place || copies >= needed - 1e-6, "{:?}", outcome);
        let least_s = outcome.bytes_sent / cluster.link.bytes_per_s;
        let all_remote = cluster.master == MasterPlace::OwnNode;
        prop_assert!(!all_remote || outcome.time_s >= least_s - 1e-6, "{:?}", outcome);
    }

    /// The unit of time is nothing but a unit. All times are whole nanoseconds here, so that nothing is
    /// rounded.
    #[test]
    fn a_cluster_that_takes_twice_as_long_for_everything_takes_twice_as_long(
        ms in prop::collection::vec(1_u64..20, 1..40),
        speeds in prop::collection::vec(0_i32..3, 1..5),
        [latency, send, rate] in any::<[u8; 3]>(),
        rule in prop::sample::select(MatchRule::ALL.to_vec()),
    ) {
        let cluster_of = |times: Time| {
            let node = |&speed: &i32| Node { speed: 0.5_f64.powi(speed), ..NODE };
            let cluster = ideal(speeds.iter().map(node).collect());
            let bytes_per_s = 1e9 / f64::from(1 << (rate % 8)) / times as f64;
            let (latency, send) = (1000 * times * u64::from(latency), 1000 * times * u64::from(send));
            Cluster {
                link: Link { bytes_per_s, latency, ..cluster.link },
                messages: MessageCosts { send, receive: send, ..cluster.messages },
                ..cluster
            }
        };
        let twice: Vec<_> = ms.iter().map(|ms| 2 * ms).collect();
        let once = run(&load(&ms, 9), &cluster_of(1), rule, 3);
        near(run(&load(&twice, 9), &cluster_of(2), rule, 3).time_s, 2.0 * once.time_s);
    }
}
