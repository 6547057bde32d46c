//! Several runs beside each other, one after a killed one, and `bumper clean`.

use std::os::unix::fs::{PermissionsExt, chown};
use std::os::unix::process::ExitStatusExt;
use std::process::Child;
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::Duration;

use super::interrupt::{await_rows, children, shared_memory_of};
use super::*;

const POSES: u32 = 20_000;
const README: &str = include_str!("../../README.md");
const NOBODY: u32 = 65534;

/// Rows of a run beside which there is no other.
static UNDISTURBED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let place = Place::with_poses();
    succeeded(&place.run(&place.many("alone")));
    fs::read(place.path("alone/scenarios.csv")).unwrap()
});

/// `bumper clean` removes what dead runs of the user left, also those that another test means to find.
static DEAD: Mutex<()> = Mutex::new(());

impl Place {
    /// With enough poses for a run to be stopped in the middle; few of them touch, so that their number
    /// and not their cost makes the run long.
    fn with_poses() -> Self {
        let place = Self::new();
        let pose = |n: u32| format!("1,0,0,0,{},{},0\n", f64::from(n % 500) * 0.1, n % 3);
        place.write("many.csv", &(0..POSES).fold(HEADER.to_owned(), |rows, n| rows + &pose(n)));
        place
    }

    fn many(&self, out: &str) -> Vec<&'static str> {
        let leaked = |text: String| -> &'static str { text.leak() };
        let (poses, out) = (leaked(self.text("many.csv")), leaked(self.text(out)));
        let meshes = ["run", "--fixed", TRACKED, "--moving", CAR, "--workers", "2"];
        [&meshes[..], &["--poses", poses, "--out", out]].concat()
    }

    /// Stopped in the middle, so that whatever the test does happens during the run.
    fn stopped(&self, out: &str) -> Stopped {
        let mut command = self.bumper(&self.many(out));
        let run = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let mut run = Stopped(run);
        await_rows(&mut run.0, &self.path(out).join("scenarios.csv"));
        run.signal(libc::SIGSTOP);
        assert_eq!(run.0.try_wait().unwrap(), None, "ended before it was stopped");
        run
    }

    fn finish(&self, mut run: Stopped, out: &str) {
        run.signal(libc::SIGCONT);
        assert!(run.0.wait().unwrap().success());
        self.is_exact(out);
    }

    fn is_exact(&self, out: &str) {
        let rows = fs::read(self.path(out).join("scenarios.csv")).unwrap();
        assert!(rows == *UNDISTURBED, "{out} differs");
        assert_eq!(rows.iter().filter(|byte| **byte == b'\n').count(), POSES as usize + 1);
    }

    fn home(&self, user: u32) -> PathBuf {
        self.path("runtime").join(format!("bumper-{user}"))
    }

    /// That everything of one run is still there, and nothing of any other is. Its workers go on
    /// while it is stopped, so it may have more.
    fn has_only(&self, of_run: &[PathBuf]) {
        let now = self.traces();
        let gone: Vec<_> = of_run.iter().filter(|trace| !now.contains(trace)).collect();
        assert!(gone.is_empty(), "{gone:?}");
        let run = of_run.iter().find(|trace| trace.is_dir()).unwrap();
        let id = run.file_name().unwrap().to_str().unwrap().strip_prefix("run-").unwrap();
        let others: Vec<_> =
            now.iter().filter(|trace| !trace.to_str().unwrap().contains(id)).collect();
        assert!(others.is_empty(), "{others:?}");
    }

    /// Directories of runs, and their files in shared memory, sorted; once nothing comes or goes any
    /// more: workers of a stopped run may still be about to begin.
    fn traces(&self) -> Vec<PathBuf> {
        let mut before = self.traces_now();
        loop {
            std::thread::sleep(Duration::from_millis(100));
            let now = self.traces_now();
            if now == before {
                return now;
            }
            before = now;
        }
    }

    fn traces_now(&self) -> Vec<PathBuf> {
        let runtime = self.path("runtime");
        let homes = fs::read_dir(&runtime).unwrap().map(|home| home.unwrap().path());
        let runs =
            homes.flat_map(|home| fs::read_dir(home).unwrap().map(|run| run.unwrap().path()));
        let runs = runs.filter(|run| run.is_dir());
        let shared = shared_memory_of(&runtime).into_iter();
        let shared = shared.map(|name| Path::new("/dev/shm").join(name));
        let mut all: Vec<PathBuf> = runs.chain(shared).collect();
        all.sort();
        all
    }
}

/// Killed when a test fails.
struct Stopped(Child);

impl Stopped {
    fn signal(&self, signal: i32) {
        // SAFETY: sends a signal to a child that has not been waited for.
        unsafe { libc::kill(i32::try_from(self.0.id()).unwrap(), signal) };
    }

    fn kill(&mut self) -> std::process::ExitStatus {
        self.0.kill().unwrap();
        self.0.wait().unwrap()
    }
}

impl Drop for Stopped {
    fn drop(&mut self) {
        // Fails only for one that has ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn user() -> u32 {
    // SAFETY: takes no arguments and cannot fail.
    unsafe { libc::getuid() }
}

#[test]
fn clean_removes_what_a_killed_run_left_and_the_living_one_ends_exact() {
    let _alone = DEAD.lock().unwrap_or_else(PoisonError::into_inner);
    let place = Place::with_poses();
    let living = place.stopped("living");
    let of_living = place.traces();
    let mut dead = place.stopped("dead");
    let workers = children(dead.0.id());
    let of_both = place.traces();
    assert_eq!(workers.len(), 2);
    assert!(of_living.iter().all(|trace| of_both.contains(trace)), "the second removed something");
    assert!(of_both.len() > of_living.len() + 5);

    assert_eq!(dead.kill().signal(), Some(libc::SIGKILL));
    let killed = Instant::now();
    while workers.iter().any(|pid| Path::new(&format!("/proc/{pid}/exe")).exists()) {
        assert!(killed.elapsed() < Duration::from_secs(1), "workers outlive their master");
        std::thread::sleep(Duration::from_millis(1));
    }
    // Workers that were waiting may have removed what was theirs alone.
    let left = place.traces();
    assert!(of_living.iter().all(|trace| left.contains(trace)), "the dead removed something");
    assert!(left.len() > of_living.len() + 2, "nothing is left of a killed master: {left:?}");

    assert!(README.contains("\nbumper clean\n"));
    let words: Vec<&str> = "bumper clean".split_whitespace().skip(1).collect();
    let output = place.run(&words);
    succeeded(&output);
    let text = stdout(&output);
    assert!(text.starts_with("removed ") && text.contains(" that died\n"), "{text}");
    let run = of_living.iter().find(|trace| trace.starts_with(place.path("runtime"))).unwrap();
    assert!(text.contains(&format!("bytes of {}: that run is alive", run.display())), "{text}");
    place.has_only(&of_living);

    let output = place.run(&["clean", "--json"]);
    succeeded(&output);
    let again: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let kept =
        again["living"].as_array().unwrap().iter().find(|one| one["run"] == run.to_str().unwrap());
    assert!(kept.unwrap()["files"].as_u64().unwrap() >= of_living.len() as u64 - 1);
    assert!(kept.unwrap()["bytes"].as_u64().unwrap() > 100_000);

    place.finish(living, "living");
    assert_eq!(place.traces(), Vec::<PathBuf>::new());
}

#[test]
fn the_next_run_removes_what_a_killed_one_left() {
    let _alone = DEAD.lock().unwrap_or_else(PoisonError::into_inner);
    let place = Place::with_poses();
    let mut dead = place.stopped("dead");
    dead.kill();
    let left = place.traces();
    assert!(left.len() > 2, "nothing is left of a killed master: {left:?}");
    succeeded(&place.run(&place.many("next")));
    place.is_exact("next");
    assert_eq!(place.traces(), Vec::<PathBuf>::new());
}

#[test]
fn two_runs_of_one_user_do_not_see_each_other_and_both_are_exact() {
    let place = Place::with_poses();
    let first = place.stopped("first");
    let of_first = place.traces();
    assert_closed(&place.home(user()), &of_first);
    succeeded(&place.run(&place.many("second")));
    place.is_exact("second");
    place.has_only(&of_first);
    place.finish(first, "first");
    assert_eq!(place.traces(), Vec::<PathBuf>::new());
}

/// What a run makes is its user's alone: directories 0700, which nobody else can enter, and files
/// 0600.
fn assert_closed(home: &Path, traces: &[PathBuf]) {
    let mode = |path: &Path| fs::symlink_metadata(path).unwrap().permissions().mode() & 0o7777;
    assert_eq!(mode(home), 0o700);
    for trace in traces {
        let expected = if trace.is_dir() { 0o700 } else { 0o600 };
        assert_eq!(mode(trace), expected, "{}: {:o}", trace.display(), mode(trace));
    }
    let run = traces.iter().find(|trace| trace.is_dir()).unwrap();
    let inside = fs::read_dir(run).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<PathBuf> = inside.filter(|path| !path.is_dir()).collect();
    assert!(files.len() >= 3, "a lock and doorbells: {files:?}");
    for file in files {
        assert_eq!(mode(&file), 0o600, "{}: {:o}", file.display(), mode(&file));
    }
}

/// Needs two users, which root alone can be.
#[test]
fn two_runs_of_two_users_do_not_see_each_other_and_both_are_exact() {
    let as_nobody = |program: &Path| {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups", "--"]).arg(program);
        command
    };
    if user() != 0 || !as_nobody("true".as_ref()).status().is_ok_and(|status| status.success()) {
        println!("not tried: only root with setpriv can be two users");
        return;
    }
    let place = Place::with_poses();
    let open_to = |path: PathBuf, mode| {
        fs::create_dir_all(&path).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        path
    };
    open_to(place.path(""), 0o755);
    open_to(place.path("runtime"), 0o1777);
    chown(open_to(place.path("theirs"), 0o755), Some(NOBODY), Some(NOBODY)).unwrap();
    // The built program may be where others cannot go.
    let program = place.path("bumper");
    fs::copy(env!("CARGO_BIN_EXE_bumper"), &program).unwrap();

    let ours = place.stopped("ours");
    let of_ours = place.traces();
    let run = |arguments: &[&str]| {
        let mut command = as_nobody(&program);
        command.args(arguments).env("XDG_RUNTIME_DIR", place.path("runtime"));
        command.output().unwrap()
    };
    succeeded(&run(&[&place.many("theirs/out")[..], &["--no-cache"]].concat()));
    place.is_exact("theirs/out");
    place.has_only(&of_ours);
    let cleaned = run(&["clean"]);
    succeeded(&cleaned);
    assert!(stdout(&cleaned).starts_with("removed nothing"), "{}", stdout(&cleaned));
    place.has_only(&of_ours);
    assert_closed(&place.home(0), &of_ours);
    assert_eq!(fs::metadata(place.home(NOBODY)).unwrap().permissions().mode() & 0o777, 0o700);
    for trace in &of_ours {
        let opened = as_nobody("cat".as_ref()).arg(trace).output().unwrap();
        assert!(!opened.status.success(), "others can read {}", trace.display());
    }
    place.finish(ours, "ours");
    assert_eq!(place.traces(), Vec::<PathBuf>::new());
}

#[test]
fn a_second_run_into_the_same_directory_is_refused_and_the_first_ends_exact() {
    let place = Place::with_poses();
    let first = place.stopped("out");
    let output = place.run(&place.many("out"));
    refused(&output, 1, &[&place.text("out"), "still going on", "another directory"]);
    place.finish(first, "out");
    succeeded(&place.run(&place.many("out")));
}
