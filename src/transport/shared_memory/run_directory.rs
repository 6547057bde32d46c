//! A run's own directory and name prefix, and the removal of what dead runs left.
//!
//! `<base>/bumper-<uid>/run-<random>/lock` is flock'd by a living master; the kernel releases it
//! however the master ends. The prefix of the run's files in `/dev/shm` follows from the name of
//! its directory, so that a later run knows them. A run is made and leftovers are removed under
//! `<base>/bumper-<uid>/lock`, so that no run is taken for dead before it holds its own lock.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use super::room::SHARED_MEMORY_DIRECTORY;
use crate::transport::TransportError;

const RUN: &str = "run-";
const LOCK: &str = "lock";

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
    _lock: File,
}

impl RunDirectory {
    /// Removes what dead runs left below `base`, then makes a new run.
    pub fn create(base: &Path) -> Result<Self, TransportError> {
        let home = own_directory(base)?;
        let refuse = |path: &Path| {
            let path = path.to_owned();
            move |error: io::Error| TransportError::RunDirectory { path, reason: error.to_string() }
        };
        let guard = open_lock(&home.join(LOCK)).map_err(refuse(&home))?;
        guard.lock().map_err(refuse(&home))?;
        remove_dead_runs(&home).map_err(refuse(&home))?;

        let made = tempfile::Builder::new().prefix(RUN).tempdir_in(&home).map_err(refuse(&home))?;
        let lock = open_lock(&made.path().join(LOCK)).map_err(refuse(made.path()))?;
        lock.lock().map_err(refuse(made.path()))?;
        let prefix = prefix(made.path()).ok_or_else(|| TransportError::RunDirectory {
            path: made.path().to_owned(),
            reason: "the path is not plain text".to_owned(),
        })?;
        Ok(Self { path: made.keep(), prefix, _lock: lock })
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
        if let Err(error) = remove_run(&self.path) {
            tracing::warn!("{}: not removed: {error}", self.path.display());
        }
    }
}

/// Of the names in `/dev/shm` of the run in `directory`.
pub fn prefix(directory: &Path) -> Option<String> {
    let run = directory.file_name()?.to_str()?.strip_prefix(RUN)?;
    // SAFETY: takes no arguments and cannot fail.
    let uid = unsafe { libc::getuid() };
    Some(format!("bumper_{uid}_{run}_"))
}

/// `<base>/bumper-<uid>`: ours, and closed to everybody else.
fn own_directory(base: &Path) -> Result<PathBuf, TransportError> {
    // SAFETY: takes no arguments and cannot fail.
    let uid = unsafe { libc::getuid() };
    let path = base.join(format!("bumper-{uid}"));
    let refuse = |reason: String| TransportError::RunDirectory { path: path.clone(), reason };
    match DirBuilder::new().mode(0o700).create(&path) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            return Err(refuse(format!(
                "the run's sockets and locks belong here, but: {error} (XDG_RUNTIME_DIR names the \
                 directory above, otherwise it is /tmp)"
            )));
        }
        _ => {}
    }
    let found = std::fs::symlink_metadata(&path).map_err(|error| refuse(error.to_string()))?;
    if !found.is_dir() || found.uid() != uid || found.mode() & 0o077 != 0 {
        return Err(refuse(
            "must be a directory of this user that nobody else can enter (mode 0700): remove it"
                .to_owned(),
        ));
    }
    Ok(path)
}

fn open_lock(path: &Path) -> io::Result<File> {
    OpenOptions::new().create(true).truncate(false).write(true).mode(0o600).open(path)
}

fn remove_dead_runs(home: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(home)? {
        let path = entry?.path();
        let is_run = path.file_name().and_then(|n| n.to_str()).is_some_and(|n| n.starts_with(RUN));
        if is_run && is_dead(&path) {
            remove_run(&path)?;
        }
    }
    Ok(())
}

/// Whether nobody holds the run's lock, or its master died before it had one.
fn is_dead(run: &Path) -> bool {
    match File::open(run.join(LOCK)) {
        Ok(lock) => lock.try_lock().is_ok(),
        Err(error) => error.kind() == io::ErrorKind::NotFound,
    }
}

fn remove_run(run: &Path) -> io::Result<()> {
    if let Some(prefix) = prefix(run) {
        for entry in std::fs::read_dir(SHARED_MEMORY_DIRECTORY)? {
            let entry = entry?;
            if entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) {
                ignore_absent(std::fs::remove_file(entry.path()))?;
            }
        }
    }
    ignore_absent(std::fs::remove_dir_all(run))
}

fn ignore_absent(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let base = tempfile::tempdir().unwrap();
        let living = RunDirectory::create(base.path()).unwrap();
        let dead = RunDirectory::create(base.path()).unwrap();
        for run in [&living, &dead] {
            std::fs::write(shared_memory_file(run), "x").unwrap();
        }
        let (dead_path, dead_file) = (dead.path().to_owned(), shared_memory_file(&dead));
        // What a killed master does: its lock goes, its files stay.
        dead._lock.unlock().unwrap();
        std::mem::forget(dead);

        let _new = RunDirectory::create(base.path()).unwrap();
        assert!(!dead_path.exists() && !dead_file.exists());
        assert!(living.path().exists() && shared_memory_file(&living).exists());
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
