//! What a run leaves behind: the figures, and the files of an output directory.

pub mod accuracy_plot;
mod cost_fit;
mod drawing;
pub mod figure;
mod identity;
mod journal;
mod machine;
mod output;
pub mod page;
mod parquet;
mod scenarios_csv;
pub mod source;
mod summary;
mod tally;
mod tree_costs;
pub mod viewer;

pub use cost_fit::CostFit;
pub use drawing::{Drawing, svg_files};
pub use identity::RunIdentity;
pub use machine::Machine;
pub use output::{DEFORMED, OutputDir, OutputError, Outputs, ResultFiles, SCENARIOS, SCENE};
pub use scenarios_csv::Earlier;
pub use summary::{MeshSummary, SceneSummary, Summary, Times, Versions};
pub use tally::{ComputeTimes, EffectSummary, Tally};
pub use tree_costs::TreeCosts;
