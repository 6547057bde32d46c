//! Shared memory through iceoryx2: geometry is used in place, messages are written where the
//! other side reads them.
//!
//! | service | pattern | direction |
//! |---|---|---|
//! | `geom/<mesh>` | one sample, history 1 | master to all |
//! | `job/<slot>.<incarnation>` | publish-subscribe | master to one worker |
//! | `reply/<slot>.<incarnation>` | publish-subscribe | one worker to master |
//!
//! Each side sleeps at a doorbell, a FIFO. A service a worker, because iceoryx2 broadcasts within
//! one. Every run has its own name prefix and root directory, and iceoryx2's own clean-up of dead
//! nodes is off everywhere: it loses undelivered results of a killed worker and can hang on
//! half-made files. The run's directory takes everything with it instead.

mod channel;
mod doorbell;
mod master;
mod room;
mod run_directory;
mod worker;

pub use master::SharedMemory;
pub use room::require_room;
pub use run_directory::default_base;
pub use worker::{Image, JobMessage, SharedMemoryWorker};
