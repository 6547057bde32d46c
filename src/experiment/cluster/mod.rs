//! A cluster in simulation: the scheduler as it is, against clients by discrete events.

pub mod config;
mod events;
mod load;
mod machine;
mod memory;
mod outcome;
mod processors;
pub mod record;
pub mod recording;
mod scale;
mod simulation;
pub mod sweep;

pub use machine::Copies;
pub use outcome::{MemoryUse, Outcome, Utilisation};
