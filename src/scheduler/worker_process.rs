//! One worker process: started, watched, ended.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, FromRawFd, OwnedFd};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::launch::Worker;
use crate::transport::{Attach, descriptors};
use crate::workers::{BOOKMARK_ARGUMENT, Bookmark, MASTER_ARGUMENT, ROLE_ARGUMENT, Role};

/// Killed and reaped when dropped.
#[derive(Debug)]
pub struct WorkerProcess {
    child: Child,
    /// Readable once the process has ended.
    pidfd: OwnedFd,
    stderr: File,
    bookmark: Bookmark,
}

impl WorkerProcess {
    pub fn start(program: &Path, attach: Attach, role: Role) -> io::Result<Self> {
        // A file and not a pipe: it never fills up, and nobody has to read along.
        let stderr = tempfile::tempfile()?;
        let (bookmark, handed_down) = Bookmark::new()?;
        descriptors::hand_down(&handed_down)?;
        let mut child = Command::new(program)
            .arg("worker")
            .arg(MASTER_ARGUMENT)
            .arg(std::process::id().to_string())
            .arg(ROLE_ARGUMENT)
            .arg(role.to_string())
            .arg(BOOKMARK_ARGUMENT)
            .arg(handed_down.as_raw_fd().to_string())
            .args(attach.arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(stderr.try_clone()?)
            .spawn()?;
        match pidfd(&child) {
            Ok(pidfd) => Ok(Self { child, pidfd, stderr, bookmark }),
            Err(error) => {
                child.kill()?;
                child.wait()?;
                Err(error)
            }
        }
    }

    pub fn pid(&self) -> u32 {
        self.child.id()
    }
}

impl Worker for WorkerProcess {
    fn death_notice(&self) -> BorrowedFd<'_> {
        self.pidfd.as_fd()
    }

    fn ended(&mut self) -> io::Result<Option<String>> {
        Ok(self.child.try_wait()?.map(|status| status.to_string()))
    }

    fn kill(&mut self) {
        // Fails only for a process that has been reaped.
        let _ = self.child.kill();
    }

    /// Of what it wrote to its standard error.
    fn last_words(&mut self) -> String {
        const TAIL: u64 = 2000;
        let length = self.stderr.metadata().map_or(0, |found| found.len());
        let mut tail = Vec::new();
        let start = SeekFrom::Start(length.saturating_sub(TAIL));
        let read = self.stderr.seek(start).and_then(|_| self.stderr.read_to_end(&mut tail));
        let text = String::from_utf8_lossy(&tail);
        let words: Vec<_> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        match read {
            Ok(_) if !words.is_empty() => words.join("; "),
            _ => "it said nothing".to_owned(),
        }
    }

    fn scenario(&self) -> Option<u32> {
        self.bookmark.scenario()
    }
}

impl Drop for WorkerProcess {
    fn drop(&mut self) {
        // Both fail only for a process that has been reaped.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn pidfd(child: &Child) -> io::Result<OwnedFd> {
    // SAFETY: takes a process id and flags; the child is not reaped yet, so the id is its own.
    let fd = unsafe { libc::syscall(libc::SYS_pidfd_open, child.id(), 0) };
    if fd < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the call has just made this descriptor, and nobody else has it.
    Ok(unsafe { OwnedFd::from_raw_fd(fd as i32) })
}
