//! Master and worker processes together, on a scene that was answered without them.

mod engine_run;
mod engine_transfer;
mod over_ranks;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bumper::effects::contacts::pairs_fnv1a64;
use bumper::scene::{Compression, MatchRule, Slowdown, StartFrom, SubtreesFrom, Transport};
use bumper::scheduler::client_manager::{EngineError, start};
use bumper::transport::shared_memory::SharedMemory;
use bumper::transport::{Needs, SharedGeometry, TransportError, WakeUp};
use bumper::tree::roots::Cut;
use engine_run::{Answer, Place, Recorder, Scene, in_role, options, role};

static GO_ON: AtomicBool = AtomicBool::new(false);

/// Of the answers to a scene of 24 rings and 60 scenarios.
const PINNED: u64 = 10_601_659_803_654_420_381;

#[test]
fn any_number_of_workers_gives_the_same_answers() {
    let scene = Scene::new(40, 150);
    let truth = scene.truth();
    let colliding = truth.iter().filter(|(_, pairs, ..)| *pairs > 0).count();
    assert!((20..130).contains(&colliding), "{colliding} scenarios collide");
    for workers in 1..=4 {
        let (report, answers) = Place::new().run(&scene, &options(workers), &GO_ON, |_| Ok(()));
        let report = report.unwrap();
        assert!(answers == truth, "{workers} workers differ");
        assert_eq!((report.completed, report.interrupted), (150, false));
        assert_eq!(report.workers.len(), workers as usize);
        assert_eq!(report.workers.iter().map(|w| w.scenarios).sum::<u32>(), 150);
        assert!(report.workers.iter().all(|w| !w.died && w.geometry_bytes_copied == 0));
        assert!(workers > 1 || report.pre_analysis_s == 0.0, "there is nothing to choose");
    }
}

#[test]
fn counts_and_hashes_come_without_pairs_and_cost_fewer_bytes() {
    let scene = Scene::new(40, 60);
    let with_pairs = options(2);
    let mut without_pairs = options(2);
    without_pairs.wanted.pairs = 0;
    let (full, full_answers) = Place::new().run(&scene, &with_pairs, &GO_ON, |_| Ok(()));
    let (bare, bare_answers) = Place::new().run(&scene, &without_pairs, &GO_ON, |_| Ok(()));
    for (full, bare) in full_answers.iter().zip(&bare_answers) {
        assert_eq!((full.0, full.1, full.2), (bare.0, bare.1, bare.2));
        assert!(bare.3.is_empty());
    }
    assert_eq!(full_answers.len(), bare_answers.len());
    let bytes = |report: Result<_, EngineError>| -> u64 {
        let report: bumper::scheduler::client_manager::EngineReport = report.unwrap();
        report.workers.iter().map(|worker| worker.message_bytes).sum()
    };
    let pairs: u64 = full_answers.iter().map(|answer| u64::from(answer.1)).sum();
    // Headers of batches, at most one a scenario: how many there are is a matter of time.
    let headers = 128 * full_answers.len() as u64;
    assert!(8 * pairs > 2 * headers, "{pairs} pairs");
    assert!(bytes(full) + headers >= bytes(bare) + 8 * pairs);
}

/// More pairs than one message holds.
#[test]
fn answers_longer_than_a_message_arrive_whole() {
    let mut scene = Scene::new(90, 1);
    scene.moving = Arc::clone(&scene.fixed);
    scene.poses = vec![bumper::geometry::Pose::IDENTITY; 3];
    let (report, answers) = Place::new().run(&scene, &options(2), &GO_ON, |_| Ok(()));
    report.unwrap();
    assert!(answers[0].1 as usize * 8 > 3 * bumper::transport::REPLY_BYTES);
    assert!(answers == scene.truth());
}

#[test]
fn fewer_scenarios_than_workers_and_none_at_all() {
    let mut scene = Scene::new(10, 2);
    let (report, answers) = Place::new().run(&scene, &options(3), &GO_ON, |_| Ok(()));
    assert_eq!(report.unwrap().completed, 2);
    assert_eq!(answers, scene.truth());
    scene.poses.clear();
    let (report, answers) = Place::new().run(&scene, &options(2), &GO_ON, |_| Ok(()));
    assert_eq!((report.unwrap().completed, answers.len()), (0, 0));
}

/// One hash for all: of scenarios, counts and hashes, in their order.
#[test]
fn every_transport_matchmaker_and_number_of_workers_gives_the_pinned_answers() {
    let scene = Scene::new(24, 60);
    let hash_of = |answers: &[Answer]| {
        let words =
            answers.iter().map(|&(scenario, count, hash, _)| [scenario, count, hash as u32]);
        pairs_fnv1a64(&words.flat_map(|[s, c, h]| [[s, c], [s, h]]).collect::<Vec<_>>())
    };
    assert_eq!(hash_of(&scene.truth()), PINNED, "the truth has changed");
    for transport in Transport::ALL {
        for (compress, subtrees_from) in ways_to_send() {
            for (matchmaker, workers) in
                MatchRule::ALL.into_iter().flat_map(|rule| (1..=4).map(move |n| (rule, n)))
            {
                let mut options = options(workers);
                (options.engine.transport, options.engine.matchmaker) = (transport, matchmaker);
                (options.engine.compress, options.engine.subtrees_from) = (compress, subtrees_from);
                let what = format!("{:?}", options.engine);
                let is_plain = (compress, subtrees_from) == Default::default();
                if transport.has_geometry_in_place() && !is_plain {
                    let refused = start(options.engine, options.program).err().expect(&what);
                    assert!(matches!(refused, EngineError::NothingSent(_)), "{refused}");
                    continue;
                }
                let (report, answers) = scene.run(&options);
                assert_eq!(hash_of(&answers), PINNED, "{what}");
                assert_eq!(report.completed, 60, "{what}");
                let transfer = report.transfer;
                assert_eq!(transfer.not_fetched, 0, "{what}");
                assert!(workers > 1 || transfer.bytes_from_workers == 0, "{what}");
            }
        }
    }
}

fn ways_to_send() -> impl Iterator<Item = (Compression, SubtreesFrom)> {
    let from = |compress| SubtreesFrom::ALL.into_iter().map(move |from| (compress, from));
    Compression::ALL.into_iter().flat_map(from)
}

#[test]
fn workers_that_start_from_root_pairs_give_the_same_answers() {
    let scene = Scene::new(40, 100);
    let truth = scene.truth();
    for transport in [Transport::Iceoryx2, Transport::Threads] {
        for start_from in [StartFrom::Top, StartFrom::RootPairs] {
            let mut options = options(2);
            options.engine.transport = transport;
            options.engine.start_from = Some(start_from);
            let (report, answers) = scene.run(&options);
            assert!(answers == truth, "{transport:?} from {start_from:?}");
            assert_eq!(report.start_from, start_from);
        }
    }
    let mut options = options(1);
    options.engine.transport = Transport::Pipe;
    options.engine.start_from = Some(StartFrom::Top);
    let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
    let mut recorder = Recorder::new(|_| Ok(()));
    let refused = scene.run_on(&mut *engine, &options, &mut recorder, &GO_ON).unwrap_err();
    assert!(matches!(refused, EngineError::TopNotShared), "{refused}");
}

/// A batch that would be longer than a message is sent without its root pairs.
#[test]
fn more_root_pairs_than_a_message_holds_do_no_harm() {
    let mut scene = Scene::new(90, 1);
    scene.moving = Arc::clone(&scene.fixed);
    scene.poses = vec![bumper::geometry::Pose::IDENTITY; 2];
    let mut options = options(1);
    options.engine.buffer_scenarios = 1.try_into().unwrap();
    options.engine.start_from = Some(StartFrom::RootPairs);
    options.cuts = [Cut::Depth(14); 2];
    let (_, answers) = scene.run(&options);
    assert!(answers == scene.truth());
}

/// What is sent over a pipe is counted exactly; on shared memory nothing is.
#[test]
fn geometry_is_sent_once_to_each_worker_that_needs_it_and_only_where_it_is_not_shared() {
    let scene = Scene::new(40, 200);
    let tree_bytes = [&scene.fixed, &scene.moving].map(|tree| size_of_val(tree.blocks()) as u64);
    for transport in Transport::ALL {
        let mut options = options(2);
        options.engine.transport = transport;
        let (report, _) = scene.run(&options);
        let shares = matches!(transport, Transport::Iceoryx2 | Transport::Threads);
        let published = if shares { tree_bytes.iter().sum() } else { 0 };
        assert_eq!(report.bytes_published, published, "{transport:?}");
        let sent: u64 = report.workers.iter().map(|worker| worker.geometry_bytes_copied).sum();
        assert_eq!(report.bytes_sent, sent);
        if shares {
            assert_eq!(sent, 0, "{transport:?}");
        } else {
            assert!(sent > tree_bytes[1] / 2, "{transport:?}: {sent} bytes");
            // Vertices on the border of subtrees go with each of them.
            let most = 2 * tree_bytes.iter().sum::<u64>() * 3 / 2;
            assert!(sent < most, "{transport:?}: {sent} bytes of {tree_bytes:?}");
            let messages: u64 = report.workers.iter().map(|worker| worker.message_bytes).sum();
            assert!(messages > sent, "what is sent goes through the transport");
        }
    }
}

#[test]
fn the_best_match_sends_less_geometry_than_the_lowest() {
    let scene = Scene::new(60, 300);
    let sent = |matchmaker| {
        let mut options = options(4);
        options.engine.transport = Transport::Pipe;
        options.engine.matchmaker = matchmaker;
        options.engine.buffer_scenarios = 2.try_into().unwrap();
        options.cuts = [Cut::Depth(8); 2];
        scene.run(&options).0.bytes_sent
    };
    // How much depends on who is free when: each twice.
    let least = |matchmaker| sent(matchmaker).min(sent(matchmaker));
    let (best, lowest) = (least(MatchRule::Best), sent(MatchRule::Lowest));
    assert!(best <= lowest, "best {best}, lowest {lowest} bytes");
}

#[test]
fn a_slow_worker_gets_fewer_scenarios() {
    let scene = Scene::new(60, 600);
    for transport in [Transport::Iceoryx2, Transport::Pipe] {
        let mut options = options(2);
        options.engine.transport = transport;
        options.engine.slowdowns = vec![Slowdown::NONE, Slowdown::new(60.0).unwrap()];
        let (report, answers) = scene.run(&options);
        assert!(answers == scene.truth());
        let [fast, slow] = [0, 1].map(|worker: usize| report.workers[worker].scenarios);
        assert!(slow < fast / 2, "{transport:?}: {fast} and {slow}");
    }
}

/// Meshes come and go while the engine runs, and their memory with them.
#[test]
fn a_mesh_is_added_to_and_removed_from_a_running_engine() {
    let scenes = [Scene::new(20, 30), Scene::new(30, 30), Scene::new(25, 30)];
    for transport in Transport::ALL {
        let mut options = options(2);
        options.engine.transport = transport;
        let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
        for scene in scenes.iter().chain(&scenes) {
            let mut recorder = Recorder::new(|_| Ok(()));
            scene.run_on(&mut *engine, &options, &mut recorder, &GO_ON).unwrap();
            assert!(recorder.answers == scene.truth(), "{transport:?}");
        }
        assert_eq!(Arc::strong_count(&scenes[0].fixed), 1, "{transport:?} keeps a mesh");
        let gone = engine.add_mesh(Arc::clone(&scenes[0].fixed)).unwrap();
        engine.remove_mesh(gone).unwrap();
        let refused = engine.remove_mesh(gone).unwrap_err();
        assert!(matches!(refused, EngineError::NoMesh(_)), "{refused}");
    }
}

#[test]
fn an_interrupt_keeps_what_is_done_without_a_gap() {
    let scene = Scene::new(40, 5000);
    let interrupt = AtomicBool::new(false);
    let (report, answers) = Place::new().run(&scene, &options(2), &interrupt, |scenario| {
        interrupt.store(scenario >= 30, Ordering::Relaxed);
        Ok(())
    });
    let report = report.unwrap();
    assert!(report.interrupted);
    assert_eq!(report.completed as usize, answers.len());
    assert!((31..5000).contains(&answers.len()), "{} answers", answers.len());
    assert!(answers == scene.truth()[..answers.len()]);
}

#[test]
fn an_interrupt_before_anything_is_answered_ends_at_once() {
    let scene = Scene::new(40, 50);
    let interrupt = AtomicBool::new(true);
    let (report, answers) = Place::new().run(&scene, &options(2), &interrupt, |_| Ok(()));
    assert!(report.unwrap().interrupted);
    assert_eq!(answers.len(), 0);
}

#[test]
fn a_sink_that_cannot_write_ends_the_run_with_its_error() {
    let scene = Scene::new(20, 500);
    let (report, answers) = Place::new().run(&scene, &options(2), &GO_ON, |scenario| {
        if scenario < 40 { Ok(()) } else { Err(io::Error::other("disk full")) }
    });
    let refused = report.unwrap_err();
    assert!(matches!(refused, EngineError::Sink(_)), "{refused}");
    assert!(refused.to_string().contains("disk full"));
    assert!(answers == scene.truth()[..40]);
}

#[test]
fn an_overflowing_pose_is_named_and_everything_before_it_delivered() {
    let mut scene = Scene::new(20, 100);
    let truth = scene.truth();
    for overflowing in [70, 71, 95] {
        scene.poses[overflowing].rotation = [f64::MAX; 9];
    }
    for workers in 1..=3 {
        let (report, answers) = Place::new().run(&scene, &options(workers), &GO_ON, |_| Ok(()));
        let refused = report.unwrap_err();
        assert!(matches!(refused, EngineError::Overflow { scenario: 70, .. }), "{refused}");
        assert!(answers == truth[..70], "{} answers", answers.len());
    }
}

/// A worker that looks below some pairs of roots only, or below none, does not see every vertex.
#[test]
fn an_overflow_far_from_all_contact_is_the_same_error_wherever_workers_start() {
    let mut scene = Scene::new(20, 30);
    let truth = scene.truth();
    // Vertices with x above 1 overflow, and the rest is far above the fixed mesh.
    scene.poses[17].rotation[0] = f64::MAX;
    scene.poses[17].translation = [0.0, 0.0, 1e6];
    let mut errors = Vec::new();
    for start_from in StartFrom::ALL {
        for workers in 1..=2 {
            let mut options = options(workers);
            options.engine.start_from = Some(start_from);
            let (report, answers) = Place::new().run(&scene, &options, &GO_ON, |_| Ok(()));
            let refused = report.unwrap_err();
            assert!(matches!(refused, EngineError::Overflow { scenario: 17, .. }), "{refused}");
            assert!(answers == truth[..17], "{} answers", answers.len());
            errors.push(refused.to_string());
        }
    }
    errors.dedup();
    assert_eq!(errors.len(), 1, "{errors:?}");
}

#[test]
fn a_program_that_is_no_worker_ends_the_run_with_its_words() {
    let scene = Scene::new(10, 10);
    let mut wrong = options(2);
    wrong.engine.restarts = 1;
    wrong.program = "/bin/ls".into();
    let (report, _) = Place::new().run(&scene, &wrong, &GO_ON, |_| Ok(()));
    let refused = report.unwrap_err();
    assert!(matches!(refused, EngineError::AllWorkersDied { completed: 0, .. }), "{refused}");
    let words = refused.to_string();
    assert!(words.contains("exit status: 2") && words.contains("/bin/ls"), "{words}");
}

#[test]
fn a_program_that_does_not_exist_is_named() {
    let scene = Scene::new(10, 10);
    let mut missing = options(1);
    missing.program = "/no/such/program".into();
    let (report, _) = Place::new().run(&scene, &missing, &GO_ON, |_| Ok(()));
    let refused = report.unwrap_err().to_string();
    assert!(refused.contains("/no/such/program"), "{refused}");
}

/// In a mount namespace of its own, whose `/dev/shm` is as small as a container's may be.
#[test]
fn a_tiny_shared_memory_is_an_error_with_a_remedy_and_no_signal() {
    const TEST: &str = "a_tiny_shared_memory_is_an_error_with_a_remedy_and_no_signal";
    if role().is_some() {
        let place = Place::new();
        let needs = |workers| Needs { workers, job_bytes: 2000, wake_up: WakeUp::Block };
        let no_channels = SharedMemory::create(place.base(), &needs(20)).unwrap_err();
        let mut transport = SharedMemory::create(place.base(), &needs(0)).unwrap();
        let no_image = transport.publish(0, &vec![1; 8 << 20]).unwrap_err();
        for refused in [no_channels, no_image] {
            assert!(matches!(refused, TransportError::NoRoom { .. }), "{refused}");
            assert!(refused.to_string().contains("--shm-size"), "{refused}");
        }
        println!("refused in time");
        return;
    }
    let mount = "mount -t tmpfs -o size=2m tmpfs /dev/shm && exec \"$@\"";
    let inner = in_role(TEST, "tiny");
    let mut command = std::process::Command::new("unshare");
    command.args(["--mount", "sh", "-c", mount, "sh"]).arg(inner.get_program());
    command.args(inner.get_args()).env("BUMPER_TEST_ROLE", "tiny").env("LC_ALL", "C");
    let output = command.output().expect("util-linux has unshare");
    let words = String::from_utf8_lossy(&output.stderr);
    if words.contains("ermission denied") || words.contains("not permitted") {
        eprintln!("skipped: no right to make a mount namespace here");
        return;
    }
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("refused in time"), "{said}{words}");
}
