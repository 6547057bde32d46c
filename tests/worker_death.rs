//! Workers and masters that are killed: nothing is lost, nothing is doubled, nothing stays behind.

mod engine_run;

use std::io;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use bumper::scheduler::client_manager::EngineError;
use engine_run::{Place, Scene, in_role, kill, options, role, shared_memory_files};

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
        let died = report.unwrap().workers.iter().filter(|worker| worker.died).count();
        // At the end it may have had nothing left to do.
        assert!(died == 1 || moment == 290, "{died} died at {moment}");
    }
}

#[test]
fn all_but_one_killed_one_after_the_other_lose_no_scenario() {
    let scene = Scene::new(40, 300);
    let place = Place::new();
    let (report, answers) = place.run(&scene, &options(4), &GO_ON, |scenario| {
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
    let (report, answers) = place.run(&scene, &options(3), &GO_ON, |scenario| {
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
    use bumper::scheduler::client_manager::{Work, needs, run_over};
    use bumper::transport::shared_memory::SharedMemory;
    let work = Work { fixed: scene.fixed.view(), moving: scene.moving.view(), poses: &scene.poses };
    let options = options(2);
    let transport = SharedMemory::create(base.as_ref(), &needs(&work, &options)).unwrap();
    let mut recorder = engine_run::Recorder {
        answers: Vec::new(),
        on_result: |_| -> io::Result<()> {
            std::fs::write(format!("{base}/answering"), "")?;
            std::thread::sleep(PATIENCE);
            Err(io::Error::other("nobody has killed this master"))
        },
    };
    run_over(transport, work, &options, &mut recorder, &GO_ON).unwrap();
}
