//! `bumper check --ccd`: continuous queries, whose truth is known.

use std::path::PathBuf;

use anyhow::{Context, anyhow};

use super::check::{blame, to_json};
use super::failure::Failure;
use super::terminal;
use crate::hardcases::continuous::{QueryReport, QuerySuite, WrongQuery, check};
use crate::report::figure::grouped;

/// Fails if an answer is wrong.
pub(super) fn run(files: &[PathBuf], json: bool) -> Result<(), Failure> {
    let read = files.iter().map(|file| QuerySuite::read(file).map_err(Failure::usage));
    let suites: Vec<QuerySuite> = read.collect::<Result<_, _>>()?;
    let queries = suites.iter().map(|suite| suite.queries.len()).sum();
    let bar = terminal::scenario_bar("checking", queries);
    let report = check(&suites, &|queries| bar.inc(queries));
    bar.finish_and_clear();
    let text = if json { to_json(&report) } else { table(&report) };
    terminal::print(&text).context("cannot print the figures")?;
    if report.wrong.is_empty() {
        return Ok(());
    }
    let place = |one: &WrongQuery| {
        let what = if one.missed { "missed" } else { "extra" };
        format!("{}:{}: {} ({what})", one.suite, one.line, one.source)
    };
    Err(Failure::Failed(anyhow!(blame("answers are wrong", report.wrong.iter().map(place)))))
}

fn table(report: &QueryReport) -> String {
    let widest = report.rows.iter().map(|row| row.source.len()).max().unwrap_or(0).max(8);
    let mut text = format!(
        "{:widest$}{:>9}{:>8}{:>8}{:>12}{:>11}\n",
        "source", "queries", "missed", "extra", "time error", "ns a query"
    );
    for row in report.rows.iter().chain([&report.total]) {
        let error = row.worst_time_error.map_or("-".to_owned(), |error| format!("{error:.1e}"));
        text += &format!(
            "{:widest$}{:>9}{:>8}{:>8}{error:>12}{:>11.0}\n",
            row.source,
            grouped(row.queries.into()),
            grouped(row.missed.into()),
            grouped(row.extra.into()),
            row.mean_ns
        );
    }
    text
}
