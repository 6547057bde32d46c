//! What a run leaves behind: the figures, and the files of an output directory.

pub mod accuracy_plot;
mod cost_fit;
pub mod figure;
mod machine;
mod output;
mod parquet;
mod scenarios_csv;
mod summary;
mod tally;
mod tree_costs;

pub use cost_fit::CostFit;
pub use machine::Machine;
pub use output::{DEFORMED, OutputDir, OutputError, Outputs, ResultFiles, SCENE};
pub use summary::{MeshSummary, SceneSummary, Summary, Times, Versions};
pub use tally::{ComputeTimes, EffectSummary, Tally};
pub use tree_costs::TreeCosts;
