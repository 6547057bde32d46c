//! Messages as frames in byte streams, through pipes or sockets. No memory in common: geometry is
//! sent like everything else.
//!
//! Nobody's write ever blocks the master: what a stream does not take at once waits in the
//! master's memory, and goes on its way in `wait`.

mod channel;
mod frame;
mod master;
pub mod pipe;
pub mod socket;
mod worker;

pub use pipe::Pipes;
pub use socket::Sockets;
pub use worker::StreamWorker;
