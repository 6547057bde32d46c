//! Master and worker processes together, on a scene that was answered without them.

mod engine_run;

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use bumper::scheduler::client_manager::EngineError;
use bumper::transport::TransportError;
use bumper::transport::shared_memory::SharedMemory;
use engine_run::{Place, Scene, in_role, options, role};

static GO_ON: AtomicBool = AtomicBool::new(false);

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
    without_pairs.send_pairs = false;
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
    scene.moving = scene.fixed.clone();
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
    let report = report.unwrap();
    assert_eq!((report.completed, report.workers.len()), (2, 2), "none without work");
    assert_eq!(answers, scene.truth());
    scene.poses.clear();
    let (report, answers) = Place::new().run(&scene, &options(2), &GO_ON, |_| Ok(()));
    let report = report.unwrap();
    assert_eq!((report.completed, report.workers.len(), answers.len()), (0, 0, 0));
    assert_eq!(report.bytes_published, 0, "nothing is done for nobody");
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

#[test]
fn a_program_that_is_no_worker_ends_the_run_with_its_words() {
    let scene = Scene::new(10, 10);
    let mut wrong = options(2);
    wrong.worker_program = "/bin/ls".into();
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
    missing.worker_program = "/no/such/program".into();
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
        let needs = bumper::transport::Needs {
            images: vec![8 << 20, 1 << 20],
            workers: 2,
            job_bytes: 2000,
        };
        let refused = SharedMemory::create(place.base(), &needs).unwrap_err();
        assert!(matches!(refused, TransportError::NoRoom { .. }), "{refused}");
        assert!(refused.to_string().contains("--shm-size"), "{refused}");
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
