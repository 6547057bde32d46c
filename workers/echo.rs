//! A worker that says when it has got what it was handed: for measuring transports.

use bytemuck::{Pod, Zeroable};

use super::WorkerError;
use super::clock::{machine_ns, thread_ns};
use crate::transport::{GeometryInPlace, TransportError, WorkerEnd};
use crate::wire::WireError;

/// Hands something over: by its number where it lies in memory in common, or else by what comes
/// after this header.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Ping {
    /// Its first and its last eight bytes.
    pub ends: [u64; 2],
    pub bytes: u64,
    pub mesh: u32,
    /// 1: it lies in memory in common.
    pub is_in_place: u16,
    /// 1: another follows at once, and only the last is acknowledged.
    pub has_more: u16,
}

/// Got it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Pong {
    /// When its first and its last bytes had been read, by [`machine_ns`].
    pub got_ns: u64,
    /// Of the worker's processor up to then.
    pub thread_ns: u64,
}

impl Pong {
    fn now() -> Self {
        Self { got_ns: machine_ns(), thread_ns: thread_ns() }
    }
}

const _: () = assert!(size_of::<Ping>() == 32 && size_of::<Pong>() == 16);

/// Where what is handed over in place is found.
pub trait Find<W> {
    fn find(&mut self, transport: &mut W, mesh: u32) -> Result<&[u8], TransportError>;
}

/// Looks it up once.
pub struct InPlace<G>(pub Option<(u32, G)>);

impl<W: GeometryInPlace> Find<W> for InPlace<W::Geometry> {
    fn find(&mut self, transport: &mut W, mesh: u32) -> Result<&[u8], TransportError> {
        if self.0.as_ref().is_none_or(|(known, _)| *known != mesh) {
            self.0 = Some((mesh, transport.geometry(mesh)?));
        }
        Ok(&self.0.as_ref().expect("it has just been found").1)
    }
}

/// There is no memory in common.
pub struct Nowhere;

impl<W: WorkerEnd> Find<W> for Nowhere {
    fn find(&mut self, _transport: &mut W, mesh: u32) -> Result<&[u8], TransportError> {
        Err(TransportError::Arguments(format!("mesh {mesh} is not in common memory")))
    }
}

/// An empty message ends it.
pub fn serve<W: WorkerEnd>(
    transport: &mut W,
    place: &mut impl Find<W>,
    core: usize,
) -> Result<(), WorkerError> {
    pin(core);
    transport.send(&[bytemuck::bytes_of(&Pong::now())])?;
    loop {
        let message = transport.receive()?;
        if message.is_empty() {
            return Ok(());
        }
        let needed = size_of::<Ping>();
        let (header, body) = message
            .split_at_checked(needed)
            .ok_or(WireError::Truncated { found: message.len(), needed })?;
        let ping: Ping = bytemuck::pod_read_unaligned(header);
        let got = if ping.is_in_place == 1 { place.find(transport, ping.mesh)? } else { body };
        let ends = ends(got);
        let pong = Pong::now();
        if got.len() as u64 != ping.bytes || ends != ping.ends {
            let described = ping.bytes as usize;
            return Err(WireError::Length { found: got.len(), described }.into());
        }
        if ping.has_more == 0 {
            transport.send(&[bytemuck::bytes_of(&pong)])?;
        }
    }
}

/// The first and the last eight bytes, of at least as many.
pub fn ends(bytes: &[u8]) -> [u64; 2] {
    let eight = |bytes: Option<&[u8; 8]>| bytes.map_or(0, |bytes| u64::from_ne_bytes(*bytes));
    [eight(bytes.first_chunk()), eight(bytes.last_chunk())]
}

/// Keeps this thread on one core, if the machine has it.
pub fn pin(core: usize) {
    // SAFETY: a set of cores may be all zero.
    let mut cores: libc::cpu_set_t = unsafe { std::mem::zeroed() };
    // SAFETY: sets a bit within the set, or nothing; the call reads the set. If there is no such
    // core the call fails, and the thread stays where it likes.
    unsafe {
        libc::CPU_SET(core % libc::CPU_SETSIZE as usize, &mut cores);
        libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &raw const cores);
    }
}
