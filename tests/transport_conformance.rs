//! The contract of `bumper::transport`, promise by promise, held against every transport.
//!
//! The worker's end runs in a thread here: what a transport does between processes it does
//! between any two of its ends. What only a process can show (being killed) is in
//! `worker_death.rs`, and that pages are shared in `zero_copy.rs`.

use std::ffi::OsString;
use std::io::Write;
use std::os::fd::AsFd;
use std::path::Path;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use bumper::transport::shared_memory::{SharedMemory, SharedMemoryWorker};
use bumper::transport::{
    MasterEnd, Needs, QUEUED_JOBS, REPLY_BYTES, Traffic, TransportError, WorkerEnd, WorkerId,
};

/// Only waits that have failed take so long.
const FOREVER: Duration = Duration::from_secs(60);
const JOB_BYTES: usize = 1000;

/// What the suite has to know of a transport.
trait Transport {
    type Master: MasterEnd;
    type Worker: WorkerEnd;
    fn master(base: &Path, needs: &Needs) -> Result<Self::Master, TransportError>;
    fn worker(arguments: &[OsString]) -> Self::Worker;
    /// Names of what the runs below `base` have in shared memory and in the file system.
    fn remains(base: &Path) -> Vec<String>;
}

struct OverSharedMemory;

impl Transport for OverSharedMemory {
    type Master = SharedMemory;
    type Worker = SharedMemoryWorker;

    fn master(base: &Path, needs: &Needs) -> Result<SharedMemory, TransportError> {
        SharedMemory::create(base, needs)
    }

    fn worker(arguments: &[OsString]) -> SharedMemoryWorker {
        SharedMemoryWorker::attach(arguments).unwrap()
    }

    fn remains(base: &Path) -> Vec<String> {
        let home = std::fs::read_dir(base).unwrap().next().unwrap().unwrap().path();
        let mut found = names(&home);
        found.retain(|name| name != "lock");
        let prefix = home.file_name().unwrap().to_str().unwrap().replace('-', "_");
        let runs: Vec<_> = found.iter().filter_map(|name| name.strip_prefix("run-")).collect();
        let files = names(Path::new("/dev/shm")).into_iter();
        let ours: Vec<_> = files
            .filter(|f| runs.iter().any(|r| f.starts_with(&format!("{prefix}_{r}_"))))
            .collect();
        found.extend(ours);
        found
    }
}

fn names(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn worker_id(slot: u32) -> WorkerId {
    WorkerId { slot, incarnation: 0 }
}

fn needs(images: &[usize]) -> Needs {
    Needs { images: images.to_vec(), workers: 3, job_bytes: JOB_BYTES }
}

fn image(bytes: usize) -> Vec<u8> {
    (0..bytes).map(|i| (i * 7 + i / 251) as u8).collect()
}

/// Waits for the next message of `worker`.
fn next<M: MasterEnd>(master: &mut M, worker: WorkerId) -> Vec<u8> {
    let mut all = collect(master, worker, 1);
    all.remove(0)
}

fn collect<M: MasterEnd>(master: &mut M, worker: WorkerId, count: usize) -> Vec<Vec<u8>> {
    let mut messages = Vec::new();
    let deadline = Instant::now() + FOREVER;
    loop {
        master.receive(worker, &mut |message| messages.push(message.to_vec())).unwrap();
        if messages.len() >= count {
            return messages;
        }
        assert!(Instant::now() < deadline, "only {} of {count} messages came", messages.len());
        master.wait(&[], FOREVER).unwrap();
    }
}

/// A worker that greets, then returns every message, until it gets an empty one.
fn echo<T: Transport>(arguments: Vec<OsString>) -> std::thread::JoinHandle<()> {
    std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        worker.send(&[b"hello"]).unwrap();
        loop {
            let message = worker.receive().unwrap();
            assert_eq!(message.as_ptr().addr() % 8, 0);
            if message.is_empty() {
                return;
            }
            worker.send(&[&message]).unwrap();
        }
    })
}

fn promise_1_images_arrive_whole_before_and_after_attaching<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let images = [image(64 * 5000), image(64 * 3)];
    let mut master = T::master(base.path(), &needs(&[images[0].len(), images[1].len()])).unwrap();
    let arguments = master.open(worker_id(0)).unwrap();
    master.publish(0, &images[0]).unwrap();
    let expected = images.clone();
    let thread = std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        for (mesh, image) in (0..).zip(&expected) {
            let seen = worker.geometry(mesh).unwrap();
            assert_eq!(seen.as_ptr().addr() % 64, 0);
            assert!(*seen == image[..], "mesh {mesh} differs");
            worker.send(&[&mesh.to_ne_bytes()]).unwrap();
        }
    });
    // The first image was there before the worker, the second comes while it waits for it.
    assert_eq!(next(&mut master, worker_id(0)), 0_u32.to_ne_bytes());
    master.publish(1, &images[1]).unwrap();
    assert_eq!(next(&mut master, worker_id(0)), 1_u32.to_ne_bytes());
    thread.join().unwrap();
}

fn promise_2_geometry_outlives_the_master<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let image = image(64 * 2000);
    let mut master = T::master(base.path(), &needs(&[image.len()])).unwrap();
    let arguments = master.open(worker_id(0)).unwrap();
    master.publish(0, &image).unwrap();
    let (gone, master_gone) = mpsc::channel();
    let expected = image.clone();
    let thread = std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        let seen = worker.geometry(0).unwrap();
        worker.send(&[b"seen"]).unwrap();
        master_gone.recv().unwrap();
        assert!(*seen == expected[..]);
    });
    next(&mut master, worker_id(0));
    drop(master);
    gone.send(()).unwrap();
    thread.join().unwrap();
}

fn promise_3_messages_arrive_once_whole_in_order_and_at_one_worker<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    let workers = [worker_id(0), worker_id(1)];
    let threads = workers.map(|worker| echo::<T>(master.open(worker).unwrap()));
    for worker in workers {
        assert_eq!(next(&mut master, worker), b"hello");
    }
    for round in 0..200_usize {
        for worker in workers {
            let mark = [worker.slot as u8; 3];
            let body = image(1 + round * 4);
            master.send(worker, &[&mark, &body]).unwrap();
            let expected = [&mark[..], &body].concat();
            assert!(next(&mut master, worker) == expected, "round {round}, worker {worker}");
        }
    }
    for worker in workers {
        master.send(worker, &[]).unwrap();
    }
    threads.into_iter().for_each(|thread| thread.join().unwrap());
}

fn promise_3_a_flood_of_replies_loses_none<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    let arguments = master.open(worker_id(2)).unwrap();
    let thread = std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        for number in 0..500_u32 {
            worker.send(&[&number.to_ne_bytes()]).unwrap();
        }
    });
    let seen = collect(&mut master, worker_id(2), 500);
    let expected: Vec<_> = (0..500_u32).map(|number| number.to_ne_bytes().to_vec()).collect();
    assert_eq!(seen, expected);
    thread.join().unwrap();
}

fn promise_4_a_full_queue_is_an_error_and_nobody_waits<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    let arguments = master.open(worker_id(0)).unwrap();
    let (go, wait_for_go) = mpsc::channel();
    let thread = std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        worker.send(&[b"hello"]).unwrap();
        wait_for_go.recv().unwrap();
        (0..QUEUED_JOBS).map(|_| worker.receive().unwrap().to_vec()).collect::<Vec<_>>()
    });
    next(&mut master, worker_id(0));
    for number in 0..QUEUED_JOBS as u8 {
        master.send(worker_id(0), &[&[number]]).unwrap();
    }
    let refused = master.send(worker_id(0), &[b"one too many"]);
    assert!(matches!(refused, Err(TransportError::NotDelivered(w)) if w == worker_id(0)));
    go.send(()).unwrap();
    let expected: Vec<_> = (0..QUEUED_JOBS as u8).map(|number| vec![number]).collect();
    assert_eq!(thread.join().unwrap(), expected);
}

fn promise_4_a_message_to_an_absent_worker_is_an_error<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    master.open(worker_id(0)).unwrap();
    assert!(matches!(
        master.send(worker_id(0), &[b"anybody?"]),
        Err(TransportError::NotDelivered(_))
    ));
}

fn promise_5_too_long_messages_are_refused<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    let arguments = master.open(worker_id(0)).unwrap();
    let thread = std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        let longest = image(REPLY_BYTES);
        let refused = worker.send(&[&longest, b"!"]);
        assert!(matches!(refused, Err(TransportError::TooLong { limit: REPLY_BYTES, .. })));
        worker.send(&[&longest]).unwrap();
        worker.receive().unwrap().len()
    });
    assert_eq!(next(&mut master, worker_id(0)).len(), REPLY_BYTES);
    let refused = master.send(worker_id(0), &[&image(JOB_BYTES + 1)]);
    assert!(matches!(refused, Err(TransportError::TooLong { bytes: 1001, limit: JOB_BYTES })));
    master.send(worker_id(0), &[&image(JOB_BYTES)]).unwrap();
    assert_eq!(thread.join().unwrap(), JOB_BYTES);
}

fn promise_6_wait_ends_for_a_message_a_descriptor_and_the_time<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    let (reader, mut writer) = std::io::pipe().unwrap();
    let watched = [reader.as_fd()];

    let begin = Instant::now();
    master.wait(&watched, Duration::from_millis(30)).unwrap();
    assert!(begin.elapsed() >= Duration::from_millis(29), "woke without a reason");

    writer.write_all(b"x").unwrap();
    master.wait(&watched, FOREVER).unwrap();

    let thread = echo::<T>(master.open(worker_id(0)).unwrap());
    next(&mut master, worker_id(0));
    master.send(worker_id(0), &[b"ping"]).unwrap();
    next(&mut master, worker_id(0));
    master.send(worker_id(0), &[]).unwrap();
    thread.join().unwrap();
    assert!(begin.elapsed() < FOREVER);
}

fn promise_7_what_was_sent_before_the_worker_went_is_received<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    let arguments = master.open(worker_id(0)).unwrap();
    std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        worker.send(&[b"last words"]).unwrap();
        // As after a kill, nothing of the worker's end is taken down.
        std::mem::forget(worker);
    })
    .join()
    .unwrap();
    assert_eq!(next(&mut master, worker_id(0)), b"last words");
    master.close(worker_id(0));
    assert_eq!(master.traffic(worker_id(0)), Traffic::default());
}

fn promise_8_no_room_is_an_error_before_anything_is_made<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let refused = T::master(base.path(), &needs(&[1 << 60])).err().expect("an exbibyte of memory");
    let TransportError::NoRoom { needed, free, .. } = refused else { panic!("{refused}") };
    assert!(needed > 1 << 60 && free < 1 << 60);
    assert_eq!(T::remains(base.path()), [""; 0]);
}

fn promise_9_nothing_remains_with_workers_in_any_state<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let image = image(64 * 100);
    let mut master = T::master(base.path(), &needs(&[image.len()])).unwrap();
    master.publish(0, &image).unwrap();
    let [absent, leaving, crashed] = [0, 1, 2].map(worker_id);
    master.open(absent).unwrap();
    let arguments = master.open(crashed).unwrap();
    std::thread::spawn(move || {
        let mut worker = T::worker(&arguments);
        worker.send(&[b"unread"]).unwrap();
        std::mem::forget(worker);
    })
    .join()
    .unwrap();
    let thread = echo::<T>(master.open(leaving).unwrap());
    next(&mut master, leaving);
    master.send(leaving, &[]).unwrap();
    thread.join().unwrap();
    assert_ne!(T::remains(base.path()), [""; 0]);
    drop(master);
    assert_eq!(T::remains(base.path()), [""; 0]);
}

fn promise_9_two_runs_do_not_see_each_other<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut first = T::master(base.path(), &needs(&[])).unwrap();
    let thread = echo::<T>(first.open(worker_id(0)).unwrap());
    next(&mut first, worker_id(0));

    let mut second = T::master(base.path(), &needs(&[])).unwrap();
    let other = echo::<T>(second.open(worker_id(0)).unwrap());
    next(&mut second, worker_id(0));
    second.send(worker_id(0), &[]).unwrap();
    other.join().unwrap();
    drop(second);

    first.send(worker_id(0), &[b"still here?"]).unwrap();
    assert_eq!(next(&mut first, worker_id(0)), b"still here?");
    first.send(worker_id(0), &[]).unwrap();
    thread.join().unwrap();
}

fn promise_10_message_bytes_are_counted<T: Transport>() {
    let base = tempfile::tempdir().unwrap();
    let mut master = T::master(base.path(), &needs(&[])).unwrap();
    let thread = echo::<T>(master.open(worker_id(0)).unwrap());
    next(&mut master, worker_id(0));
    master.send(worker_id(0), &[b"1234", b"567"]).unwrap();
    next(&mut master, worker_id(0));
    assert_eq!(master.traffic(worker_id(0)).messages, 5 + 7 + 7);
    master.send(worker_id(0), &[]).unwrap();
    thread.join().unwrap();
}

macro_rules! conformance {
    ($transport:ty: $($promise:ident)*) => {
        $(#[test] fn $promise() { super::$promise::<$transport>() })*
    };
}

mod shared_memory {
    conformance! { super::OverSharedMemory:
        promise_1_images_arrive_whole_before_and_after_attaching
        promise_2_geometry_outlives_the_master
        promise_3_messages_arrive_once_whole_in_order_and_at_one_worker
        promise_3_a_flood_of_replies_loses_none
        promise_4_a_full_queue_is_an_error_and_nobody_waits
        promise_4_a_message_to_an_absent_worker_is_an_error
        promise_5_too_long_messages_are_refused
        promise_6_wait_ends_for_a_message_a_descriptor_and_the_time
        promise_7_what_was_sent_before_the_worker_went_is_received
        promise_8_no_room_is_an_error_before_anything_is_made
        promise_9_nothing_remains_with_workers_in_any_state
        promise_9_two_runs_do_not_see_each_other
        promise_10_message_bytes_are_counted
    }
}
