use std::collections::BTreeMap;
use std::ffi::OsString;
use std::os::fd::BorrowedFd;
use std::path::Path;
use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

use super::channel::{self, Cell, Length, Received, cells, service, service_error};
use super::doorbell::{Doorbell, Ring};
use super::room::{self, require_room};
use super::run_directory::RunDirectory;
use crate::transport::{
    MasterEnd, Needs, QUEUED_JOBS, REPLY_BYTES, Traffic, TransportError, WorkerId,
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

/// Open files: the library's, the program's, a margin; and those of a worker's channels (measured
/// 13, and its process).
const DESCRIPTORS_OF_RUN: u64 = 128;
const DESCRIPTORS_OF_WORKER: u64 = 20;

/// The master's end.
#[derive(Debug)]
pub struct SharedMemory {
    // Dropped in this order: ports, then the node, then everything that iceoryx2 leaves behind.
    channels: BTreeMap<WorkerId, Channel>,
    geometry: Vec<Publisher<ipc::Service, [Cell], Length>>,
    bell: Doorbell,
    node: Node<ipc::Service>,
    run: RunDirectory,
    job_bytes: usize,
}

#[derive(Debug)]
struct Channel {
    jobs: Publisher<ipc::Service, [Cell], Length>,
    replies: Subscriber<ipc::Service, [Cell], Length>,
    bell: Doorbell,
    traffic: Traffic,
}

impl SharedMemory {
    /// Makes a run below `base`. Nothing is made when there is no room for all that it `needs`.
    pub fn create(base: &Path, needs: &Needs) -> Result<Self, TransportError> {
        let run = RunDirectory::create(base)?;
        require_room(Path::new(room::SHARED_MEMORY_DIRECTORY), needed_bytes(needs))?;
        room::require_descriptors(
            DESCRIPTORS_OF_RUN + DESCRIPTORS_OF_WORKER * u64::from(needs.workers),
        )?;
        let node = channel::node(run.path())?;
        // Every worker may die and be replaced, and its place in a service is not given back.
        let participants = 2 * needs.workers as usize + 16;
        let geometry = needs
            .images
            .iter()
            .zip(0..)
            .map(|(&bytes, mesh)| geometry_publisher(&node, mesh, bytes, participants))
            .collect::<Result<_, _>>()?;
        let bell = Doorbell::create(&channel::master_bell(run.path()))
            .map_err(service_error("create the master's doorbell"))?;
        room::reserve(run.prefix())?;
        let channels = BTreeMap::new();
        Ok(Self { channels, geometry, bell, node, run, job_bytes: needs.job_bytes })
    }

    fn channel(&mut self, worker: WorkerId) -> &mut Channel {
        self.channels.get_mut(&worker).expect("a channel that was opened")
    }

    /// Hands what was published before to the ports that have been made since.
    fn connect_geometry(&self) -> Result<(), TransportError> {
        room::remove_half_made_connections(self.run.prefix())
            .map_err(service_error("look for half-made connections"))?;
        for publisher in &self.geometry {
            publisher.update_connections().map_err(service_error("hand over the geometry"))?;
        }
        self.channels.values().try_for_each(Channel::wake)
    }
}

impl MasterEnd for SharedMemory {
    fn name(&self) -> &'static str {
        "iceoryx2"
    }

    fn publish(&mut self, mesh: u32, image: &[u8]) -> Result<u64, TransportError> {
        let publisher = &self.geometry[mesh as usize];
        channel::send(publisher, &[image], usize::MAX)?;
        self.channels.values().try_for_each(Channel::wake)?;
        Ok(image.len() as u64)
    }

    fn open(&mut self, worker: WorkerId) -> Result<Vec<OsString>, TransportError> {
        let channel = Channel::create(&self.node, self.run.path(), worker, self.job_bytes)?;
        self.channels.insert(worker, channel);
        room::reserve(self.run.prefix())?;
        Ok(vec![
            "--run".into(),
            self.run.path().into(),
            "--slot".into(),
            worker.slot.to_string().into(),
            "--incarnation".into(),
            worker.incarnation.to_string().into(),
        ])
    }

    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        let limit = self.job_bytes;
        let channel = self.channel(worker);
        if channel::send(&channel.jobs, parts, limit)? != 1 {
            return Err(TransportError::NotDelivered(worker));
        }
        channel.traffic.messages += parts.iter().map(|part| part.len() as u64).sum::<u64>();
        channel.wake()
    }

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError> {
        let new_ports =
            self.bell.wait(watched, Some(limit)).map_err(service_error("wait for workers"))?;
        if new_ports { self.connect_geometry() } else { Ok(()) }
    }

    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        let channel = self.channel(worker);
        let mut taken = 0;
        while let Some(sample) =
            channel.replies.receive().map_err(service_error("receive a reply"))?
        {
            let message = Received::new(sample)?;
            channel.traffic.messages += message.len() as u64;
            take(&message);
            taken += 1;
        }
        if taken < channel::QUEUED_REPLIES { Ok(()) } else { channel.wake() }
    }

    fn close(&mut self, worker: WorkerId) {
        self.channels.remove(&worker);
    }

    fn traffic(&self, worker: WorkerId) -> Traffic {
        self.channels.get(&worker).map(|channel| channel.traffic).unwrap_or_default()
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
        let bell = Doorbell::create(&channel::worker_bell(run, worker))
            .map_err(service_error(format!("create the doorbell of worker {worker}")))?;
        Ok(Self { jobs, replies, bell, traffic: Traffic::default() })
    }

    fn wake(&self) -> Result<(), TransportError> {
        self.bell.ring(Ring::Message).map_err(service_error("wake a worker"))
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
    let images: u64 = needs.images.iter().map(|&bytes| bytes as u64 + 4096).sum();
    images
        + u64::from(needs.workers) * (queues + OVERHEAD_OF_WORKER) as u64
        + OVERHEAD_OF_RUN as u64
}
