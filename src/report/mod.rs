//! What a run leaves behind: the figures, and the files of an output directory.

mod machine;
mod output;
mod parquet;
mod scenarios_csv;
mod summary;
mod tally;

pub use machine::Machine;
pub use output::{OutputDir, OutputError, ResultFiles};
pub use summary::{MeshSummary, Summary, Times, Versions};
pub use tally::{ComputeTimes, Tally};
