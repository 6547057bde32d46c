//! Ctrl-C: nothing is lost, nothing is left.

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

use super::*;

/// A run that has many poses to go.
fn long_run(place: &Place) -> Child {
    let poses =
        place.write("long.csv", &format!("{HEADER}{}", "1,0,0,0,0.5,0,0\n".repeat(300_000)));
    let out = place.text("out");
    let arguments = [
        "run",
        "--fixed",
        TRACKED,
        "--moving",
        CAR,
        "--poses",
        &poses,
        "--workers",
        "2",
        "--out",
        &out,
        "--contacts",
    ];
    start(place, &arguments)
}

/// A process group of its own, as a terminal starts it.
pub fn start(place: &Place, arguments: &[&str]) -> Child {
    let mut command = place.bumper(arguments);
    command.process_group(0).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Ctrl-C in that terminal.
pub fn interrupt(child: Child) -> Output {
    // SAFETY: sends a signal to the group of a child that has not been waited for.
    unsafe { libc::kill(-i32::try_from(child.id()).unwrap(), libc::SIGINT) };
    child.wait_with_output().unwrap()
}

pub fn wait_until(child: &mut Child, mut happened: impl FnMut() -> bool) {
    let start = Instant::now();
    while !happened() {
        assert_eq!(child.try_wait().unwrap(), None, "ended before it was interrupted");
        assert!(start.elapsed() < Duration::from_secs(60), "nothing happened");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Waits until the run has written some rows.
pub fn await_rows(child: &mut Child, csv: &Path) {
    wait_until(child, || fs::read_to_string(csv).map_or(0, |text| text.lines().count()) >= 50);
}

pub fn children(pid: u32) -> Vec<u32> {
    let text = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap();
    text.split_whitespace().map(|pid| pid.parse().unwrap()).collect()
}

/// Names in shared memory of the runs below a runtime directory.
pub fn shared_memory_of(runtime: &Path) -> Vec<String> {
    let entries = |path: &Path| -> Vec<String> {
        let names = fs::read_dir(path).into_iter().flatten();
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    };
    let homes = entries(runtime).into_iter().map(|home| runtime.join(home));
    let runs = homes.flat_map(|home| entries(&home));
    let ids: Vec<String> =
        runs.filter_map(|run| run.strip_prefix("run-").map(str::to_owned)).collect();
    let shared = entries(Path::new("/dev/shm")).into_iter();
    shared.filter(|name| ids.iter().any(|id| name.contains(id.as_str()))).collect()
}

#[test]
fn ctrl_c_keeps_the_results_and_leaves_nothing_running() {
    let place = Place::new();
    let mut child = long_run(&place);
    await_rows(&mut child, &place.path("out/scenarios.csv"));
    let workers = children(child.id());
    let shared = shared_memory_of(&place.path("runtime"));
    assert_eq!(workers.len(), 2);
    assert!(!shared.is_empty(), "shared memory is in use");

    let output = interrupt(child);
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).contains("of 300000 scenarios were answered"), "{}", stderr(&output));

    let summary = json(&place.path("out/summary.json"));
    assert_eq!(summary["interrupted"], true);
    let rows = scenarios(&place.path("out/scenarios.csv"));
    assert!(rows.len() >= 50 && rows.len() < 300_000);
    assert_eq!(summary["scenarios"], rows.len());
    assert!(rows.iter().enumerate().all(|(number, row)| row.0 as usize == number), "no gap");
    agree(&place.path("out"));
    for worker in workers {
        assert!(!Path::new(&format!("/proc/{worker}")).exists(), "worker {worker} is left");
    }
    for name in shared {
        assert!(!Path::new("/dev/shm").join(&name).exists(), "{name} is left");
    }
}

#[test]
fn ctrl_c_before_the_first_scenario_writes_nothing() {
    let place = Place::new();
    let out = place.text("out");
    let arguments = ["run", "--fixed", CAR, "--moving", CAR, "--count", "4000000", "--out", &out];
    let mut child = start(&place, &arguments);
    // The placing of four million scenarios takes minutes: the trees are in the cache before it.
    let cache = place.path("cache/bumper");
    wait_until(&mut child, || fs::read_dir(&cache).map_or(0, Iterator::count) > 0);
    let output = interrupt(child);
    assert_eq!(output.status.code(), Some(130));
    assert!(stderr(&output).contains("nothing was written"), "{}", stderr(&output));
    assert!(!place.path("out/scenarios.csv").exists());
}
