//! A run's own directory and name prefix, and the removal of what dead runs left.
//!
//! `<base>/bumper-<uid>/run-<random>/lock` is flock'd by a living master; the kernel releases it
//! however the master ends. The prefix of the run's files in `/dev/shm` follows from the name of
//! its directory, so that a later run knows them; one of these files is a second lock, for those
//! who look from another base. A run is made and leftovers are removed under
//! `<base>/bumper-<uid>/lock`, so that no run is taken for dead before it holds its own lock.

mod leftovers;

use std::ffi::CString;
use std::fs::{DirBuilder, File, OpenOptions, Permissions, TryLockError};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub use self::leftovers::{Leftovers, LivingRun, NotRemoved, remove_leftovers};
use super::room::SHARED_MEMORY_DIRECTORY;
use crate::transport::TransportError;

const RUN: &str = "run-";
const LOCK: &str = "lock";

/// Others hold the user's lock only while they make a run or remove leftovers.
const PATIENCE: Duration = Duration::from_secs(10);

/// The user's runtime directory, or else `/tmp`.
pub fn default_base() -> PathBuf {
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    runtime.filter(|path| path.is_absolute() && path.is_dir()).unwrap_or_else(|| "/tmp".into())
}

/// Removed, with everything in shared memory that has its prefix, when dropped.
#[derive(Debug)]
pub struct RunDirectory {
    path: PathBuf,
    prefix: String,
    _locks: [File; 2],
}

impl RunDirectory {
    /// Removes what dead runs left below `base`, as far as it can be, then makes a new run.
    pub fn create(base: &Path) -> Result<Self, TransportError> {
        let home = own_directory(base)?;
        let _guard = lock_within(&home.join(LOCK), PATIENCE)?;
        let mut leftovers = Leftovers::default();
        leftovers.remove_runs_below(&home).map_err(refuse(&home))?;
        for NotRemoved { path, reason } in leftovers.failures {
            tracing::warn!("{}: of a run that died, cannot be removed: {reason}", path.display());
        }

        let mut made = tempfile::Builder::new();
        let made = made.prefix(RUN).permissions(Permissions::from_mode(0o700));
        let made = made.tempdir_in(&home).map_err(refuse(&home))?;
        let prefix = prefix(made.path()).ok_or_else(|| TransportError::RunDirectory {
            path: made.path().to_owned(),
            reason: "the path is not plain text".to_owned(),
        })?;
        let lock = lock_within(&made.path().join(LOCK), PATIENCE)?;
        let shared = leftovers::shared_lock(&prefix);
        let shared = create_locked(&shared).map_err(refuse(&shared))?;
        Ok(Self { path: made.keep(), prefix, _locks: [lock, shared] })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn prefix(&self) -> &str {
        &self.prefix
    }
}

impl Drop for RunDirectory {
    fn drop(&mut self) {
        let mut removed = Leftovers::default();
        if let Err(error) = removed.remove_files(&self.prefix) {
            tracing::warn!("{SHARED_MEMORY_DIRECTORY}: {error}");
        }
        removed.remove_tree(&self.path);
        for NotRemoved { path, reason } in removed.failures {
            tracing::warn!("{}: not removed: {reason}", path.display());
        }
    }
}

/// Of the names in `/dev/shm` of the run in `directory`; `None` if that is no run's.
pub fn prefix(directory: &Path) -> Option<String> {
    let run = directory.file_name()?.to_str()?.strip_prefix(RUN)?;
    Some(format!("{}{run}_", prefix_of_this_user()))
}

fn prefix_of_this_user() -> String {
    format!("bumper_{}_", user())
}

fn user() -> u32 {
    // SAFETY: takes no arguments and cannot fail.
    unsafe { libc::getuid() }
}

fn refuse(path: &Path) -> impl Fn(io::Error) -> TransportError {
    |error| TransportError::RunDirectory { path: path.to_owned(), reason: error.to_string() }
}

/// `<base>/bumper-<uid>`: ours, and closed to everybody else.
fn own_directory(base: &Path) -> Result<PathBuf, TransportError> {
    let path = path_of_home(base);
    match DirBuilder::new().mode(0o700).create(&path) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            let reason = format!(
                "the run's sockets and locks belong here, but: {error} (XDG_RUNTIME_DIR names the \
                 directory above, otherwise it is /tmp)"
            );
            return Err(TransportError::RunDirectory { path, reason });
        }
        _ => {}
    }
    home_of_this_user(base)?.ok_or_else(|| TransportError::RunDirectory {
        path,
        reason: "was removed while a run began here".to_owned(),
    })
}

/// `<base>/bumper-<uid>`, if it is there.
fn home_of_this_user(base: &Path) -> Result<Option<PathBuf>, TransportError> {
    let path = path_of_home(base);
    let found = match std::fs::symlink_metadata(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        other => other.map_err(refuse(&path))?,
    };
    if !found.is_dir() || found.uid() != user() || found.mode() & 0o077 != 0 {
        let reason =
            "must be a directory of this user that nobody else can enter (mode 0700): remove it";
        return Err(TransportError::RunDirectory { path, reason: reason.to_owned() });
    }
    Ok(Some(path))
}

fn path_of_home(base: &Path) -> PathBuf {
    base.join(format!("bumper-{}", user()))
}

/// Held until the file is dropped.
fn lock_within(path: &Path, limit: Duration) -> Result<File, TransportError> {
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).write(true).mode(0o600);
    let file = options.open(path).map_err(refuse(path))?;
    let deadline = Instant::now() + limit;
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(file),
            Err(TryLockError::Error(error)) => return Err(refuse(path)(error)),
            Err(TryLockError::WouldBlock) if Instant::now() < deadline => {
                std::thread::sleep(Duration::from_millis(5));
            }
            Err(TryLockError::WouldBlock) => {
                let reason = format!(
                    "another bumper of this user has held this lock for {} s while it starts or \
                     cleans up: end that process (`fuser` names it) and try again",
                    limit.as_secs_f32()
                );
                return Err(TransportError::RunDirectory { path: path.to_owned(), reason });
            }
        }
    }
}

/// A file that is never there without being locked, as long as this process keeps it.
fn create_locked(path: &Path) -> io::Result<File> {
    let nameless = tempfile::tempfile_in(path.parent().unwrap_or(path))?;
    nameless.try_lock()?;
    let from = CString::new(format!("/proc/self/fd/{}", nameless.as_raw_fd()))?;
    let to = CString::new(path.as_os_str().as_bytes())?;
    let here = libc::AT_FDCWD;
    // SAFETY: both names end with a zero byte.
    match unsafe { libc::linkat(here, from.as_ptr(), here, to.as_ptr(), libc::AT_SYMLINK_FOLLOW) } {
        0 => Ok(nameless),
        _ => Err(io::Error::last_os_error()),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Mutex, PoisonError};

    use super::*;

    /// Anybody who cleans up removes what another test has made a dead run of.
    static DEAD: Mutex<()> = Mutex::new(());

    fn shared_memory_file(run: &RunDirectory) -> PathBuf {
        Path::new(SHARED_MEMORY_DIRECTORY).join(format!("{}test", run.prefix()))
    }

    #[test]
    fn a_dropped_run_leaves_nothing() {
        let base = tempfile::tempdir().unwrap();
        let run = RunDirectory::create(base.path()).unwrap();
        let (path, file) = (run.path().to_owned(), shared_memory_file(&run));
        std::fs::write(&file, "x").unwrap();
        drop(run);
        assert!(!path.exists() && !file.exists());
    }

    #[test]
    fn a_new_run_removes_the_dead_and_spares_the_living() {
        let _alone = DEAD.lock().unwrap_or_else(PoisonError::into_inner);
        let base = tempfile::tempdir().unwrap();
        let living = RunDirectory::create(base.path()).unwrap();
        let dead = RunDirectory::create(base.path()).unwrap();
        for run in [&living, &dead] {
            std::fs::write(shared_memory_file(run), "x").unwrap();
        }
        let (dead_path, dead_file) = (dead.path().to_owned(), shared_memory_file(&dead));
        // What a killed master does: its lock goes, its files stay.
        dead._locks.iter().for_each(|lock| lock.unlock().unwrap());
        std::mem::forget(dead);

        let _new = RunDirectory::create(base.path()).unwrap();
        assert!(!dead_path.exists() && !dead_file.exists());
        assert!(living.path().exists() && shared_memory_file(&living).exists());
    }

    #[test]
    fn a_leftover_that_cannot_be_removed_does_not_keep_a_run_from_beginning() {
        let _alone = DEAD.lock().unwrap_or_else(PoisonError::into_inner);
        let base = tempfile::tempdir().unwrap();
        let dead = RunDirectory::create(base.path()).unwrap();
        let dead_path = dead.path().to_owned();
        // No file, so that it cannot be removed as one, by whomever.
        let stuck = shared_memory_file(&dead);
        std::fs::create_dir(&stuck).unwrap();
        dead._locks.iter().for_each(|lock| lock.unlock().unwrap());
        std::mem::forget(dead);

        let next = RunDirectory::create(base.path());
        let cleaned = remove_leftovers(base.path());
        std::fs::remove_dir(&stuck).unwrap();
        next.unwrap();
        assert!(!dead_path.exists(), "what follows it is removed");
        let failures = cleaned.unwrap().failures;
        assert!(failures.iter().any(|failure| failure.path == stuck), "{failures:?}");
    }

    #[test]
    fn a_lock_that_another_process_keeps_is_an_error_in_time() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join(LOCK);
        let held = lock_within(&path, Duration::ZERO).unwrap();
        let refused = lock_within(&path, Duration::from_millis(20)).unwrap_err().to_string();
        assert!(refused.contains("has held this lock for 0.02 s"), "{refused}");
        drop(held);
        assert!(lock_within(&path, Duration::ZERO).is_ok());
    }

    #[test]
    fn a_clean_up_from_another_base_spares_the_living_and_removes_the_dead() {
        let _alone = DEAD.lock().unwrap_or_else(PoisonError::into_inner);
        let (base, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let living = RunDirectory::create(base.path()).unwrap();
        let dead = RunDirectory::create(base.path()).unwrap();
        let files = [&living, &dead].map(shared_memory_file);
        files.iter().for_each(|file| std::fs::write(file, "x").unwrap());
        dead._locks.iter().for_each(|lock| lock.unlock().unwrap());
        let dead = std::mem::ManuallyDrop::new(dead);

        let cleaned = remove_leftovers(other.path()).unwrap();
        assert_eq!(files.map(|file| file.exists()), [true, false]);
        assert!(!shared_memory_file(&dead).exists() && living.path().exists());
        let kept = Path::new(SHARED_MEMORY_DIRECTORY).join(living.prefix());
        assert!(cleaned.living.iter().any(|run| run.path == kept && run.files == 2));
        assert!(!other.path().join(path_of_home(other.path())).exists(), "makes nothing");
    }

    #[test]
    fn a_run_that_ends_is_not_taken_for_dead() {
        let _alone = DEAD.lock().unwrap_or_else(PoisonError::into_inner);
        let (base, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let ended = AtomicBool::new(false);
        let runs = || {
            for _ in 0..50 {
                let run = RunDirectory::create(base.path()).unwrap();
                for n in 0..20 {
                    std::fs::write(format!("{}{n}", shared_memory_file(&run).display()), "x")
                        .unwrap();
                }
            }
            ended.store(true, Ordering::Relaxed);
        };
        std::thread::scope(|scope| {
            scope.spawn(runs);
            while !ended.load(Ordering::Relaxed) {
                for base in [&base, &other] {
                    let Leftovers { runs, failures, .. } = remove_leftovers(base.path()).unwrap();
                    assert!(runs == 0 && failures.is_empty(), "{runs}, {failures:?}");
                }
            }
        });
    }

    #[test]
    fn a_directory_open_to_others_is_refused() {
        use std::os::unix::fs::PermissionsExt;
        let base = tempfile::tempdir().unwrap();
        let home = own_directory(base.path()).unwrap();
        std::fs::set_permissions(&home, std::fs::Permissions::from_mode(0o755)).unwrap();
        let refused = RunDirectory::create(base.path()).unwrap_err().to_string();
        assert!(refused.contains("0700"), "{refused}");
    }
}
