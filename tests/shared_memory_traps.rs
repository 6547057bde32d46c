//! What shared memory does to those who trust it, each with a test: an end that was killed over a
//! half-made file, a full queue that nobody empties, results of the dead, and memory that runs out.
//! The ends that are killed are processes; they are this program in another role.

mod engine_run;

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use bumper::transport::shared_memory::{SharedMemory, SharedMemoryWorker};
use bumper::transport::{
    Attached, GeometryInPlace, MasterEnd, Needs, QUEUED_JOBS, SharedGeometry, TransportError,
    WakeUp, WorkerEnd, WorkerId, attach,
};
use engine_run::{Place, in_role, kill, role, shared_memory_files};

/// Only what hangs takes so long.
const PATIENCE: Duration = Duration::from_secs(60);
const SHARED_MEMORY: &str = "/dev/shm";

fn worker_id(incarnation: u32) -> WorkerId {
    WorkerId { slot: 0, incarnation }
}

fn needs() -> Needs {
    Needs { workers: 1, job_bytes: 1000, wake_up: WakeUp::Block }
}

static IMAGE: [u8; 6400] = [7; 6400];

/// Fails if it hangs. What hangs is left behind: it ends with this program.
fn within_patience(what: impl FnOnce() + Send + 'static) {
    let (done, wait) = mpsc::channel();
    let thread = std::thread::spawn(move || {
        what();
        done.send(()).expect("somebody waits");
    });
    match wait.recv_timeout(PATIENCE) {
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("it hangs"),
        _ => thread.join().expect("no failure"),
    }
}

fn until(what: &str, mut reached: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !reached() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A worker that does what its part is, says so with a file beside the runs, and waits to be
/// killed.
fn worker(test: &str, place: &Place, part: &str, arguments: &[OsString]) -> Child {
    let arguments: Vec<&str> = arguments.iter().map(|a| a.to_str().unwrap()).collect();
    let done = place.base().join("done");
    let role = [&[part, done.to_str().unwrap()], &arguments[..]].concat().join("\n");
    in_role(test, &role).stdout(Stdio::null()).spawn().unwrap()
}

fn attached(arguments: &[OsString]) -> Result<SharedMemoryWorker, TransportError> {
    match attach(arguments)? {
        Attached::SharedMemory(end) => Ok(end),
        Attached::Node(_) | Attached::Stream(_) => panic!("not the shared memory of a master"),
    }
}

fn await_done(place: &Place) {
    let done = place.base().join("done");
    until("the worker has not done its part", || done.exists());
    fs::remove_file(done).unwrap();
}

/// Whether this process is such a worker; then it does not come back before it was killed.
fn plays_worker() -> bool {
    let Some(role) = role() else { return false };
    end_with_the_test();
    let words: Vec<&str> = role.lines().collect();
    let [part, done, arguments @ ..] = &words[..] else { return false };
    let arguments: Vec<OsString> = arguments.iter().map(OsString::from).collect();
    let mut end = attached(&arguments).unwrap();
    match *part {
        "subscribe" => {
            fs::write(done, "").unwrap();
            let image = end.geometry(0).unwrap();
            end.send(&[&image[..100]]).unwrap();
        }
        "greet" => {
            end.send(&[b"hello"]).unwrap();
            fs::write(done, "").unwrap();
        }
        "five replies" => {
            (0..5_u8).for_each(|n| end.send(&[&[n]]).unwrap());
            fs::write(done, "").unwrap();
        }
        other => panic!("no such part: {other}"),
    }
    std::thread::sleep(2 * PATIENCE);
    panic!("nobody has killed this worker");
}

/// A test that fails leaves nobody behind.
fn end_with_the_test() {
    // SAFETY: sets a process attribute; touches no memory.
    unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) };
}

fn end(mut worker: Child) {
    kill(worker.id());
    worker.wait().unwrap();
}

/// iceoryx2 waits for ever for a half-made file to grow: whatever a worker has made of its ports when
/// it is killed, the master must not wait for the rest.
#[test]
fn workers_killed_at_any_moment_of_their_start_hang_nobody() {
    if plays_worker() {
        return;
    }
    within_patience(|| {
        const TEST: &str = "workers_killed_at_any_moment_of_their_start_hang_nobody";
        const KILLED: u32 = 40;
        let place = Place::new();
        let mut master = SharedMemory::create(place.base(), &needs()).unwrap();
        master.publish(0, &IMAGE).unwrap();
        for incarnation in 0..KILLED {
            let arguments = master.open(worker_id(incarnation)).unwrap().arguments;
            let doomed = worker(TEST, &place, "subscribe", &arguments);
            std::thread::sleep(Duration::from_micros(u64::from(incarnation) * 250));
            end(doomed);
            master.wait(&[], Duration::from_millis(1)).unwrap();
            master.close(worker_id(incarnation), &mut |_| {}).unwrap();
        }
        let arguments = master.open(worker_id(KILLED)).unwrap().arguments;
        let last = worker(TEST, &place, "subscribe", &arguments);
        let mut heard = Vec::new();
        while heard.is_empty() {
            master.wait(&[], PATIENCE).unwrap();
            master.receive(worker_id(KILLED), &mut |message| heard = message.to_vec()).unwrap();
        }
        assert_eq!(heard, IMAGE[..100]);
        end(last);
        drop(master);
        assert_eq!(place.prefixes(), [""; 0]);
    });
}

/// Nothing is opened to be cleaned: it is removed whatever state it is in.
#[test]
fn half_made_files_of_a_killed_master_hang_no_later_run() {
    const TEST: &str = "half_made_files_of_a_killed_master_hang_no_later_run";
    if let Some(base) = role() {
        end_with_the_test();
        let mut master = SharedMemory::create(base.as_ref(), &needs()).unwrap();
        master.open(worker_id(0)).unwrap();
        fs::write(Path::new(&base).join("done"), "").unwrap();
        std::thread::sleep(2 * PATIENCE);
        return;
    }
    within_patience(|| {
        let place = Place::new();
        let role = in_role(TEST, place.base().to_str().unwrap());
        let dead = { role }.stdout(Stdio::null()).spawn().unwrap();
        await_done(&place);
        end(dead);
        let prefixes = place.prefixes();
        let left = shared_memory_files(&prefixes);
        assert!(left.len() > 5, "{left:?}");
        for file in left {
            fs::write(Path::new(SHARED_MEMORY).join(file), "").unwrap();
        }
        let _next = SharedMemory::create(place.base(), &needs()).unwrap();
        assert_eq!(shared_memory_files(&prefixes), [""; 0]);
    });
}

/// The library's default is to wait until the worker takes something, which it never will.
#[test]
fn a_full_queue_of_a_killed_worker_is_an_error_and_blocks_nobody() {
    if plays_worker() {
        return;
    }
    within_patience(|| {
        const TEST: &str = "a_full_queue_of_a_killed_worker_is_an_error_and_blocks_nobody";
        let place = Place::new();
        let mut master = SharedMemory::create(place.base(), &needs()).unwrap();
        let dead = worker(TEST, &place, "greet", &master.open(worker_id(0)).unwrap().arguments);
        await_done(&place);
        for message in 0..QUEUED_JOBS as u8 {
            master.send(worker_id(0), &[&[message]]).unwrap();
        }
        end(dead);
        let refused = master.send(worker_id(0), &[b"one too many"]);
        assert!(matches!(refused, Err(TransportError::NotDelivered(_))), "{refused:?}");
        master.close(worker_id(0), &mut |_| {}).unwrap();
    });
}

/// The library's clean-up of dead nodes would take them away.
#[test]
fn what_a_worker_sent_before_it_was_killed_is_received() {
    if plays_worker() {
        return;
    }
    within_patience(|| {
        const TEST: &str = "what_a_worker_sent_before_it_was_killed_is_received";
        let place = Place::new();
        let mut master = SharedMemory::create(place.base(), &needs()).unwrap();
        let dead =
            worker(TEST, &place, "five replies", &master.open(worker_id(0)).unwrap().arguments);
        await_done(&place);
        end(dead);
        let mut heard = Vec::new();
        master.receive(worker_id(0), &mut |message| heard.extend_from_slice(message)).unwrap();
        assert_eq!(heard, [0, 1, 2, 3, 4]);
    });
}

/// A program whose `/dev/shm` is its own and has so many bytes; `None` where that is not allowed.
fn with_little_memory(bytes: u64, program: &Command) -> Option<Command> {
    let mount = format!("mount -t tmpfs -o size={bytes} tmpfs {SHARED_MEMORY}");
    let inside = |script: String| {
        let mut command = Command::new("unshare");
        command.args(["--map-root-user", "--mount", "sh", "-c", &script]);
        command
    };
    if !inside(mount.clone()).output().is_ok_and(|output| output.status.success()) {
        println!("not tried: no mount of one's own is allowed here");
        return None;
    }
    let mut command = inside(format!("{mount} && exec \"$0\" \"$@\""));
    command.arg(program.get_program()).args(program.get_args());
    command.envs(program.get_envs().filter_map(|(key, value)| Some((key, value?))));
    Some(command)
}

/// Takes all that is left of shared memory.
fn fill_memory() {
    use std::io::Write;
    let path = Path::new(SHARED_MEMORY).join("filler");
    let mut file = fs::File::options().create(true).append(true).open(path).unwrap();
    while file.write(&[1; 4096]).is_ok_and(|written| written > 0) {}
}

const MOMENTS: [&str; 5] =
    ["before open", "before publish", "before attach", "before geometry", "at once"];

/// A run whose shared memory others fill at that moment.
fn run_out_of_memory(moment: &str) -> Result<(), TransportError> {
    let base = tempfile::tempdir().unwrap();
    if moment == "at once" {
        // As soon as there is something of the run, which is before anything of the library's.
        let nothing = || fs::read_dir(SHARED_MEMORY).unwrap().next().is_none();
        std::thread::spawn(move || {
            while nothing() {}
            fill_memory();
        });
    }
    let fill_before = |this: &str| {
        if this == moment {
            fill_memory()
        }
    };
    let mut master = SharedMemory::create(base.path(), &needs())?;
    fill_before("before open");
    let arguments = master.open(worker_id(0))?.arguments;
    fill_before("before publish");
    master.publish(0, &IMAGE)?;
    std::thread::scope(|scope| {
        let reader = scope.spawn(|| {
            fill_before("before attach");
            let mut worker = attached(&arguments)?;
            fill_before("before geometry");
            worker.geometry(0).map(|image| image.to_vec())
        });
        while !reader.is_finished() {
            master.wait(&[], Duration::from_millis(5))?;
        }
        assert_eq!(reader.join().expect("no panic")?, IMAGE);
        Ok(())
    })
}

#[test]
fn memory_that_runs_out_at_any_moment_is_an_error_and_no_signal() {
    const TEST: &str = "memory_that_runs_out_at_any_moment_is_an_error_and_no_signal";
    if let Some(moment) = role() {
        if let Err(error) = run_out_of_memory(&moment) {
            eprintln!("error: {error}");
            std::process::exit(1);
        }
        return;
    }
    let mut errors = 0;
    for moment in MOMENTS.iter().chain(&["at once"; 5]) {
        let Some(mut command) = with_little_memory(4 << 20, &in_role(TEST, moment)) else { return };
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        let is_clear = said.contains("error: ") && said.contains(SHARED_MEMORY);
        match output.status.code() {
            Some(0) => {}
            Some(1) if is_clear => errors += 1,
            _ => panic!("{moment}: {:?}, {said}", output.status),
        }
        println!("{moment}: {:?} {said}", output.status.code());
    }
    assert!(errors > 1, "the memory never ran out");
}

#[test]
fn a_run_that_does_not_fit_says_so_before_it_begins() {
    let mut run = Command::new(env!("CARGO_BIN_EXE_bumper"));
    run.args([
        "run",
        "--fixed",
        "builtin:car?triangles=2000",
        "--moving",
        "builtin:car?triangles=2000",
    ]);
    run.args(["--count", "5", "--workers", "2", "--no-cache"]);
    let Some(mut run) = with_little_memory(1 << 20, &run) else { return };
    let Output { status, stderr, .. } = run.output().unwrap();
    let said = String::from_utf8_lossy(&stderr);
    assert_eq!(status.code(), Some(1), "{said}");
    assert!(said.contains("/dev/shm has ") && said.contains("--shm-size="), "{said}");
}
