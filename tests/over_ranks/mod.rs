//! Runs over several ranks, nodes and their leaders, with real worker processes.

mod in_process;

use std::num::NonZeroU32;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bumper::scene::{Compression, MatchRule, Slowdown, SubtreesFrom, WorkerCount};
use bumper::scheduler::client_manager::{Engine, EngineError, EngineReport, NodeReport, needs};
use bumper::scheduler::launch::Processes;
use bumper::scheduler::ranks::{Hybrid, NodeIs, OnNodes};
use bumper::transport::ranks::Rank;
use bumper::tree::TreeKind;
use bumper::tree::roots::Cut;

use crate::engine_run::{
    Answer, Options, Place, Recorder, Scene, kill, options, shared_memory_files,
};

static GO_ON: AtomicBool = AtomicBool::new(false);

/// Of each rank the lowest one on its machine.
const LAYOUTS: [&[Rank]; 5] = [&[0, 0], &[0, 1], &[0, 1, 1], &[0, 0, 2, 2], &[0, 1, 2, 2]];

/// Short runs until every worker takes part: what a run shows then is not a matter of who began first.
fn wait_for_all(engine: &mut Engine<Hybrid, OnNodes>, options: &Options) {
    let scene = Scene::new(12, 60);
    let all_take_part = |_| {
        let report = scene.run_on(engine, options, &mut Recorder::new(|_| Ok(())), &GO_ON);
        report.unwrap().workers.iter().all(|worker| worker.scenarios > 0)
    };
    assert!((0..1000).any(all_take_part), "a worker takes part in nothing");
}

/// An engine over these ranks, for as long as `use_it` takes; afterwards nothing of it is left.
fn with_engine<T>(
    machines: &[Rank],
    node: NodeIs,
    options: &Options,
    use_it: impl FnOnce(&mut Engine<Hybrid, OnNodes>, &Place) -> T,
) -> T {
    let place = Place::new();
    let processes = Processes { program: options.program.clone() };
    let (command, others) = in_process::start(machines, &processes, place.base());
    let mut engine_options = options.engine.clone();
    engine_options.workers = Some(WorkerCount::new(machines.len() as i64).unwrap());
    engine_options.start_from = Some(bumper::scene::StartFrom::RootPairs);
    // The master's own worker is slow, so that others do most of the work however late they begin.
    engine_options.slowdowns = vec![Slowdown::new(20.0).unwrap()];
    let end = Hybrid::create(place.base(), command, node, &needs(&engine_options)).unwrap();
    let prefixes = place.prefixes();
    let mut engine = Engine::start(end, OnNodes { here: processes }, engine_options).unwrap();
    let used = use_it(&mut engine, &place);
    drop(engine);
    others.end();
    assert_eq!(shared_memory_files(&prefixes), [""; 0]);
    assert_eq!(place.prefixes(), [""; 0]);
    assert!(place.workers().is_empty());
    used
}

fn run(
    scene: &Scene,
    machines: &[Rank],
    node: NodeIs,
    options: &Options,
) -> (EngineReport, Vec<Answer>) {
    with_engine(machines, node, options, |engine, _| {
        wait_for_all(engine, options);
        let mut recorder = Recorder::new(|_| Ok(()));
        let report = scene.run_on(engine, options, &mut recorder, &GO_ON).unwrap();
        (report, recorder.answers)
    })
}

#[test]
fn any_number_of_nodes_and_workers_gives_the_same_answers() {
    let scene = Scene::new(30, 80);
    let truth = scene.truth();
    for machines in LAYOUTS {
        for (rule, compress) in
            [(MatchRule::Best, Compression::None), (MatchRule::Lowest, Compression::Lz4)]
        {
            let mut options = options(1);
            (options.engine.matchmaker, options.engine.compress) = (rule, compress);
            let (report, answers) = run(&scene, machines, NodeIs::Machine, &options);
            assert!(answers == truth, "{machines:?} {rule:?} {compress:?}");
            let leaders = (0..).zip(machines).filter(|(rank, lowest)| rank == *lowest).count();
            assert_eq!(report.nodes.len(), if leaders == 1 { 0 } else { leaders });
            assert_eq!(report.workers.len(), machines.len());
            assert!(report.workers.iter().all(|worker| worker.geometry_bytes_copied == 0));
            assert!(report.nodes.iter().all(|node| node.relative_data_transfer < 1.2));
            let sent: u64 = report.nodes.iter().map(|node| node.geometry_bytes_copied).sum();
            assert_eq!((report.bytes_sent, sent > 0), (sent, leaders > 1));
        }
    }
}

#[test]
fn every_kind_of_tree_and_cut_gives_the_same_answers_on_another_node() {
    for (kind, cuts) in [
        (TreeKind::Obb, [Cut::Depth(0); 2]),
        (TreeKind::Aabb, [Cut::Triangles(50), Cut::Depth(3)]),
        (TreeKind::Wide, [Cut::Depth(6), Cut::Triangles(20)]),
    ] {
        let scene = Scene::of_kind(kind, 20, 40);
        let options = Options { cuts, ..options(1) };
        let (_, answers) = run(&scene, &[0, 1, 1], NodeIs::Machine, &options);
        assert!(answers == scene.truth(), "{kind:?} {cuts:?}");
    }
}

/// A node of three workers has one copy; as three nodes of one they have one each.
#[test]
fn workers_of_a_node_have_one_copy_of_what_it_was_sent() {
    let scene = Scene::new(40, 200);
    let machines = [0, 1, 1, 1];
    let mut options = options(1);
    options.engine.matchmaker = MatchRule::Random;
    let (hybrid, answers) = run(&scene, &machines, NodeIs::Machine, &options);
    assert!(answers == scene.truth());
    let (apart, answers) = run(&scene, &machines, NodeIs::Rank, &options);
    assert!(answers == scene.truth());
    assert_eq!((hybrid.nodes.len(), apart.nodes.len()), (2, 4));
    let of = |report: &EngineReport| report.nodes.iter().map(|n| n.workers).collect::<Vec<_>>();
    assert_eq!((of(&hybrid), of(&apart)), (vec![1, 3], vec![1; 4]));
    assert!(hybrid.bytes_sent > 0 && apart.bytes_sent > 2 * hybrid.bytes_sent);
    let link = |report: &EngineReport| report.nodes.iter().map(|n| n.link_bytes_sent).sum::<u64>();
    assert!(link(&hybrid) > hybrid.bytes_sent && link(&apart) > apart.bytes_sent);
}

/// A scenario goes to who has the least of it, a few at a time, so that subtrees are asked for all the
/// time.
fn exchanging(subtrees_from: SubtreesFrom) -> Options {
    let mut options = options(1);
    options.engine.subtrees_from = subtrees_from;
    options.engine.matchmaker = MatchRule::Lowest;
    options.engine.buffer_scenarios = 2.try_into().unwrap();
    options.cuts = [Cut::Depth(8); 2];
    options
}

#[test]
fn what_one_node_has_others_get_from_it_and_the_masters_link_carries_less() {
    let scene = Scene::new(60, 400);
    let truth = scene.truth();
    for (machines, node, compress) in [
        (&[0, 1, 2, 3][..], NodeIs::Machine, Compression::Lz4),
        (&[0, 1, 1, 3, 3], NodeIs::Machine, Compression::None),
        (&[0, 1, 1, 1], NodeIs::Rank, Compression::None),
    ] {
        let run_from = |from| {
            let mut options = exchanging(from);
            options.engine.compress = compress;
            let (report, answers) = run(&scene, machines, node, &options);
            assert!(answers == truth, "{machines:?} {from:?}");
            let other = |of: fn(&NodeReport) -> u64| report.nodes.iter().map(of).sum::<u64>();
            assert_eq!(other(|node| node.geometry_bytes_copied), report.bytes_sent);
            assert_eq!(other(|node| node.bytes_from_nodes), report.transfer.bytes_from_workers);
            assert_eq!((report.nodes[0].bytes_from_nodes, report.transfer.not_fetched), (0, 0));
            if from == SubtreesFrom::Workers {
                let once = report.transfer.bytes_packed;
                assert!(report.bytes_sent <= once, "{machines:?}: each subtree once, {once}");
            }
            let link = other(|node| node.link_bytes_sent);
            println!(
                "{machines:?} from {from:?}: {} of the master, {} of nodes, {link} over its link",
                report.bytes_sent, report.transfer.bytes_from_workers
            );
            (report.bytes_sent, report.transfer.bytes_from_workers, link)
        };
        let [alone, shared, auto] = SubtreesFrom::ALL.map(run_from);
        assert_eq!(alone.1, 0);
        assert!(shared.0 < alone.0 && shared.1 > alone.0 / 4, "{machines:?}");
        assert!(shared.2 < alone.2, "{machines:?}");
        // Who of them is the least busy is a matter of time.
        assert!(auto.1 > 0 && auto.1 <= alone.0, "{machines:?}");
    }
}

/// A node has what it has: what its dead worker brought is neither sent again nor waited for in vain.
#[test]
fn workers_of_nodes_that_exchange_subtrees_are_killed_and_no_scenario_is_lost() {
    let scene = Scene::new(60, 300);
    let options = exchanging(SubtreesFrom::Workers);
    let (report, answers) =
        with_engine(&[0, 1, 1, 3, 4], NodeIs::Machine, &options, |engine, place| {
            wait_for_all(engine, &options);
            let on_result = |scenario| {
                if [20, 60, 100].contains(&scenario) {
                    place.workers().into_iter().for_each(kill);
                }
                Ok(())
            };
            let mut recorder = Recorder::new(on_result);
            let report = scene.run_on(engine, &options, &mut recorder, &GO_ON).unwrap();
            (report, recorder.answers)
        });
    assert!(answers == scene.truth());
    assert!(report.workers.iter().any(|worker| worker.died));
    assert!(report.transfer.bytes_from_workers > 0);
    assert!(report.bytes_sent <= report.transfer.bytes_packed);
}

#[test]
fn what_a_node_was_sent_in_one_run_others_get_from_it_in_another() {
    let (small, large) = (Scene::new(12, 30), Scene::new(40, 200));
    let options = exchanging(SubtreesFrom::Workers);
    with_engine(&[0, 1, 2, 3], NodeIs::Machine, &options, |engine, _| {
        wait_for_all(engine, &options);
        for scene in [&large, &small, &large] {
            let mut recorder = Recorder::new(|_| Ok(()));
            let report = scene.run_on(engine, &options, &mut recorder, &GO_ON).unwrap();
            assert!(recorder.answers == scene.truth());
            assert!(report.transfer.bytes_from_workers > 0);
        }
    });
}

#[test]
fn a_worker_that_dies_on_another_node_is_replaced_there_and_loses_no_scenario() {
    let scene = Scene::new(40, 300);
    for moment in [0, 150] {
        let (report, answers) =
            with_engine(&[0, 1, 1], NodeIs::Machine, &options(1), |engine, place| {
                let on_result = |scenario| {
                    if scenario == moment {
                        place.workers().into_iter().for_each(kill);
                    }
                    Ok(())
                };
                let mut recorder = Recorder::new(on_result);
                let report = scene.run_on(engine, &options(1), &mut recorder, &GO_ON).unwrap();
                (report, recorder.answers)
            });
        assert!(answers == scene.truth(), "killed at {moment}");
        // The first to come back may have done all the work before the other is there again.
        assert!(report.workers.iter().any(|worker| worker.died && worker.restarts == 1));
        assert!(report.workers.iter().all(|worker| worker.restarts <= 1));
        // Its memory is the node's: what was sent is not sent again.
        assert!(report.nodes[1].relative_data_transfer < 1.2);
    }
}

#[test]
fn when_nobody_is_left_the_last_words_of_another_node_are_told() {
    let scene = Scene::new(40, 2000);
    let mut options = options(1);
    options.engine.restarts = 0;
    let refused = with_engine(&[0, 1], NodeIs::Machine, &options, |engine, place| {
        let on_result = |scenario| {
            if scenario == 20 {
                place.workers().into_iter().for_each(kill);
            }
            Ok(())
        };
        let mut recorder = Recorder::new(on_result);
        scene.run_on(engine, &options, &mut recorder, &GO_ON).unwrap_err()
    });
    assert!(matches!(refused, EngineError::AllWorkersDied { .. }), "{refused}");
    assert!(refused.to_string().contains("SIGKILL"), "{refused}");
}

/// More pairs of roots than a worker's queue has room for.
#[test]
fn a_batch_too_long_for_a_queue_arrives_whole() {
    let mut scene = Scene::new(20, 1);
    scene.moving = Arc::clone(&scene.fixed);
    scene.poses = vec![bumper::geometry::Pose::IDENTITY; 5];
    let mut options = options(1);
    options.engine.buffer_scenarios = NonZeroU32::MIN;
    options.cuts = [Cut::Triangles(1); 2];
    let (report, answers) = run(&scene, &[0, 1], NodeIs::Machine, &options);
    assert!(answers == scene.truth());
    let batches = &report.workers[1];
    assert!(batches.message_bytes > 0 && batches.scenarios > 0);
    let pairs_bytes = report.nodes[1].link_bytes_sent - report.nodes[1].geometry_bytes_copied;
    let limit = bumper::wire::Job::batch_bytes(1, 2048) as u64;
    assert!(pairs_bytes > u64::from(batches.scenarios) * limit, "no batch was too long");
}

#[test]
fn an_engine_over_nodes_takes_one_run_after_the_other() {
    let (small, large) = (Scene::new(12, 30), Scene::new(30, 50));
    with_engine(&[0, 1, 1], NodeIs::Machine, &options(1), |engine, _| {
        for scene in [&small, &large, &small] {
            let mut recorder = Recorder::new(|_| Ok(()));
            let report = scene.run_on(engine, &options(1), &mut recorder, &GO_ON).unwrap();
            assert!(recorder.answers == scene.truth());
            assert!(report.nodes[1].relative_data_transfer < 1.2);
        }
    });
}
