//! One worker as a thread of the master.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::thread::JoinHandle;

use super::launch::Worker;
use crate::transport::descriptors::{event, ring};
use crate::transport::threads::ThreadWorker;
use crate::workers::{Bookmark, Role, WorkerError, serve_in_place};

/// A thread cannot be ended from outside. One that is dropped or killed is left alone: it ends by
/// itself at its next message, because its channel is closed by then.
#[derive(Debug)]
pub struct WorkerThread {
    thread: Option<JoinHandle<Result<(), WorkerError>>>,
    death_notice: File,
    last_words: String,
    is_left_alone: bool,
    bookmark: Bookmark,
}

impl WorkerThread {
    pub fn start(name: String, end: ThreadWorker, role: Role) -> io::Result<Self> {
        let death_notice = event()?;
        let knell = Knell(death_notice.try_clone()?);
        let (bookmark, handed_down) = Bookmark::new()?;
        let workers = Bookmark::open(handed_down)?;
        let thread = std::thread::Builder::new().name(name).spawn(move || {
            let _knell = knell;
            serve_in_place(end, role, &workers)
        })?;
        Ok(Self {
            thread: Some(thread),
            death_notice,
            last_words: String::new(),
            is_left_alone: false,
            bookmark,
        })
    }
}

impl Worker for WorkerThread {
    fn death_notice(&self) -> BorrowedFd<'_> {
        self.death_notice.as_fd()
    }

    fn ended(&mut self) -> io::Result<Option<String>> {
        let Some(thread) = self.thread.take_if(|thread| thread.is_finished()) else {
            return Ok(self.is_left_alone.then(|| "a thread that is left alone".to_owned()));
        };
        self.last_words = match thread.join() {
            Ok(Ok(())) => "it ended by itself".to_owned(),
            Ok(Err(error)) => error.to_string(),
            Err(panic) => panic_message(panic.as_ref()),
        };
        Ok(Some("a thread".to_owned()))
    }

    fn kill(&mut self) {
        self.is_left_alone = true;
        self.last_words = "it had something to do and did not answer".to_owned();
        ring(&self.death_notice);
    }

    fn last_words(&mut self) -> String {
        self.last_words.clone()
    }

    fn scenario(&self) -> Option<u32> {
        self.bookmark.scenario()
    }
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    format!("it panicked: {}", text.unwrap_or("without a message"))
}

/// Rings when the thread ends, in whatever way.
struct Knell(File);

impl Drop for Knell {
    fn drop(&mut self) {
        ring(&self.0);
    }
}
