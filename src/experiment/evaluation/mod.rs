//! The paper's evaluation (section 7) on the cores of this machine: what a value that is varied does
//! to the speedup and to the relative data transfer, for each matchmaker, a few samples a point.

mod config;
mod outcome;
mod plan;
mod sample;
mod setup;
pub mod speed;
mod store;

pub use config::{ConfigError, NAMES};
pub use outcome::Outcome;
pub use plan::{Evaluation, Models, Setting, Step, Units, Vary};
pub use sample::{Facts, Loaded, MeasureError, Parallel, Sample, TreeFacts, measure};
pub use setup::setup;
pub use store::{Kept, Store, StoreError};
