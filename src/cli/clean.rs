//! `bumper clean`: removes what killed runs left, and touches no living one.

use std::fmt::Write;

use anyhow::anyhow;
use serde_json::{Value, json};

use super::args::CleanArgs;
use super::failure::Failure;
use super::terminal;
use crate::report::figure::grouped;
use crate::transport::shared_memory::{Leftovers, default_base, remove_leftovers};

/// Fails if there was something dead that cannot be removed; all the rest is removed first.
pub(super) fn run(args: &CleanArgs) -> Result<(), Failure> {
    terminal::log_to_stderr()?;
    let found = remove_leftovers(&default_base())?;
    terminal::print(&if args.json {
        serde_json::to_string_pretty(&as_json(&found))? + "\n"
    } else {
        as_text(&found)
    })?;
    if found.failures.is_empty() {
        return Ok(());
    }
    let failures = found.failures.iter();
    let failures: Vec<String> = failures
        .map(|f| format!("{}: cannot be removed: {}", f.path.display(), f.reason))
        .collect();
    Err(Failure::Failed(anyhow!(failures.join("\nerror: "))))
}

fn as_text(found: &Leftovers) -> String {
    let count = |number: u32, what: &str| {
        format!("{} {what}{}", grouped(number.into()), if number == 1 { "" } else { "s" })
    };
    let mut text = match found.runs {
        0 => "removed nothing: no run has left anything\n".to_owned(),
        runs => format!(
            "removed {} and {} bytes of {} that died\n",
            count(found.files, "file"),
            grouped(found.bytes),
            count(runs, "run"),
        ),
    };
    for run in &found.living {
        let (files, bytes) = (count(run.files, "file"), grouped(run.bytes));
        let path = run.path.display();
        writeln!(text, "kept {files} and {bytes} bytes of {path}: that run is alive")
            .expect("writing to a string does not fail");
    }
    text
}

fn as_json(found: &Leftovers) -> Value {
    let living = found.living.iter().map(
        |run| json!({ "run": run.path.to_string_lossy(), "files": run.files, "bytes": run.bytes }),
    );
    let failures = found.failures.iter().map(|failure| {
        json!({ "path": failure.path.to_string_lossy(), "reason": failure.reason.to_string() })
    });
    json!({
        "removed": { "runs": found.runs, "files": found.files, "bytes": found.bytes },
        "living": living.collect::<Vec<_>>(),
        "failures": failures.collect::<Vec<_>>(),
    })
}
