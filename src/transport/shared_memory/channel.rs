//! What both ends agree on: names, types, and how a message lies in a sample.

use std::fmt::Debug;
use std::mem::MaybeUninit;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::service::builder::Builder;

use super::doorbell::Place;
use super::room::{SHARED_MEMORY_DIRECTORY, explain_missing_pages, populate};
use super::run_directory;
use crate::transport::{REPLY_BYTES, TransportError, WorkerId};

/// Element of every payload. A slice of these, unlike one of bytes with an alignment, costs no
/// more memory than it holds.
#[derive(Clone, Copy, Debug, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[repr(align(64))]
#[type_name("bumper.Cell")]
pub struct Cell([u8; 64]);

/// User header of every sample: its bytes, the rest of the last cell being padding.
#[derive(Clone, Copy, Debug, Default, ZeroCopySend)]
#[repr(C)]
#[type_name("bumper.Length")]
pub struct Length {
    bytes: u64,
}

/// Replies that wait in the queue to the master before the worker has to.
pub const QUEUED_REPLIES: usize = 8;

pub fn cells(bytes: usize) -> usize {
    bytes.div_ceil(size_of::<Cell>())
}

pub fn service_error<E: Debug>(action: impl Into<String>) -> impl FnOnce(E) -> TransportError {
    let action = action.into();
    move |error| TransportError::Service { action, reason: format!("{error:?}") }
}

/// A node of the run in `directory`, independent of any configuration file of iceoryx2.
pub fn node(directory: &Path) -> Result<Node<ipc::Service>, TransportError> {
    set_log_level(LogLevel::Fatal);
    explain_missing_pages();
    let prefix = run_directory::prefix(directory)
        .ok_or_else(|| TransportError::Arguments(directory.display().to_string()))?;
    let root = directory.join("services");
    let mut config = Config::default();
    config.global.prefix =
        FileName::new(prefix.as_bytes()).map_err(service_error("use the run's prefix"))?;
    config.global.set_root_path(
        &iceoryx2::prelude::Path::new(root.as_os_str().as_encoded_bytes())
            .map_err(service_error("use the run's directory"))?,
    );
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .map_err(service_error("create an iceoryx2 node"))
}

/// Builder of the service of that name.
pub fn service(
    node: &Node<ipc::Service>,
    name: &str,
) -> Result<Builder<ipc::Service>, TransportError> {
    let name = name.try_into().map_err(service_error(format!("name a service {name}")))?;
    Ok(node.service_builder(&name))
}

pub fn geometry_name(mesh: u32) -> String {
    format!("geom/{mesh}")
}

pub fn job_name(worker: WorkerId) -> String {
    format!("job/{worker}")
}

pub fn reply_name(worker: WorkerId) -> String {
    format!("reply/{worker}")
}

/// Doorbell of a worker.
pub fn worker_bell(run: &Path, worker: WorkerId) -> Place {
    bell(run, &worker.to_string())
}

pub fn master_bell(run: &Path) -> Place {
    bell(run, "master")
}

/// The page lies in shared memory: it must cost no writing to a disk.
fn bell(run: &Path, who: &str) -> Place {
    let prefix = run_directory::prefix(run).unwrap_or_default();
    let page = Path::new(SHARED_MEMORY_DIRECTORY).join(format!("{prefix}wake-{who}"));
    Place { fifo: run.join(format!("wake-{who}")), page }
}

/// There while the mesh can be had. A worker must not open the service earlier: a subscriber made
/// before the publisher was could be killed while both make their connection, and iceoryx2 0.10
/// waits for ever on a connection that is half made. All other ports are registered only when
/// their connections are whole.
pub fn geometry_notice(run: &Path, mesh: u32) -> PathBuf {
    run.join(format!("mesh-{mesh}"))
}

/// Writes the parts one after the other where the receivers will read them. Returns how many
/// receivers there are.
pub fn send(
    publisher: &Publisher<ipc::Service, [Cell], Length>,
    parts: &[&[u8]],
    limit: usize,
) -> Result<usize, TransportError> {
    let bytes: usize = parts.iter().map(|part| part.len()).sum();
    if bytes > limit {
        return Err(TransportError::TooLong { bytes, limit });
    }
    let mut loan =
        publisher.loan_slice_uninit(cells(bytes).max(1)).map_err(service_error("loan a sample"))?;
    let payload = as_bytes(loan.payload_mut());
    // What a message lies in has been reserved; only for an image is one call cheaper than its many
    // first touches.
    if bytes > REPLY_BYTES {
        populate(payload.as_mut_ptr().cast(), payload.len()).map_err(|error| {
            TransportError::Service {
                action: format!("write {bytes} bytes to shared memory"),
                reason: error.to_string(),
            }
        })?;
    }
    let (message, padding) = payload.split_at_mut(bytes);
    gather(parts, message);
    padding.fill(MaybeUninit::new(0));
    loan.user_header_mut().bytes = bytes as u64;
    // SAFETY: parts and padding together filled every byte.
    let sample = unsafe { loan.assume_init() };
    sample.send().map_err(service_error("send a sample"))
}

fn as_bytes(cells: &mut [MaybeUninit<Cell>]) -> &mut [MaybeUninit<u8>] {
    let bytes = size_of_val(cells);
    // SAFETY: the same memory, and a byte that may be uninitialized has no other demands.
    unsafe { std::slice::from_raw_parts_mut(cells.as_mut_ptr().cast(), bytes) }
}

fn gather(parts: &[&[u8]], mut target: &mut [MaybeUninit<u8>]) {
    for part in parts {
        let (head, rest) = target.split_at_mut(part.len());
        head.write_copy_of_slice(part);
        target = rest;
    }
}

/// A received sample, used where it lies; returned to its sender when dropped.
#[derive(Debug)]
pub struct Received(Sample<ipc::Service, [Cell], Length>);

impl Received {
    /// Refuses a length that the payload does not have.
    pub fn new(sample: Sample<ipc::Service, [Cell], Length>) -> Result<Self, TransportError> {
        let (bytes, room) = (sample.user_header().bytes, size_of_val(sample.payload()));
        if usize::try_from(bytes).is_ok_and(|bytes| bytes <= room) {
            return Ok(Self(sample));
        }
        let reason = format!("its header says {bytes} bytes, it has {room}");
        Err(TransportError::Service { action: "read a sample".to_owned(), reason })
    }
}

impl Deref for Received {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &bytemuck::cast_slice(self.0.payload())[..self.0.user_header().bytes as usize]
    }
}
