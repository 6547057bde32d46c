//! What is sent of the geometry where workers do not see it, by whom, and in how many bytes.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bumper::scene::{Compression, MatchRule, SubtreesFrom, Transport};
use bumper::scheduler::client_manager::{EngineReport, Work, start};
use bumper::tree::roots::Cut;

use crate::engine_run::{Recorder, Scene, options};

fn message_bytes(report: &EngineReport) -> u64 {
    report.workers.iter().map(|worker| worker.message_bytes).sum()
}

#[test]
fn compressed_subtrees_are_fewer_bytes_and_counted_as_they_are_sent() {
    let scene = Scene::new(60, 100);
    for transport in [Transport::Pipe, Transport::Socket] {
        let run = |compress| {
            let mut options = options(1);
            (options.engine.transport, options.engine.compress) = (transport, compress);
            scene.run(&options).0
        };
        let (plain, packed) = (run(Compression::None), run(Compression::Lz4));
        let [before, after] = [packed.transfer.bytes_plain, packed.transfer.bytes_packed];
        assert!(after < before, "{before} to {after}");
        assert_eq!((plain.transfer.bytes_plain, plain.transfer.bytes_packed), (before, before));
        assert!(packed.bytes_sent <= after && packed.bytes_sent > after / 2);
        assert!(packed.relative_data_transfer < plain.relative_data_transfer);
        // One worker is sent the same subtrees, whatever the batches.
        assert!(message_bytes(&packed) < message_bytes(&plain));
    }
}

/// Whoever is sent a scenario has little of what it needs, and others have it.
#[test]
fn subtrees_that_workers_have_from_each_other_the_master_does_not_send() {
    let scene = Scene::new(60, 400);
    let truth = scene.truth();
    for (transport, compress) in
        [Transport::Pipe, Transport::Socket].into_iter().zip(Compression::ALL)
    {
        let mut options = options(4);
        (options.engine.transport, options.engine.compress) = (transport, compress);
        options.engine.matchmaker = MatchRule::Lowest;
        options.engine.buffer_scenarios = 2.try_into().unwrap();
        options.cuts = [Cut::Depth(8); 2];
        let (alone, _) = scene.run(&options);
        options.engine.subtrees_from = SubtreesFrom::Workers;
        let (shared, answers) = scene.run(&options);
        assert!(answers == truth, "{transport:?}");
        assert_eq!(shared.transfer.subtrees_from, SubtreesFrom::Workers);
        let from_workers = shared.transfer.bytes_from_workers;
        let each: u64 = shared.workers.iter().map(|worker| worker.bytes_from_workers).sum();
        assert_eq!((each, shared.transfer.not_fetched), (from_workers, 0), "{transport:?}");
        assert_eq!(alone.transfer.bytes_from_workers, 0, "{transport:?}");
        let bytes = [alone.bytes_sent, shared.bytes_sent, from_workers];
        println!("{transport:?}, {compress:?}: alone, shared, from workers {bytes:?}");
        // All of it comes to each of the four; how soon it is certain who has what is a matter of time.
        assert!(4 * shared.bytes_sent < 3 * alone.bytes_sent, "{transport:?}: {bytes:?}");
        assert!(from_workers > alone.bytes_sent / 4, "{transport:?}: {bytes:?}");
        assert!(message_bytes(&shared) < message_bytes(&alone), "{transport:?}");
    }
}

/// The same scenario again and again goes to the worker that has the least of it.
#[test]
fn what_a_worker_was_sent_in_one_run_others_fetch_from_it_in_another() {
    let scene = Scene::new(40, 2);
    let mut options = options(2);
    options.engine.transport = Transport::Socket;
    options.engine.subtrees_from = SubtreesFrom::Workers;
    options.engine.matchmaker = MatchRule::Lowest;
    let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
    let fixed = engine.add_mesh(Arc::clone(&scene.fixed)).unwrap();
    let moving = engine.add_mesh(Arc::clone(&scene.moving)).unwrap();
    let work = Work {
        effects: None,
        fixed: (fixed, options.cuts[0]),
        moving: (moving, options.cuts[1]),
        poses: &scene.poses[..1],
        wanted: options.wanted,
    };
    let truth = &scene.truth()[..1];
    let mut run = || {
        let mut recorder = Recorder::new(|_| Ok(()));
        let report = engine.run(&work, &mut recorder, &AtomicBool::new(false)).unwrap();
        assert!(recorder.answers == truth);
        (report.bytes_sent, report.transfer.bytes_from_workers)
    };
    let (sent, fetched) = run();
    assert!(sent > 0 && fetched == 0);
    // The other one may have to be started first.
    let second = std::iter::repeat_with(run).find(|&bytes| bytes != (0, 0));
    assert_eq!(second, Some((0, sent)));
}
