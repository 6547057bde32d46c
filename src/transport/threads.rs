//! Workers as threads of this process: what the machine can do when nothing has to cross between
//! processes. Geometry is one copy for all; a message is copied once.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs::File;
use std::io::{self, Read};
use std::ops::Deref;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::mpsc::{self, Receiver, Sender, SyncSender, TryRecvError, TrySendError};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::descriptors::{self, Interest, event, is_any_readable, poll, ring};
use super::message::Message;
use super::wake_up::Asleep;
use super::{
    GeometryInPlace, MasterEnd, Needs, REPLY_BYTES, SharedGeometry, Traffic, TransportError,
    WakeUp, WorkerEnd, WorkerId,
};

/// Replies that wait for the master before the worker has to.
const QUEUED_REPLIES: usize = 8;

/// Of the master itself: what any process has open, and the bell.
const DESCRIPTORS_OF_RUN: u64 = 64;
/// Death notices at both ends.
const DESCRIPTORS_OF_WORKER: u64 = 2;

/// While the master polls without end, it looks at descriptors only now and then.
const LOOKS_PER_POLL: u32 = 256;

/// The master's end.
#[derive(Debug)]
pub struct Threads {
    board: Arc<Board>,
    bell: Arc<Bell>,
    withdrawn: BTreeSet<u32>,
    channels: BTreeMap<WorkerId, Channel>,
    traffic: BTreeMap<WorkerId, Traffic>,
    needs: Needs,
}

#[derive(Debug)]
struct Channel {
    jobs: Sender<Message>,
    replies: Receiver<Message>,
    /// Taken out of the queue, and not received yet.
    arrived: VecDeque<Message>,
}

/// A worker's end.
#[derive(Debug)]
pub struct ThreadWorker {
    board: Arc<Board>,
    bell: Arc<Bell>,
    jobs: Receiver<Message>,
    replies: SyncSender<Message>,
    wake_up: WakeUp,
}

/// What is published.
#[derive(Debug, Default)]
struct Board {
    notices: Mutex<Notices>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Notices {
    images: BTreeMap<u32, Image>,
    master_has_gone: bool,
}

/// An image that all threads have in common. Its memory is given back with the last of these.
#[derive(Clone, Debug)]
pub struct Image {
    lines: Arc<[Line]>,
    bytes: usize,
}

/// Makes an image begin on a multiple of 64.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

impl Image {
    fn copy_of(bytes: &[u8]) -> Self {
        let (whole, rest) = bytes.as_chunks::<64>();
        let mut last = [0; 64];
        last[..rest.len()].copy_from_slice(rest);
        let last = (!rest.is_empty()).then_some(last);
        let count = bytes.len().div_ceil(64);
        let mut lines = whole.iter().copied().chain(last).map(Line);
        let lines = (0..count).map(|_| lines.next().expect("counted")).collect();
        Self { lines, bytes: bytes.len() }
    }
}

impl Deref for Image {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.lines)[..self.bytes]
    }
}

impl Board {
    fn notices(&self) -> MutexGuard<'_, Notices> {
        // Whoever panicked was not in the middle of a change: each is a single step.
        self.notices.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Notices)) {
        change(&mut self.notices());
        self.changed.notify_all();
    }
}

/// Wakes the master, which also has descriptors to look at.
#[derive(Debug)]
struct Bell {
    event: File,
    asleep: Asleep,
}

impl Bell {
    fn new() -> io::Result<Self> {
        Ok(Self { event: event()?, asleep: Asleep::default() })
    }

    fn ring_if_asleep(&self) {
        if self.asleep.has_to_be_rung() {
            ring(&self.event);
        }
    }

    /// Sleeps until it is rung, a watched descriptor can be read, or the `deadline`. Returns
    /// whether a watched one can.
    fn sleep(&self, watched: &[BorrowedFd<'_>], deadline: Option<Instant>) -> io::Result<bool> {
        let entries = watched.iter().copied().chain([self.event.as_fd()]);
        let ready = poll(entries.map(|fd| (fd, Interest::Read)), deadline)?;
        // Nothing to read is not an error here.
        let _ = (&self.event).read(&mut [0; size_of::<u64>()]);
        Ok(ready[..watched.len()].contains(&true))
    }
}

impl Threads {
    pub fn create(needs: &Needs) -> Result<Self, TransportError> {
        descriptors::require(
            DESCRIPTORS_OF_RUN + DESCRIPTORS_OF_WORKER * u64::from(needs.workers),
        )?;
        let bell = Bell::new().map_err(|error| failed(&error))?;
        Ok(Self {
            board: Arc::default(),
            bell: Arc::new(bell),
            withdrawn: BTreeSet::new(),
            channels: BTreeMap::new(),
            traffic: BTreeMap::new(),
            needs: needs.clone(),
        })
    }

    fn has_anything_arrived(&mut self) -> bool {
        let arrivals = self.channels.values_mut().map(Channel::has_anything_arrived);
        arrivals.fold(false, |any, one| any | one)
    }

    fn opened(&mut self, worker: WorkerId) -> (&mut Channel, &mut Traffic) {
        let channel = self.channels.get_mut(&worker).expect("a channel that was opened");
        (channel, self.traffic.entry(worker).or_default())
    }
}

impl Channel {
    fn has_anything_arrived(&mut self) -> bool {
        if self.arrived.is_empty() {
            self.arrived.extend(self.replies.try_recv());
        }
        !self.arrived.is_empty()
    }
}

fn failed(error: &io::Error) -> TransportError {
    TransportError::Service { action: "wait for workers".to_owned(), reason: error.to_string() }
}

impl MasterEnd for Threads {
    type Attach = ThreadWorker;

    fn name(&self) -> &'static str {
        "threads"
    }

    fn shared_geometry(&mut self) -> Option<&mut dyn SharedGeometry> {
        Some(self)
    }

    fn open(&mut self, worker: WorkerId) -> Result<ThreadWorker, TransportError> {
        let (jobs, workers_jobs) = mpsc::channel();
        let (workers_replies, replies) = mpsc::sync_channel(QUEUED_REPLIES);
        let channel = Channel { jobs, replies, arrived: VecDeque::new() };
        self.channels.insert(worker, channel);
        self.traffic.insert(worker, Traffic::default());
        Ok(ThreadWorker {
            board: self.board.clone(),
            bell: self.bell.clone(),
            jobs: workers_jobs,
            replies: workers_replies,
            wake_up: self.needs.wake_up,
        })
    }

    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        let message = checked(parts, self.needs.job_bytes)?;
        let (channel, traffic) = self.opened(worker);
        let bytes = message.len() as u64;
        channel.jobs.send(message).map_err(|_| TransportError::NotDelivered(worker))?;
        traffic.to_worker += bytes;
        Ok(())
    }

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError> {
        let deadline = descriptors::deadline(limit);
        let found = self.needs.wake_up.search(deadline, |looked| {
            let has_to_poll = looked % LOOKS_PER_POLL == LOOKS_PER_POLL - 1;
            let is_anything_there =
                self.has_anything_arrived() || has_to_poll && is_any_readable(watched)?;
            Ok(is_anything_there.then_some(()))
        });
        if found.map_err(|error| failed(&error))?.is_some() {
            return Ok(());
        }
        let bell = self.bell.clone();
        loop {
            bell.asleep.fall();
            let mut is_awake = self.has_anything_arrived();
            if !is_awake {
                is_awake = bell.sleep(watched, deadline).map_err(|error| failed(&error))?;
            }
            bell.asleep.wake();
            let is_over = deadline.is_some_and(|deadline| Instant::now() >= deadline);
            if is_awake || is_over || self.has_anything_arrived() {
                return Ok(());
            }
        }
    }

    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        let (channel, traffic) = self.opened(worker);
        while channel.has_anything_arrived() {
            for message in channel.arrived.drain(..) {
                traffic.from_worker += message.len() as u64;
                take(&message);
            }
        }
        Ok(())
    }

    fn close(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        if self.channels.contains_key(&worker) {
            self.receive(worker, take)?;
            self.channels.remove(&worker);
        }
        Ok(())
    }

    fn traffic(&self, worker: WorkerId) -> Traffic {
        self.traffic.get(&worker).copied().unwrap_or_default()
    }
}

impl SharedGeometry for Threads {
    fn publish(&mut self, mesh: u32, image: &[u8]) -> Result<u64, TransportError> {
        let is_known = self.board.notices().images.contains_key(&mesh);
        if is_known || self.withdrawn.contains(&mesh) {
            return Err(TransportError::PublishedBefore(mesh));
        }
        let copy = Image::copy_of(image);
        self.board.change(|notices| {
            notices.images.insert(mesh, copy);
        });
        Ok(image.len() as u64)
    }

    fn withdraw(&mut self, mesh: u32) -> Result<(), TransportError> {
        self.board.change(|notices| {
            notices.images.remove(&mesh);
        });
        self.withdrawn.insert(mesh);
        Ok(())
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        self.board.change(|notices| notices.master_has_gone = true);
    }
}

impl WorkerEnd for ThreadWorker {
    type Message = Message;

    fn receive(&mut self) -> Result<Message, TransportError> {
        let found = self.wake_up.search(None, |_| match self.jobs.try_recv() {
            Ok(message) => Ok(Some(message)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(TransportError::MasterGone),
        })?;
        match found {
            Some(message) => Ok(message),
            None => self.jobs.recv().map_err(|_| TransportError::MasterGone),
        }
    }

    fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError> {
        let message = checked(parts, REPLY_BYTES)?;
        match self.replies.try_send(message) {
            Err(TrySendError::Full(message)) => {
                self.replies.send(message).map_err(|_| TransportError::MasterGone)?;
            }
            Err(TrySendError::Disconnected(_)) => return Err(TransportError::MasterGone),
            Ok(()) => {}
        }
        self.bell.ring_if_asleep();
        Ok(())
    }
}

impl GeometryInPlace for ThreadWorker {
    type Geometry = Image;

    fn geometry(&mut self, mesh: u32) -> Result<Image, TransportError> {
        let is_awaited =
            |notices: &mut Notices| !notices.images.contains_key(&mesh) && !notices.master_has_gone;
        let notices = self.board.changed.wait_while(self.board.notices(), is_awaited);
        let notices = notices.unwrap_or_else(PoisonError::into_inner);
        notices.images.get(&mesh).cloned().ok_or(TransportError::MasterGone)
    }
}

fn checked(parts: &[&[u8]], limit: usize) -> Result<Message, TransportError> {
    let bytes = parts.iter().map(|part| part.len()).sum();
    if bytes > limit {
        return Err(TransportError::TooLong { bytes, limit });
    }
    Ok(Message::gathered(parts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_withdrawn_mesh_is_given_back_with_its_last_reader() {
        let needs = Needs { workers: 1, job_bytes: 1, wake_up: WakeUp::Block };
        let mut master = Threads::create(&needs).unwrap();
        let mut worker = master.open(WorkerId::FIRST).unwrap();
        master.publish(7, b"image").unwrap();
        let image = worker.geometry(7).unwrap();
        let memory = Arc::downgrade(&image.lines);
        assert_eq!(memory.strong_count(), 2, "one copy, for the board and its reader");
        master.withdraw(7).unwrap();
        assert_eq!(&*image, b"image");
        drop(image);
        assert_eq!(memory.strong_count(), 0);
    }

    #[test]
    fn an_image_is_aligned_and_exactly_as_long_as_it_was() {
        for length in [0, 1, 63, 64, 65, 6400] {
            let bytes: Vec<_> = (0..length).map(|n| n as u8).collect();
            let image = Image::copy_of(&bytes);
            assert_eq!(&*image, bytes);
            assert_eq!(image.as_ptr().addr() % 64, 0);
        }
    }
}
