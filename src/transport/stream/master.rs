use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::os::fd::BorrowedFd;
use std::time::{Duration, Instant};

use super::channel::Channel;
use super::frame::{failed, prefix};
use crate::transport::descriptors::{self, Interest, poll};
use crate::transport::{
    Attach, MasterEnd, Needs, REPLY_BYTES, SharedGeometry, Traffic, TransportError, WakeUp,
    WorkerId,
};

/// Open files: the program's and a margin; a worker's two streams and its process, and while it is
/// being started, its ends of the streams.
const DESCRIPTORS_OF_RUN: u64 = 64;
const DESCRIPTORS_OF_WORKER: u64 = 6;

/// What is different between streams of one kind and another.
pub trait Link {
    const NAME: &'static str;

    fn open(&self, worker: WorkerId, needs: &Needs) -> io::Result<Ends>;

    /// Where all workers say that they have sent something; `None` where each one's own stream has
    /// to be looked at.
    fn signals(&self) -> Option<BorrowedFd<'_>>;

    /// Tells `heard` of every slot that has signalled since the last call.
    fn take_signals(&mut self, heard: impl FnMut(u32)) -> io::Result<()>;
}

/// Streams between the master and one worker.
#[derive(Debug)]
pub struct Ends {
    pub from_worker: File,
    pub to_worker: File,
    pub attach: Attach,
}

/// The master's end.
#[derive(Debug)]
pub struct Streams<L> {
    link: L,
    needs: Needs,
    channels: BTreeMap<WorkerId, Channel>,
    traffic: BTreeMap<WorkerId, Traffic>,
}

impl<L: Link> Streams<L> {
    pub(super) fn over(link: L, needs: &Needs) -> Result<Self, TransportError> {
        descriptors::require(
            DESCRIPTORS_OF_RUN + DESCRIPTORS_OF_WORKER * u64::from(needs.workers),
        )?;
        ignore_broken_pipes();
        let (channels, traffic) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { link, needs: needs.clone(), channels, traffic })
    }

    /// Sleeps until something happens or the `deadline`, takes note of who has spoken, writes what
    /// there is room for. Returns whether there is anything for the caller.
    fn look(
        &mut self,
        watched: &[BorrowedFd<'_>],
        deadline: Option<Instant>,
    ) -> Result<bool, TransportError> {
        let signals = self.link.signals();
        let is_common = signals.is_some();
        // In the order in which the answer is gone through below.
        let streams = self.channels.values().flat_map(|channel| {
            let incoming = channel.incoming().filter(|_| !is_common);
            let outgoing = channel.outgoing();
            [incoming.map(|fd| (fd, Interest::Read)), outgoing.map(|fd| (fd, Interest::Write))]
        });
        let others = watched.iter().copied().chain(signals).map(|fd| (fd, Interest::Read));
        let ready = poll(others.chain(streams.flatten()), deadline).map_err(|e| failed(&e))?;
        let (of_watched, others) = ready.split_at(watched.len());
        let mut others = others.iter();
        let mut is_next_ready = || *others.next().expect("an answer for every descriptor");
        if is_common && is_next_ready() {
            self.hear_signals()?;
        }
        for channel in self.channels.values_mut() {
            if !is_common && channel.incoming().is_some() {
                channel.has_spoken |= is_next_ready();
            }
            if channel.outgoing().is_some() && is_next_ready() {
                channel.drain()?;
            }
        }
        Ok(of_watched.contains(&true) || self.has_anyone_spoken())
    }

    fn hear_signals(&mut self) -> Result<(), TransportError> {
        let channels = &mut self.channels;
        let heard = |slot| {
            let incarnation = |incarnation| WorkerId { slot, incarnation };
            let named = incarnation(0)..=incarnation(u32::MAX);
            // A slot that nobody has is damage, and may stand for any.
            let everyone = channels.range(named.clone()).next().is_none();
            let named = if everyone { WorkerId::FIRST..=WorkerId::LAST } else { named };
            channels.range_mut(named).for_each(|(_, channel)| channel.has_spoken = true);
        };
        self.link.take_signals(heard).map_err(|error| failed(&error))
    }

    fn has_anyone_spoken(&self) -> bool {
        self.channels.values().any(|channel| channel.has_spoken)
    }

    fn send_by(
        &mut self,
        worker: WorkerId,
        parts: &[&[u8]],
        send: impl Fn(&mut Channel, &[u8], &[&[u8]]) -> Result<bool, TransportError>,
    ) -> Result<(), TransportError> {
        let prefix = prefix(parts, self.needs.job_bytes)?;
        let (channel, traffic) = self.opened(worker);
        if !send(channel, &prefix, parts)? {
            return Err(TransportError::NotDelivered(worker));
        }
        traffic.to_worker += u64::from_ne_bytes(prefix);
        Ok(())
    }

    fn opened(&mut self, worker: WorkerId) -> (&mut Channel, &mut Traffic) {
        let channel = self.channels.get_mut(&worker).expect("a channel that was opened");
        (channel, self.traffic.entry(worker).or_default())
    }
}

impl<L: Link> MasterEnd for Streams<L> {
    type Attach = Attach;

    fn name(&self) -> &'static str {
        L::NAME
    }

    fn shared_geometry(&mut self) -> Option<&mut dyn SharedGeometry> {
        None
    }

    fn open(&mut self, worker: WorkerId) -> Result<Attach, TransportError> {
        let Ends { from_worker, to_worker, attach } =
            self.link.open(worker, &self.needs).map_err(|error| TransportError::Service {
                action: format!("open the streams of worker {worker}"),
                reason: error.to_string(),
            })?;
        self.channels.insert(worker, Channel::new(from_worker, to_worker, REPLY_BYTES));
        self.traffic.insert(worker, Traffic::default());
        Ok(attach)
    }

    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        self.send_by(worker, parts, Channel::send)
    }

    fn send_ahead(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        self.send_by(worker, parts, Channel::send_ahead)
    }

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError> {
        if self.has_anyone_spoken() {
            // Not received yet; but others may have spoken since.
            return self.look(watched, Some(Instant::now())).map(|_| ());
        }
        let deadline = descriptors::deadline(limit);
        let wake_up = self.needs.wake_up;
        let mut is_awake = |deadline| self.look(watched, deadline).map(|woken| woken.then_some(()));
        let now = Some(Instant::now());
        // One look that sleeps is enough where a look that does not would be the only one.
        if wake_up != WakeUp::Block && wake_up.search(deadline, |_| is_awake(now))?.is_some() {
            return Ok(());
        }
        while is_awake(deadline)?.is_none() && deadline.is_none_or(|end| Instant::now() < end) {}
        Ok(())
    }

    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        let (channel, traffic) = self.opened(worker);
        if !channel.has_spoken {
            return Ok(());
        }
        channel.receive(&mut |message| {
            traffic.from_worker += message.len() as u64;
            take(message);
        })
    }

    fn close(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        let Some(channel) = self.channels.get_mut(&worker) else { return Ok(()) };
        // It may have been killed before it could signal.
        channel.has_spoken = true;
        let received = self.receive(worker, take);
        self.channels.remove(&worker);
        received
    }

    fn traffic(&self, worker: WorkerId) -> Traffic {
        self.traffic.get(&worker).copied().unwrap_or_default()
    }
}

/// Writing to a worker that has gone is an error; by default it is also a signal that ends the
/// process. Rust's own start-up does this too, but the program around the master may be another.
fn ignore_broken_pipes() {
    // SAFETY: changes a signal's disposition, and only from the default; touches no memory.
    unsafe {
        let before = libc::signal(libc::SIGPIPE, libc::SIG_IGN);
        if before != libc::SIG_DFL && before != libc::SIG_ERR {
            libc::signal(libc::SIGPIPE, before);
        }
    }
}
