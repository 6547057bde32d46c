//! A cluster in simulation: the scheduler as it is, against clients by discrete events.

pub mod config;
mod events;
mod load;
mod machine;
mod memory;
mod outcome;
mod presentation;
mod processors;
pub mod record;
pub mod recording;
mod saturation;
mod scale;
mod simulation;
pub mod sweep;
pub mod validate;

pub use machine::Copies;
pub use outcome::{MemoryUse, Outcome, Utilisation};
pub use presentation::{figures, line, saturations, tables};
pub use saturation::Saturation;
