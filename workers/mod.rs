//! The worker process: the paper's remote client (section 6.4.2).

mod remote_client;
mod result_buffer;

use std::ffi::OsString;
use std::process::ExitCode;

use crate::transport::shared_memory::SharedMemoryWorker;
use crate::transport::{TransportError, WorkerEnd};
use crate::tree::descent::DescentError;
use crate::tree::{Block, ImageError, TreeView};
use crate::wire::{TreeHashes, WireError};
use remote_client::TreePair;

/// Numbers of the two meshes in the transport.
pub const FIXED_MESH: u32 = 0;
pub const MOVING_MESH: u32 = 1;

/// First argument of `worker`: process id of the master, without which a worker does not live.
pub const MASTER_ARGUMENT: &str = "--master";

#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    #[error("bumper starts its workers itself; `worker` is not for use by hand")]
    Usage,
    #[error("the master has gone")]
    MasterGone,
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("a batch from the master: {0}")]
    Wire(#[from] WireError),
    #[error("tree {mesh}: {source}")]
    Image { mesh: u32, source: ImageError },
    #[error(transparent)]
    Descent(#[from] DescentError),
    #[error("tree {mesh} is not a whole number of blocks on a block's boundary")]
    Blocks { mesh: u32 },
}

/// Runs `bumper worker ARGUMENTS…`, whose arguments are what the client manager passes.
pub fn main(arguments: &[OsString]) -> ExitCode {
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("worker: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[OsString]) -> Result<(), WorkerError> {
    let [key, master, attach @ ..] = arguments else { return Err(WorkerError::Usage) };
    let master = master.to_str().and_then(|pid| pid.parse().ok());
    match master {
        Some(master) if key == MASTER_ARGUMENT => live_and_die_with(master)?,
        _ => return Err(WorkerError::Usage),
    }
    serve(SharedMemoryWorker::attach(attach)?)
}

/// Ctrl-C is the master's business, and the kernel ends this process when the master ends.
fn live_and_die_with(master: i32) -> Result<(), WorkerError> {
    // SAFETY: sets a signal's disposition and a process attribute; touches no memory.
    let parent = unsafe {
        libc::signal(libc::SIGINT, libc::SIG_IGN);
        libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
        libc::getppid()
    };
    // It may have died before the line above could take note.
    if parent == master { Ok(()) } else { Err(WorkerError::MasterGone) }
}

fn serve<W: WorkerEnd>(mut transport: W) -> Result<(), WorkerError> {
    let fixed = transport.geometry(FIXED_MESH)?;
    let moving = transport.geometry(MOVING_MESH)?;
    let (fixed, moving) = (view(FIXED_MESH, &fixed)?, view(MOVING_MESH, &moving)?);
    let hashes = TreeHashes { fixed: fixed.hash(), moving: moving.hash() };
    remote_client::serve(&mut transport, hashes, &mut TreePair::new(fixed, moving))
}

/// The tree where it lies, validated.
fn view(mesh: u32, image: &[u8]) -> Result<TreeView<'_>, WorkerError> {
    let blocks: &[Block] =
        bytemuck::try_cast_slice(image).map_err(|_| WorkerError::Blocks { mesh })?;
    TreeView::new(blocks).map_err(|source| WorkerError::Image { mesh, source })
}
