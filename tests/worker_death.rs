//! Workers and masters that are killed: nothing is lost, nothing is doubled, nothing stays behind.

mod engine_run;

use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bumper::geometry::Pose;
use bumper::mesh::TriangleMesh;
use bumper::scene::{Compression, MatchRule, SubtreesFrom, Transport};
use bumper::scheduler::client_manager::{EngineError, start};
use bumper::tree::roots::Cut;
use bumper::tree::{BuildOptions, TreeKind, build};
use engine_run::{
    Options, Place, Recorder, Scene, in_role, kill, options, role, shared_memory_files, signal,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

static GO_ON: AtomicBool = AtomicBool::new(false);
const PATIENCE: Duration = Duration::from_secs(60);

fn until(what: &str, mut reached: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !reached() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn killed_worker_loses_no_scenario() {
    let scene = Scene::new(40, 300);
    let truth = scene.truth();
    // At the first result, in the middle, and near the end, when tasks are small.
    for moment in [0, 150, 290] {
        let place = Place::new();
        let (report, answers) = place.run(&scene, &options(3), &GO_ON, |scenario| {
            if scenario == moment {
                kill(*place.workers().first().unwrap());
            }
            Ok(())
        });
        assert!(answers == truth, "killed at {moment}: {} answers", answers.len());
        let report = report.unwrap();
        let died = report.workers.iter().filter(|worker| worker.died).count();
        let restarts: u32 = report.workers.iter().map(|worker| worker.restarts).sum();
        // At the end it may have had nothing left to do.
        assert!((died, restarts) == (1, 1) || moment == 290, "{died} died at {moment}");
    }
}

#[test]
fn all_but_one_killed_one_after_the_other_lose_no_scenario() {
    let scene = Scene::new(40, 300);
    let place = Place::new();
    let mut options = options(4);
    options.engine.restarts = 0;
    let (report, answers) = place.run(&scene, &options, &GO_ON, |scenario| {
        if [30, 60, 90].contains(&scenario) {
            kill(*place.workers().last().unwrap());
        }
        Ok(())
    });
    assert!(answers == scene.truth());
    assert_eq!(report.unwrap().workers.iter().filter(|worker| worker.died).count(), 3);
}

/// At any moment between the start of its process and its first task.
#[test]
fn a_worker_killed_while_it_starts_loses_no_scenario() {
    let scene = Scene::new(40, 60);
    let truth = scene.truth();
    for delay in [0, 1, 2, 4, 8] {
        let place = Place::new();
        let (report, answers) = std::thread::scope(|scope| {
            scope.spawn(|| {
                until("no worker has come", || !place.workers().is_empty());
                std::thread::sleep(Duration::from_millis(delay));
                if let Some(&pid) = place.workers().first() {
                    kill(pid);
                }
            });
            place.run(&scene, &options(2), &GO_ON, |_| Ok(()))
        });
        report.unwrap();
        assert!(answers == truth, "killed after {delay} ms: {} answers", answers.len());
    }
}

#[test]
fn when_all_workers_are_dead_the_run_ends_clearly_and_keeps_what_is_done() {
    let scene = Scene::new(40, 2000);
    let place = Place::new();
    let mut options = options(3);
    options.engine.restarts = 0;
    let (report, answers) = place.run(&scene, &options, &GO_ON, |scenario| {
        if scenario == 50 {
            place.workers().into_iter().for_each(kill);
        }
        Ok(())
    });
    let refused = report.unwrap_err();
    assert!(
        matches!(refused, EngineError::AllWorkersDied { completed, .. } if completed as usize == answers.len()),
        "{refused}"
    );
    assert!(refused.to_string().contains("SIGKILL"), "{refused}");
    assert!(answers.len() > 50 && answers == scene.truth()[..answers.len()]);
}

/// The run of another process, which is killed in the middle of it.
#[test]
fn a_killed_master_leaves_no_worker_and_the_next_run_removes_its_files() {
    const TEST: &str = "a_killed_master_leaves_no_worker_and_the_next_run_removes_its_files";
    let scene = Scene::new(20, 50);
    if let Some(base) = role() {
        run_until_killed(&scene, &base);
        return;
    }
    let place = Place::new();
    let mut master = in_role(TEST, place.base().to_str().unwrap()).spawn().unwrap();
    until("the master has not answered anything", || place.base().join("answering").exists());
    std::fs::remove_file(place.base().join("answering")).unwrap();
    let prefixes = place.prefixes();
    assert_eq!((place.workers().len(), prefixes.len()), (2, 1));

    master.kill().unwrap();
    master.wait().unwrap();
    until("workers outlive their master", || place.workers().is_empty());

    assert!(!shared_memory_files(&prefixes).is_empty(), "nothing was left to be removed");
    let (report, answers) = place.run(&scene, &options(1), &GO_ON, |_| Ok(()));
    report.unwrap();
    assert!(answers == scene.truth());
    assert_eq!(shared_memory_files(&prefixes), [""; 0]);
}

fn run_until_killed(scene: &Scene, base: &str) {
    let on_result = |_| -> io::Result<()> {
        std::fs::write(format!("{base}/answering"), "")?;
        std::thread::sleep(PATIENCE);
        Err(io::Error::other("nobody has killed this master"))
    };
    let (report, _) = Place::at(base.as_ref()).run(scene, &options(2), &GO_ON, on_result);
    report.unwrap();
}

/// Every worker at once, and again as soon as others have come.
#[test]
fn all_workers_killed_again_and_again_are_started_again_and_lose_no_scenario() {
    let scene = Scene::new(40, 200);
    let place = Place::new();
    let (report, answers) = place.run(&scene, &options(2), &GO_ON, |scenario| {
        if scenario % 50 == 20 {
            place.workers().into_iter().for_each(kill);
        }
        Ok(())
    });
    assert!(answers == scene.truth());
    let restarts: u32 = report.unwrap().workers.iter().map(|worker| worker.restarts).sum();
    assert!(restarts >= 4, "{restarts} restarts");
}

/// Stopped, not killed: it answers nothing and does not die.
#[test]
fn a_worker_that_hangs_is_noticed_and_replaced() {
    let scene = Scene::new(40, 200);
    let place = Place::new();
    let mut options = options(2);
    options.engine.patience = Duration::from_millis(500);
    let (report, answers) = place.run(&scene, &options, &GO_ON, |scenario| {
        if scenario == 40 {
            signal(*place.workers().first().unwrap(), "-STOP");
        }
        Ok(())
    });
    assert!(answers == scene.truth());
    assert_eq!(report.unwrap().workers.iter().map(|worker| worker.restarts).sum::<u32>(), 1);
}

/// Three thousand triangles in one place touch three thousand others: more pairs than the workers are
/// allowed memory for. They abort, as they would on a machine that is too small.
#[test]
fn a_scenario_that_kills_three_workers_is_set_aside_and_the_rest_goes_on() {
    let mut scene = Scene::new(20, 60);
    let corners = [[9.0, 0.0, 0.0], [9.1, 0.0, 0.0], [9.0, 0.1, 0.0]].to_vec();
    let pile = TriangleMesh::new(corners, vec![[0, 1, 2]; 3000]).unwrap();
    let pile = build(&pile, BuildOptions { kind: TreeKind::Wide });
    (scene.fixed, scene.moving) = (Arc::new(pile.clone()), Arc::new(pile));
    for (number, pose) in scene.poses.iter_mut().enumerate() {
        let away = if number == 33 { 0.0 } else { 1.0 + number as f64 };
        *pose = Pose::from_quaternion([1.0, 0.0, 0.0, 0.0], [away, 0.0, 0.0]);
    }
    let directory = tempfile::tempdir().unwrap();
    let program = directory.path().join("small-worker");
    let script =
        format!("#!/bin/sh\nulimit -v 60000\nexec {} \"$@\"\n", env!("CARGO_BIN_EXE_bumper"));
    std::fs::write(&program, script).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o700)).unwrap();
    for transport in [Transport::Iceoryx2, Transport::Pipe] {
        let mut options = options(2);
        options.engine.transport = transport;
        options.wanted.pairs = 0;
        options.program = program.clone();
        let mut recorder = Recorder::new(|_| Ok(()));
        let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
        let report = scene.run_on(&mut *engine, &options, &mut recorder, &GO_ON).unwrap();
        assert_eq!((report.set_aside, recorder.set_aside), (vec![33], vec![33]));
        assert_eq!(report.completed, 59);
        let answered: Vec<u32> = recorder.answers.iter().map(|answer| answer.0).collect();
        assert!(answered.into_iter().eq((0..60).filter(|&scenario| scenario != 33)));
        assert_eq!(report.workers.iter().map(|worker| worker.restarts).sum::<u32>(), 3);
    }
}

/// Says so when it goes, also if that is because of a panic.
struct TellsEnd<'a>(&'a AtomicBool);

impl Drop for TellsEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Named for one run alone, so that its workers can be told from others.
fn program_of_its_own() -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let program = directory.path().join("bumper");
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_bumper"), &program).unwrap();
    (directory, program)
}

/// With subtrees from other workers all the time: a scenario goes to who has the least of it.
fn exchanging(transport: Transport, workers: u32) -> Options {
    let mut options = options(workers);
    options.engine.transport = transport;
    options.engine.subtrees_from = SubtreesFrom::Workers;
    options.engine.matchmaker = MatchRule::Lowest;
    options.engine.buffer_scenarios = 2.try_into().unwrap();
    options.cuts = [Cut::Depth(8); 2];
    options
}

#[test]
fn a_worker_that_others_fetch_from_is_killed_and_no_scenario_is_lost() {
    let scene = Scene::new(60, 300);
    let truth = scene.truth();
    for transport in [Transport::Pipe, Transport::Socket] {
        let mut options = exchanging(transport, 3);
        let (_directory, program) = program_of_its_own();
        options.program = program;
        let place = Place::at(&options.program);
        let mut recorder = Recorder::new(|scenario| {
            if [20, 60, 100].contains(&scenario) {
                kill(*place.workers().first().unwrap());
            }
            Ok(())
        });
        let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
        let report = scene.run_on(&mut *engine, &options, &mut recorder, &GO_ON).unwrap();
        assert!(recorder.answers == truth, "{transport:?}");
        assert!(report.transfer.bytes_from_workers > 0, "{transport:?}");
        assert_eq!(report.workers.iter().map(|worker| worker.restarts).sum::<u32>(), 3);
    }
}

/// It has what the other one lacks, and answers nobody.
#[test]
fn a_worker_that_others_fetch_from_is_stopped_and_the_master_sends_what_it_has() {
    let scene = Scene::new(60, 300);
    let mut options = exchanging(Transport::Pipe, 2);
    options.engine.patience = Duration::from_secs(2);
    let (_directory, program) = program_of_its_own();
    options.program = program;
    let place = Place::at(&options.program);
    let mut recorder = Recorder::new(|scenario| {
        if scenario == 10 {
            signal(*place.workers().first().unwrap(), "-STOP");
        }
        Ok(())
    });
    let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
    let report = scene.run_on(&mut *engine, &options, &mut recorder, &GO_ON).unwrap();
    assert!(recorder.answers == scene.truth());
    assert!(report.transfer.not_fetched > 0, "nobody has fetched from it");
    assert_eq!(report.workers.iter().map(|worker| worker.restarts).sum::<u32>(), 1);
}

/// Runs one after the other while so many workers are killed at random moments.
fn chaos(mut options: Options, kills: u32, seed: u64) {
    let transport = options.engine.transport;
    let scene = Scene::new(40, 20 * kills);
    let truth = scene.truth();
    options.engine.restarts = 100_000;
    let (_directory, program) = program_of_its_own();
    options.program = program;
    let place = Place::at(&options.program);
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let is_over = AtomicBool::new(false);
    let killed = std::thread::scope(|scope| {
        let killer = scope.spawn(|| {
            let mut killed = 0;
            while killed < kills && !is_over.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_micros(generator.next_u64() % 20_000));
                let workers: Vec<u32> = place.workers().into_iter().collect();
                let victim = workers.get((generator.next_u64() % 3) as usize);
                killed += u32::from(victim.is_some_and(|&pid| signal(pid, "-KILL")));
            }
            killed
        });
        let _end = TellsEnd(&is_over);
        let mut engine = start(options.engine.clone(), options.program.clone()).unwrap();
        while !killer.is_finished() {
            let mut recorder = Recorder::new(|_| Ok(()));
            let run = scene.run_on(&mut *engine, &options, &mut recorder, &GO_ON);
            assert!(run.unwrap().set_aside.is_empty(), "{transport:?}, seed {seed}");
            assert!(recorder.answers == truth, "{transport:?}, seed {seed}");
        }
        killer.join().unwrap()
    });
    assert_eq!(killed, kills);
}

fn every_way_to_have_geometry() -> impl Iterator<Item = Options> {
    let plain = [Transport::Iceoryx2, Transport::Pipe, Transport::Socket].map(|transport| {
        let mut options = options(3);
        options.engine.transport = transport;
        options
    });
    let mut packed = exchanging(Transport::Pipe, 3);
    packed.engine.compress = Compression::Lz4;
    plain.into_iter().chain([packed, exchanging(Transport::Socket, 3)])
}

#[test]
fn dozens_of_kills_at_random_moments_change_no_answer() {
    every_way_to_have_geometry().for_each(|options| chaos(options, 30, 1));
}

#[test]
fn hundreds_of_kills_at_random_moments_change_no_answer() {
    if std::env::var_os("BUMPER_LONG_TESTS").is_none() {
        eprintln!("skipped: set BUMPER_LONG_TESTS=1 for the long form");
        return;
    }
    for seed in 2..5 {
        every_way_to_have_geometry().for_each(|options| chaos(options, 300, seed));
    }
}
