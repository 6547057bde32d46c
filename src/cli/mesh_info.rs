//! `bumper mesh info`: what is in mesh files.

use super::args::MeshInfoArgs;
use super::failure::Failure;
use super::terminal;
use crate::mesh::report::MeshReport;

/// Reports on every mesh that can be loaded; fails if there was one that cannot.
pub(super) fn run(args: &MeshInfoArgs) -> Result<(), Failure> {
    terminal::log_to_stderr()?;
    let mut reports = Vec::new();
    let mut errors = Vec::new();
    for source in &args.meshes {
        match MeshReport::load(source) {
            Ok(report) => reports.push(report),
            Err(error) => errors.push(error.to_string()),
        }
    }
    terminal::print(&if args.json {
        serde_json::to_string_pretty(&reports)? + "\n"
    } else {
        as_text(&reports)
    })?;
    if errors.is_empty() {
        return Ok(());
    }
    // Each begins as the first one will.
    Err(Failure::Failed(anyhow::anyhow!(errors.join("\nerror: "))))
}

/// An empty line between two reports.
fn as_text(reports: &[MeshReport]) -> String {
    reports.iter().map(|report| format!("{report}\n")).collect::<Vec<_>>().join("\n")
}
