use std::collections::{BTreeMap, BTreeSet};
use std::fs::OpenOptions;
use std::os::fd::BorrowedFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::{Duration, Instant};

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

use super::channel::{self, Cell, Length, Received, cells, service, service_error};
use super::doorbell::Doorbell;
use super::growing::Growing;
use super::room::{self, require_room};
use super::run_directory::RunDirectory;
use super::{KEYS, LOOKS_PER_POLL, NAME, NODE};
use crate::transport::descriptors::{self, is_any_readable};
use crate::transport::{
    Attach, MasterEnd, Needs, QUEUED_JOBS, REPLY_BYTES, SharedGeometry, Traffic, TransportError,
    WorkerId,
};

/// Samples that a subscriber may hold at once: one is enough, the other keeps `receive` from
/// failing while the first is being dropped.
const BORROWED: usize = 2;
/// Buckets of a message queue of that length: queued, held by the reader, being written.
const fn buckets(queue: usize) -> usize {
    queue + BORROWED + 1
}

/// Nodes, connections, events: what iceoryx2 takes besides the payloads (measured, rounded up).
const OVERHEAD_OF_RUN: usize = 1 << 20;
const OVERHEAD_OF_WORKER: usize = 256 << 10;
const OVERHEAD_OF_IMAGE: usize = 1 << 20;

/// Open files: the library's, the program's, a margin; and those of a worker's channels (measured
/// 13, and its process).
const DESCRIPTORS_OF_RUN: u64 = 128;
const DESCRIPTORS_OF_WORKER: u64 = 20;

/// The master's end.
#[derive(Debug)]
pub struct SharedMemory {
    // Dropped in this order: ports, then the node, then everything that iceoryx2 leaves behind.
    channels: BTreeMap<WorkerId, Channel>,
    geometry: BTreeMap<u32, Publisher<ipc::Service, [Cell], Length>>,
    withdrawn: BTreeSet<u32>,
    traffic: BTreeMap<WorkerId, Traffic>,
    bell: Doorbell,
    node: Node<ipc::Service>,
    run: RunDirectory,
    /// Of those that workers have made, how many are connected.
    connected_ports: std::cell::Cell<u32>,
    needs: Needs,
}

#[derive(Debug)]
struct Channel {
    jobs: Publisher<ipc::Service, [Cell], Length>,
    replies: Subscriber<ipc::Service, [Cell], Length>,
    bell: Doorbell,
}

impl SharedMemory {
    /// Makes a run below `base`. Nothing is made when there is no room for all that it `needs`.
    pub fn create(base: &Path, needs: &Needs) -> Result<Self, TransportError> {
        let run = RunDirectory::create(base)?;
        require_room(Path::new(room::SHARED_MEMORY_DIRECTORY), needed_bytes(needs))?;
        descriptors::require(
            DESCRIPTORS_OF_RUN + DESCRIPTORS_OF_WORKER * u64::from(needs.workers),
        )?;
        let node = channel::node(run.path())?;
        let bell = Doorbell::create(&channel::master_bell(run.path()))
            .map_err(service_error("create the master's doorbell in /dev/shm"))?;
        room::reserve(run.prefix())?;
        Ok(Self {
            channels: BTreeMap::new(),
            geometry: BTreeMap::new(),
            withdrawn: BTreeSet::new(),
            traffic: BTreeMap::new(),
            bell,
            node,
            run,
            connected_ports: std::cell::Cell::new(0),
            needs: needs.clone(),
        })
    }

    /// As [`open`](MasterEnd::open), for a worker that uses what [`grow`](Self::grow) gives.
    pub fn open_in_node(&mut self, worker: WorkerId) -> Result<Attach, TransportError> {
        let attach = self.open(worker)?;
        Ok(attach.over(NODE))
    }

    /// As [`receive`](MasterEnd::receive), but of one who goes on sending no more than a queue holds.
    pub fn receive_some(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        self.take_replies(worker, channel::QUEUED_REPLIES, take)
    }

    fn take_replies(
        &mut self,
        worker: WorkerId,
        most: usize,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        let channel = self.channels.get(&worker).expect("a channel that was opened");
        let traffic = self.traffic.entry(worker).or_default();
        let mut taken = 0;
        while taken < most
            && let Some(sample) =
                channel.replies.receive().map_err(service_error("receive a reply"))?
        {
            let message = Received::new(sample)?;
            traffic.from_worker += message.len() as u64;
            take(&message);
            taken += 1;
        }
        // It may wait for room.
        if taken > 0 { channel.wake() } else { Ok(()) }
    }

    /// Memory for a tree of which workers see more and more.
    pub fn grow(&self, number: u32, bytes: usize) -> Result<Growing, TransportError> {
        Growing::create(self.run.path(), number, bytes)
    }

    /// As [`wait`](MasterEnd::wait); whether it was more than the time that ended it.
    pub fn has_woken(
        &mut self,
        watched: &[BorrowedFd<'_>],
        limit: Duration,
    ) -> Result<bool, TransportError> {
        let deadline = descriptors::deadline(limit);
        let found = self.needs.wake_up.search(deadline, |looked| {
            let has_to_poll = looked % LOOKS_PER_POLL == LOOKS_PER_POLL - 1;
            let is_anything_there =
                self.look()? || has_to_poll && is_any_readable(watched).map_err(failed)?;
            Ok(is_anything_there.then_some(()))
        })?;
        if found.is_some() {
            return Ok(true);
        }
        loop {
            if self.sleep(watched, deadline)? {
                return Ok(true);
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return Ok(false);
            }
        }
    }

    fn channel(&mut self, worker: WorkerId) -> &mut Channel {
        self.channels.get_mut(&worker).expect("a channel that was opened")
    }

    /// Hands what was published before to the ports that have been made since.
    fn connect_geometry(&self) -> Result<(), TransportError> {
        for publisher in self.geometry.values() {
            publisher.update_connections().map_err(service_error("hand over the geometry"))?;
        }
        self.channels.values().try_for_each(Channel::wake)
    }

    /// Of a worker that may have been killed. One that lives keeps what it has mapped.
    fn remove_files(&self, worker: WorkerId, channel: Channel) -> std::io::Result<()> {
        let ports = [channel.jobs.id().value(), channel.replies.id().value()];
        drop(channel);
        room::remove_queues(self.run.prefix(), ports[0], ports[1])?;
        channel::worker_bell(self.run.path(), worker).remove()
    }

    /// Whether there is anything to receive. Connects new ports.
    fn look(&self) -> Result<bool, TransportError> {
        let ports = self.bell.ports();
        if ports != self.connected_ports.replace(ports) {
            self.connect_geometry()?;
        }
        for channel in self.channels.values() {
            if channel.replies.has_samples().map_err(service_error("look for replies"))? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns whether there is a reason to wake.
    fn sleep(
        &self,
        watched: &[BorrowedFd<'_>],
        deadline: Option<Instant>,
    ) -> Result<bool, TransportError> {
        let mut found = Ok(false);
        let last_look = || {
            found = self.look();
            !matches!(found, Ok(false))
        };
        let is_awake = self.bell.sleep(watched, deadline, last_look).map_err(failed)?;
        self.bell.has_ended().map_err(failed)?;
        Ok(found? || is_awake || self.look()?)
    }
}

fn failed(error: std::io::Error) -> TransportError {
    service_error("wait for workers")(error)
}

impl MasterEnd for SharedMemory {
    type Attach = Attach;

    fn name(&self) -> &'static str {
        NAME
    }

    fn shared_geometry(&mut self) -> Option<&mut dyn SharedGeometry> {
        Some(self)
    }

    fn open(&mut self, worker: WorkerId) -> Result<Attach, TransportError> {
        let channel = Channel::create(&self.node, self.run.path(), worker, self.needs.job_bytes)?;
        self.channels.insert(worker, channel);
        self.traffic.insert(worker, Traffic::default());
        room::reserve(self.run.prefix())?;
        let values = [
            self.needs.wake_up.name().into(),
            self.run.path().into(),
            worker.slot.to_string().into(),
            worker.incarnation.to_string().into(),
        ];
        Ok(Attach::new(NAME, KEYS, values, Vec::new()))
    }

    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        let limit = self.needs.job_bytes;
        let channel = self.channel(worker);
        if channel::send(&channel.jobs, parts, limit)? != 1 {
            return Err(TransportError::NotDelivered(worker));
        }
        channel.wake()?;
        let bytes: usize = parts.iter().map(|part| part.len()).sum();
        self.traffic.entry(worker).or_default().to_worker += bytes as u64;
        Ok(())
    }

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError> {
        self.has_woken(watched, limit).map(|_| ())
    }

    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        self.take_replies(worker, usize::MAX, take)
    }

    fn close(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        if !self.channels.contains_key(&worker) {
            return Ok(());
        }
        let received = self.receive(worker, take);
        let removed = match self.channels.remove(&worker) {
            Some(channel) => self.remove_files(worker, channel),
            None => Ok(()),
        };
        received.and(removed.map_err(service_error(format!("remove what worker {worker} left"))))
    }

    fn traffic(&self, worker: WorkerId) -> Traffic {
        self.traffic.get(&worker).copied().unwrap_or_default()
    }
}

impl SharedGeometry for SharedMemory {
    fn publish(&mut self, mesh: u32, image: &[u8]) -> Result<u64, TransportError> {
        if self.geometry.contains_key(&mesh) || self.withdrawn.contains(&mesh) {
            return Err(TransportError::PublishedBefore(mesh));
        }
        let needed = (image.len() + OVERHEAD_OF_IMAGE) as u64;
        require_room(Path::new(room::SHARED_MEMORY_DIRECTORY), needed)?;
        // Every worker may die and be replaced, and its place in a service is not given back.
        let participants = 16 * self.needs.workers as usize + 256;
        let publisher = geometry_publisher(&self.node, mesh, image.len(), participants)?;
        room::reserve(self.run.prefix())?;
        channel::send(&publisher, &[image], usize::MAX)?;
        self.geometry.insert(mesh, publisher);
        let notice = channel::geometry_notice(self.run.path(), mesh);
        OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(notice)
            .map_err(service_error("give notice of a mesh"))?;
        self.channels.values().try_for_each(Channel::wake)?;
        Ok(image.len() as u64)
    }

    fn withdraw(&mut self, mesh: u32) -> Result<(), TransportError> {
        if self.geometry.contains_key(&mesh) {
            let notice = channel::geometry_notice(self.run.path(), mesh);
            std::fs::remove_file(notice).map_err(service_error("withdraw a mesh"))?;
            self.geometry.remove(&mesh);
            self.withdrawn.insert(mesh);
        }
        Ok(())
    }
}

impl Channel {
    fn create(
        node: &Node<ipc::Service>,
        run: &Path,
        worker: WorkerId,
        job_bytes: usize,
    ) -> Result<Self, TransportError> {
        let jobs = message_service(node, &channel::job_name(worker), QUEUED_JOBS)?
            .publisher_builder()
            .initial_max_slice_len(cells(job_bytes))
            // The default waits for ever on a worker that was killed with a full queue.
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(service_error(format!("create the job queue of worker {worker}")))?;
        let replies = message_service(node, &channel::reply_name(worker), channel::QUEUED_REPLIES)?
            .subscriber_builder()
            .create()
            .map_err(service_error(format!("create the reply queue of worker {worker}")))?;
        let bell = Doorbell::create(&channel::worker_bell(run, worker)).map_err(service_error(
            format!("create the doorbell of worker {worker} in /dev/shm"),
        ))?;
        Ok(Self { jobs, replies, bell })
    }

    fn wake(&self) -> Result<(), TransportError> {
        self.bell.ring_if_asleep().map_err(service_error("wake a worker"))
    }
}

type MessageService =
    iceoryx2::service::port_factory::publish_subscribe::PortFactory<ipc::Service, [Cell], Length>;

fn message_service(
    node: &Node<ipc::Service>,
    name: &str,
    queue: usize,
) -> Result<MessageService, TransportError> {
    service(node, name)?
        .publish_subscribe::<[Cell]>()
        .user_header::<Length>()
        .max_publishers(1)
        .max_subscribers(1)
        .max_nodes(3)
        .history_size(0)
        .subscriber_max_buffer_size(queue)
        .subscriber_max_borrowed_samples(BORROWED)
        .enable_safe_overflow(false)
        .create()
        .map_err(service_error(format!("create the service {name}")))
}

/// One sample holds the whole mesh, and is the only one there will be.
fn geometry_publisher(
    node: &Node<ipc::Service>,
    mesh: u32,
    bytes: usize,
    participants: usize,
) -> Result<Publisher<ipc::Service, [Cell], Length>, TransportError> {
    service(node, &channel::geometry_name(mesh))?
        .publish_subscribe::<[Cell]>()
        .user_header::<Length>()
        .max_publishers(1)
        .max_subscribers(participants)
        .max_nodes(participants)
        .history_size(1)
        .subscriber_max_buffer_size(1)
        .subscriber_max_borrowed_samples(1)
        .enable_safe_overflow(false)
        .create()
        .map_err(service_error(format!("create the service of mesh {mesh}")))?
        .publisher_builder()
        .initial_max_slice_len(cells(bytes).max(1))
        .override_sample_preallocation(|_| 1)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(service_error(format!("create the publisher of mesh {mesh}")))
}

fn needed_bytes(needs: &Needs) -> u64 {
    let queues = buckets(QUEUED_JOBS) * (needs.job_bytes + 128)
        + buckets(channel::QUEUED_REPLIES) * (REPLY_BYTES + 128);
    u64::from(needs.workers) * (queues + OVERHEAD_OF_WORKER) as u64 + OVERHEAD_OF_RUN as u64
}
