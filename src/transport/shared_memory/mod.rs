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

pub const NAME: &str = "iceoryx2";
/// Of workers whose master is not the run's but the leader of their node: the trees that it has
/// grow as they are needed.
pub const NODE: &str = "iceoryx2-node";

const KEYS: [&str; 4] = ["--wake-up", "--run", "--slot", "--incarnation"];

/// Who looks for messages without end looks at descriptors only now and then.
const LOOKS_PER_POLL: u32 = 256;

mod channel;
mod doorbell;
mod growing;
mod master;
mod room;
mod run_directory;
mod worker;

pub use growing::{Growing, Grown};
pub use master::SharedMemory;
pub use room::require_room;
pub use run_directory::{Leftovers, LivingRun, NotRemoved, default_base, remove_leftovers};
pub use worker::{Image, JobMessage, SharedMemoryWorker};
