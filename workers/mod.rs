//! The worker: the paper's remote client (section 6.4.2), as a process of its own or as a thread of
//! the master.

mod bookmark;
pub mod clock;
pub mod echo;
mod peers;
mod remote_client;
mod result_buffer;
mod role;
mod tree_store;

use std::ffi::{OsStr, OsString};
use std::io;
use std::process::ExitCode;
use std::str::FromStr;

use crate::transport::{
    Attached, GeometryInPlace, GrowingGeometry, TransportError, WorkerEnd, attach, descriptors,
};
use crate::tree::ImageError;
use crate::tree::descent::DescentError;
use crate::tree::subtree::SubtreeError;
use crate::wire::WireError;
pub use bookmark::Bookmark;
pub use role::Role;
use tree_store::{InNode, Received, Shared};

/// First argument of `worker`: process id of the master, without which a worker does not live.
pub const MASTER_ARGUMENT: &str = "--master";
/// Second argument: the worker's [`Role`].
pub const ROLE_ARGUMENT: &str = "--role";
/// Third argument: the inherited descriptor of its [`Bookmark`].
pub const BOOKMARK_ARGUMENT: &str = "--bookmark";

#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    #[error("bumper starts its workers itself; `worker` is not for use by hand")]
    Usage,
    #[error("the master has gone")]
    MasterGone,
    #[error("cannot map the bookmark: {0}")]
    Bookmark(#[source] io::Error),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("a message from the master: {0}")]
    Wire(#[from] WireError),
    #[error("tree {tree}: {source}")]
    Image { tree: u32, source: ImageError },
    #[error("tree {tree}: {source}")]
    Subtree { tree: u32, source: SubtreeError },
    #[error("tree {0} is not here, or was added before")]
    Tree(u32),
    #[error("a job is said to be where none is")]
    Elsewhere,
    #[error("plan {0} is not the one that is here")]
    Plan(u32),
    #[error(transparent)]
    Descent(#[from] DescentError),
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
    let [master_key, master, role_key, role, bookmark_key, bookmark, arguments @ ..] = arguments
    else {
        return Err(WorkerError::Usage);
    };
    if [master_key, role_key, bookmark_key] != [MASTER_ARGUMENT, ROLE_ARGUMENT, BOOKMARK_ARGUMENT] {
        return Err(WorkerError::Usage);
    }
    live_and_die_with(number(master)?)?;
    let role = number(role)?;
    let bookmark = Bookmark::open(descriptors::inherited(bookmark, libc::S_IFREG)?)
        .map_err(WorkerError::Bookmark)?;
    match attach(arguments)? {
        Attached::SharedMemory(transport) => serve_in_place(transport, role, &bookmark),
        Attached::Node(transport) => serve_in_node(transport, role, &bookmark),
        Attached::Stream(transport) => serve_received(transport, role, &bookmark),
    }
}

fn number<T: FromStr>(text: &OsStr) -> Result<T, WorkerError> {
    text.to_str().and_then(|text| text.parse().ok()).ok_or(WorkerError::Usage)
}

/// Ctrl-C and the like are the master's business, and the kernel ends this process when the master ends.
fn live_and_die_with(master: i32) -> Result<(), WorkerError> {
    // SAFETY: sets a signal's disposition and a process attribute; touches no memory.
    let parent = unsafe {
        for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
            libc::signal(signal, libc::SIG_IGN);
        }
        libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
        libc::getppid()
    };
    // It may have died before the line above could take note.
    if parent == master { Ok(()) } else { Err(WorkerError::MasterGone) }
}

/// Works on trees that lie where the master published them, until it is told to end.
pub fn serve_in_place<W: GeometryInPlace>(
    mut transport: W,
    role: Role,
    bookmark: &Bookmark,
) -> Result<(), WorkerError> {
    match role {
        Role::Compute(slowdown) => {
            let mut store = Shared::<W::Geometry>::default();
            remote_client::serve(&mut transport, &mut store, slowdown, bookmark)
        }
        Role::Echo { core } => {
            let mut place = echo::InPlace::<W::Geometry>(None);
            echo::serve(&mut transport, &mut place, core)
        }
    }
}

/// Works on trees that grow where the leader of its node has them, until it is told to end.
fn serve_in_node<W: GrowingGeometry>(
    mut transport: W,
    role: Role,
    bookmark: &Bookmark,
) -> Result<(), WorkerError> {
    match role {
        Role::Compute(slowdown) => {
            let mut store = InNode::<W::Growing>::default();
            remote_client::serve(&mut transport, &mut store, slowdown, bookmark)
        }
        Role::Echo { .. } => Err(WorkerError::Usage),
    }
}

/// Works on subtrees that it was sent, until it is told to end.
pub fn serve_received<W: WorkerEnd>(
    mut transport: W,
    role: Role,
    bookmark: &Bookmark,
) -> Result<(), WorkerError> {
    match role {
        Role::Compute(slowdown) => {
            remote_client::serve(&mut transport, &mut Received::default(), slowdown, bookmark)
        }
        Role::Echo { core } => echo::serve(&mut transport, &mut echo::Nowhere, core),
    }
}
