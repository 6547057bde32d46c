use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use super::channel::{self, Cell, Length, Received, cells, service, service_error};
use super::doorbell::{Doorbell, Ring};
use super::{room, run_directory};
use crate::transport::{REPLY_BYTES, TransportError, WorkerEnd, WorkerId};

/// A published image in shared memory, mapped read-only.
pub type Image = Received;
/// A message from the master, where the master wrote it.
pub type JobMessage = Received;

/// A worker's end.
#[derive(Debug)]
pub struct SharedMemoryWorker {
    jobs: Subscriber<ipc::Service, [Cell], Length>,
    replies: Publisher<ipc::Service, [Cell], Length>,
    master_bell: Doorbell,
    bell: Doorbell,
    node: Node<ipc::Service>,
    run: PathBuf,
}

/// While the queue is full the master rings when it has emptied it; this is for one that is gone.
const FULL_QUEUE_RECHECK: Duration = Duration::from_millis(100);

impl SharedMemoryWorker {
    /// `arguments` are what [`crate::transport::MasterEnd::open`] returned.
    pub fn attach(arguments: &[OsString]) -> Result<Self, TransportError> {
        let (run, worker) = parse(arguments)?;
        let node = channel::node(&run)?;
        let open = |path: PathBuf| Doorbell::open(&path).map_err(service_error("open a doorbell"));
        let bell = open(channel::worker_bell(&run, worker))?;
        let master_bell = open(channel::master_bell(&run))?;
        let jobs = service(&node, &channel::job_name(worker))?
            .publish_subscribe::<[Cell]>()
            .user_header::<Length>()
            .open()
            .map_err(service_error("open this worker's job service"))?
            .subscriber_builder()
            .create()
            .map_err(service_error("create a subscriber"))?;
        let replies = service(&node, &channel::reply_name(worker))?
            .publish_subscribe::<[Cell]>()
            .user_header::<Length>()
            .open()
            .map_err(service_error("open this worker's reply service"))?
            .publisher_builder()
            .initial_max_slice_len(cells(REPLY_BYTES))
            // The other strategy loses a message to a master that has not connected yet.
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(service_error("create a publisher"))?;
        let prefix = run_directory::prefix(&run).unwrap_or_default();
        room::reserve(&prefix)?;
        Ok(Self { jobs, replies, master_bell, bell, node, run })
    }

    fn sleep(&self, limit: Option<Duration>) -> Result<(), TransportError> {
        self.bell.wait(&[], limit).map(|_| ()).map_err(service_error("wait for the master"))
    }

    fn tell_master(&self, ring: Ring) -> Result<(), TransportError> {
        self.master_bell.ring(ring).map_err(service_error("wake the master"))
    }
}

impl WorkerEnd for SharedMemoryWorker {
    type Geometry = Image;
    type Message = JobMessage;

    fn geometry(&mut self, mesh: u32) -> Result<Image, TransportError> {
        let subscriber = service(&self.node, &channel::geometry_name(mesh))?
            .publish_subscribe::<[Cell]>()
            .user_header::<Length>()
            .open()
            .map_err(service_error(format!("open the service of mesh {mesh}")))?
            .subscriber_builder()
            .create()
            .map_err(service_error(format!("subscribe to mesh {mesh}")))?;
        // An image published before comes only when the master knows of this subscriber.
        self.tell_master(Ring::NewPort)?;
        loop {
            if let Some(image) = subscriber.receive().map_err(service_error("receive a mesh"))? {
                return Received::new(image);
            }
            self.sleep(None)?;
        }
    }

    fn receive(&mut self) -> Result<JobMessage, TransportError> {
        loop {
            if let Some(job) = self.jobs.receive().map_err(service_error("receive a job"))? {
                return Received::new(job);
            }
            self.sleep(None)?;
        }
    }

    fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError> {
        while channel::send(&self.replies, parts, REPLY_BYTES)? != 1 {
            if !self.run.exists() {
                return Err(TransportError::MasterGone);
            }
            self.sleep(Some(FULL_QUEUE_RECHECK))?;
        }
        self.tell_master(Ring::Message)
    }
}

fn parse(arguments: &[OsString]) -> Result<(PathBuf, WorkerId), TransportError> {
    let refuse = || TransportError::Arguments(format!("{arguments:?}"));
    let [run_key, run, slot_key, slot, incarnation_key, incarnation] = arguments else {
        return Err(refuse());
    };
    if run_key != "--run" || slot_key != "--slot" || incarnation_key != "--incarnation" {
        return Err(refuse());
    }
    let number = |text: &OsString| text.to_str().and_then(|n| n.parse().ok()).ok_or_else(refuse);
    let worker = WorkerId { slot: number(slot)?, incarnation: number(incarnation)? };
    Ok((run.into(), worker))
}
