use std::ffi::OsString;
use std::path::PathBuf;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use super::channel::{self, Cell, Length, Received, cells, service, service_error};
use super::doorbell::Doorbell;
use super::growing::Grown;
use super::{KEYS, LOOKS_PER_POLL, room, run_directory};
use crate::transport::{
    GeometryInPlace, GrowingGeometry, REPLY_BYTES, TransportError, WakeUp, WorkerEnd, WorkerId,
    attach,
};

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
    wake_up: WakeUp,
}

impl SharedMemoryWorker {
    /// `arguments` are those of [`crate::transport::Attach`] after the first.
    pub fn attach(arguments: &[OsString]) -> Result<Self, TransportError> {
        let [wake_up, run, slot, incarnation] = attach::values(arguments, KEYS)?;
        let wake_up = attach::wake_up(wake_up)?;
        let (slot, incarnation) = (attach::number(slot)?, attach::number(incarnation)?);
        let (run, worker) = (PathBuf::from(run), WorkerId { slot, incarnation });
        let node = channel::node(&run)?;
        let bell = Doorbell::open_to_sleep(&channel::worker_bell(&run, worker))
            .map_err(service_error("open this worker's doorbell"))?;
        let master_bell = Doorbell::open_to_ring(&channel::master_bell(&run))
            .map_err(service_error("open the master's doorbell"))?;
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
        Ok(Self { jobs, replies, master_bell, bell, node, run, wake_up })
    }

    /// What `look` finds as soon as it finds something.
    fn until<T>(
        &self,
        mut look: impl FnMut() -> Result<Option<T>, TransportError>,
    ) -> Result<T, TransportError> {
        loop {
            let found = self.wake_up.search(None, |looked| {
                if looked % LOOKS_PER_POLL == LOOKS_PER_POLL - 1 && self.has_master_gone()? {
                    return look()?.map(Some).ok_or(TransportError::MasterGone);
                }
                look()
            })?;
            if let Some(found) = found {
                return Ok(found);
            }
            let mut found = None;
            let last_look = || {
                found = look().transpose();
                found.is_some()
            };
            self.bell.sleep(&[], None, last_look).map_err(service_error("wait for the master"))?;
            if let Some(found) = found {
                return found;
            }
            if self.has_master_gone()? {
                return look()?.ok_or(TransportError::MasterGone);
            }
        }
    }

    fn has_master_gone(&self) -> Result<bool, TransportError> {
        self.bell.has_ended().map_err(service_error("wait for the master"))
    }

    fn subscribe(
        &self,
        mesh: u32,
    ) -> Result<Option<Subscriber<ipc::Service, [Cell], Length>>, TransportError> {
        if !channel::geometry_notice(&self.run, mesh).exists() {
            return Ok(None);
        }
        let service = service(&self.node, &channel::geometry_name(mesh))?
            .publish_subscribe::<[Cell]>()
            .user_header::<Length>()
            .open()
            .map_err(service_error(format!("open the service of mesh {mesh}")))?;
        let subscriber = service.subscriber_builder().create();
        subscriber.map(Some).map_err(service_error(format!("subscribe to mesh {mesh}")))
    }
}

impl WorkerEnd for SharedMemoryWorker {
    type Message = JobMessage;

    fn receive(&mut self) -> Result<JobMessage, TransportError> {
        let job = self.until(|| self.jobs.receive().map_err(service_error("receive a job")))?;
        Received::new(job)
    }

    fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError> {
        self.until(|| {
            let receivers = channel::send(&self.replies, parts, REPLY_BYTES)?;
            Ok((receivers == 1).then_some(()))
        })?;
        // Nobody there to be woken is seen by who receives.
        let _ = self.master_bell.ring_if_asleep();
        Ok(())
    }
}

impl GrowingGeometry for SharedMemoryWorker {
    type Growing = Grown;

    fn growing(&mut self, number: u32) -> Result<Grown, TransportError> {
        Grown::open(&self.run, number)
    }
}

impl GeometryInPlace for SharedMemoryWorker {
    type Geometry = Image;

    fn geometry(&mut self, mesh: u32) -> Result<Image, TransportError> {
        let subscriber = self.until(|| self.subscribe(mesh))?;
        // The image comes when the master knows of this subscriber.
        self.master_bell.add_port().map_err(|_| TransportError::MasterGone)?;
        let receive = || subscriber.receive().map_err(service_error("receive a mesh"));
        Received::new(self.until(receive)?)
    }
}
