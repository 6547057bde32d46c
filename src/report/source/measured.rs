//! `experiment.json` and `cluster.json`: they bring their figures and tables with them.

use serde::Deserialize;

use super::{ReadFile, Shown, SourceError};
use crate::report::figure::{Figure, Table};

#[derive(Deserialize)]
struct Measured {
    kind: String,
    name: String,
    #[serde(default)]
    notes: Vec<String>,
    figures: Vec<Figure>,
    tables: Vec<Table>,
}

pub(super) fn show(file: &ReadFile<'_>, expected: &'static str) -> Result<Shown, SourceError> {
    let Measured { kind, name, notes, figures, tables } = file.parse()?;
    if kind != expected {
        return Err(SourceError::Kind { path: file.path.clone(), found: kind, expected });
    }
    let heading = match expected {
        "cluster" => format!("Simulated cluster: {name}"),
        _ => format!("Experiment: {name}"),
    };
    let drawings = figures.into_iter().map(Into::into).collect();
    Ok(Shown { heading, notes, drawings, tables })
}
