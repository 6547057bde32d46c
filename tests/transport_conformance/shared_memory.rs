//! What only shared memory has to keep: room, files, pages.

use std::os::unix::fs::MetadataExt;
use std::path::Path;

use bumper::transport::{MasterEnd, Needs, SharedGeometry, TransportError, WakeUp};

use crate::roles::{Role, digest, needs};
use crate::transports::{OverSharedMemory, Transport};
use crate::{Scene, bytes, worker};

fn names(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// Names of what the runs below `base` have in shared memory and in the file system.
fn remains(base: &Path) -> Vec<String> {
    let Some(home) = names(base).into_iter().find(|name| name.starts_with("bumper-")) else {
        return Vec::new();
    };
    let mut found = names(&base.join(&home));
    found.retain(|name| name != "lock");
    let prefix = home.replace('-', "_");
    let runs: Vec<_> = found.iter().filter_map(|name| name.strip_prefix("run-")).collect();
    let prefixes: Vec<_> = runs.iter().map(|run| format!("{prefix}_{run}_")).collect();
    let files = names(Path::new("/dev/shm")).into_iter();
    let ours: Vec<_> =
        files.filter(|f| prefixes.iter().any(|prefix| f.starts_with(prefix))).collect();
    found.extend(ours);
    found
}

/// Bytes of pages that the runs below `base` have in shared memory.
fn occupied(base: &Path) -> u64 {
    let files = remains(base).into_iter().map(|name| Path::new("/dev/shm").join(name));
    files.filter_map(|file| Some(file.metadata().ok()?.blocks() * 512)).sum()
}

/// Longest mapping that a process has of a file of the runs below `base`.
fn longest_mapping(pid: u32, base: &Path) -> u64 {
    let prefixes = remains(base)
        .into_iter()
        .filter_map(|name| Some(format!("_{}_", name.strip_prefix("run-")?)));
    let prefixes: Vec<_> = prefixes.collect();
    let maps = std::fs::read_to_string(format!("/proc/{pid}/maps")).unwrap();
    let ours = maps.lines().filter(|line| prefixes.iter().any(|prefix| line.contains(prefix)));
    let lengths = ours.map(|line| {
        let (start, end) = line.split_once(' ').unwrap().0.split_once('-').unwrap();
        let address = |hex| u64::from_str_radix(hex, 16).unwrap();
        address(end) - address(start)
    });
    lengths.max().unwrap_or(0)
}

#[test]
fn promise_2_a_withdrawn_mesh_gives_its_memory_back() {
    let image = bytes(8 << 20);
    let mut scene = Scene::<OverSharedMemory>::new();
    let base = scene.directory.path().to_owned();
    let running = scene.start(0, Role::GeometryForAWhile);
    let before = occupied(&base);
    scene.master().publish(0, &image).unwrap();
    assert_eq!(scene.next(0), b"have it");
    let pid = running.pid().unwrap();
    assert!(occupied(&base) >= before + (8 << 20));
    assert!(longest_mapping(pid, &base) >= 8 << 20);

    scene.master().withdraw(0).unwrap();
    assert!(occupied(&base) < before + (1 << 20), "a file of the mesh is left");
    scene.send(0, b"look again");
    assert_eq!(scene.collect(0, 2), [&digest(&image)[..], b"had it"]);
    for pid in [pid, std::process::id()] {
        assert!(longest_mapping(pid, &base) < 8 << 20, "process {pid} keeps the mesh's pages");
    }
    scene.send(0, b"enough");
    running.finish();
}

#[test]
fn promise_4_a_message_to_an_absent_worker_is_an_error() {
    let mut scene = Scene::<OverSharedMemory>::new();
    scene.master().open(worker(0)).unwrap();
    let refused = scene.master().send(worker(0), &[b"anybody?"]);
    assert!(matches!(refused, Err(TransportError::NotDelivered(_))));
}

#[test]
fn promise_8_no_room_is_an_error_before_anything_is_made() {
    let base = tempfile::tempdir().unwrap();
    let needs = Needs { job_bytes: 1 << 50, ..needs(WakeUp::Block) };
    let refused = OverSharedMemory::master(base.path(), &needs).expect_err("a pebibyte of room");
    let TransportError::NoRoom { needed, free, .. } = refused else { panic!("{refused}") };
    assert!(needed > 1 << 50 && free < 1 << 50);
    assert_eq!(remains(base.path()), [""; 0]);
}

#[test]
fn promise_9_nothing_remains_with_workers_in_any_state() {
    let mut scene = Scene::<OverSharedMemory>::new();
    let base = scene.directory.path().to_owned();
    scene.master().publish(0, &bytes(64 * 100)).unwrap();
    let [absent, crashed, leaving] = [0, 1, 2];
    scene.master().open(worker(absent)).unwrap();
    let dying = scene.start(crashed, Role::LastWords);
    scene.master().wait(&[], crate::roles::FOREVER).unwrap();
    dying.kill();
    let running = scene.start_and_meet(leaving, Role::Echo);
    scene.send(leaving, b"");
    running.finish();
    assert_ne!(remains(&base), [""; 0]);
    scene.master = None;
    assert_eq!(remains(&base), [""; 0]);
}

/// Otherwise every death would cost memory until the run ends.
#[test]
fn promise_9_a_closed_channel_leaves_no_memory_behind() {
    let mut scene = Scene::<OverSharedMemory>::new();
    let base = scene.directory.path().to_owned();
    let before = occupied(&base);
    for slot in 0..3 {
        let running = scene.start_and_meet(slot, Role::Deaf);
        running.kill();
        scene.master().close(worker(slot), &mut |_| {}).unwrap();
    }
    // A service's list of its ports is all that stays.
    let left = (occupied(&base) - before) / 3;
    assert!(left < 64 << 10, "{left} bytes a worker: {:?}", remains(&base));
}
