//! `bumper check`: hard cases, whose truth is known, through everything that answers.

use std::collections::HashMap;
use std::hash::Hash;

use anyhow::{Context, anyhow};
use serde::Serialize;

use super::args::CheckArgs;
use super::check_ccd;
use super::failure::Failure;
use super::terminal;
use crate::hardcases::{Report, Row, Suite, Wrong, check};
use crate::report::figure::grouped;
use crate::report::{Machine, Versions};
use crate::tree::Accuracy;

const SCHEMA_VERSION: u32 = 1;

/// What is printed with `--json`.
#[derive(Serialize)]
struct Json<'a, R> {
    schema_version: u32,
    versions: Versions,
    machine: Machine,
    #[serde(flatten)]
    report: &'a R,
}

/// Fails if an exact answer is wrong; a suite that cannot be read is a usage error, so that the two
/// have different exit codes.
pub(super) fn run(args: &CheckArgs) -> Result<(), Failure> {
    terminal::log_to_stderr()?;
    if !args.ccd.is_empty() {
        return check_ccd::run(&args.ccd, args.json);
    }
    let suites: Vec<Suite> = if args.suite.is_empty() {
        Suite::built_in().into()
    } else {
        let read = args.suite.iter().map(|file| Suite::read(file).map_err(Failure::usage));
        read.collect::<Result<_, _>>()?
    };
    let bar = terminal::scenario_bar("checking", suites.iter().map(Suite::len).sum());
    let report = check(&suites, &|cases| bar.inc(cases));
    bar.finish_and_clear();
    let text = if args.json { to_json(&report) } else { tables(&report) };
    terminal::print(&text).context("cannot print the figures")?;
    if report.wrong.is_empty() {
        return Ok(());
    }
    let place = |one: &Wrong| format!("{}:{}: {} ({})", one.suite, one.line, one.family, one.way);
    let wrong = report.wrong.iter().map(place);
    Err(Failure::Failed(anyhow!(blame("exact answers are wrong", wrong))))
}

pub(super) fn to_json(report: &impl Serialize) -> String {
    let (versions, machine) = (Versions::this(), Machine::this());
    let json = Json { schema_version: SCHEMA_VERSION, versions, machine, report };
    serde_json::to_string_pretty(&json).expect("string keys and plain values") + "\n"
}

/// Wrong answers by family, in the way that is wrong most often, and by way.
fn tables(report: &Report) -> String {
    let heads: String =
        report.levels.iter().map(|level| format!("{:>9}", level.to_string())).collect();
    let mut text = format!("{:28}{:>8}{heads}\n", "wrong, by family", "cases");
    for (family, rows) in together(&report.rows, |row| row.family.as_str()) {
        let cases = rows.iter().map(|row| row.cases).max();
        let cells = cells(report, |level| {
            rows.iter().filter(|row| row.level == level).map(|row| row.wrong).max()
        });
        text += &format!("{family:28}{:>8}{cells}\n", count(cases));
    }
    text += &format!("\n{:28}{:>8}{heads}\n", "wrong, by way", "cases");
    for (way, rows) in together(&report.rows, |row| row.way) {
        let at = |level| rows.iter().filter(move |row| row.level == level);
        let cases: u32 = at(Accuracy::EXACT).map(|row| row.cases).sum();
        let cells =
            cells(report, |level| at(level).map(|row| row.wrong).reduce(|sum, wrong| sum + wrong));
        text += &format!("{:28}{:>8}{cells}\n", way.to_string(), count(Some(cases)));
    }
    text
}

/// The rows of each key, the keys in the order of their first.
fn together<'a, K: Copy + Eq + Hash>(
    rows: &'a [Row],
    key: impl Fn(&'a Row) -> K,
) -> Vec<(K, Vec<&'a Row>)> {
    let mut groups: Vec<(K, Vec<&Row>)> = Vec::new();
    let mut places = HashMap::new();
    for row in rows {
        let key = key(row);
        let place = *places.entry(key).or_insert_with(|| {
            groups.push((key, Vec::new()));
            groups.len() - 1
        });
        groups[place].1.push(row);
    }
    groups
}

/// A number for each level, where there is one.
fn cells(report: &Report, number: impl Fn(Accuracy) -> Option<u32>) -> String {
    report.levels.iter().map(|&level| format!("{:>9}", count(number(level)))).collect()
}

fn count(number: Option<u32>) -> String {
    number.map_or("-".to_owned(), |number| grouped(number.into()))
}

/// The first of what is wrong.
pub(super) fn blame(what: &str, wrong: impl ExactSizeIterator<Item = String>) -> String {
    const SHOWN: usize = 10;
    let count = wrong.len();
    let mut text = format!("{} {what}:", grouped(count as u64));
    for one in wrong.take(SHOWN) {
        text += &format!("\n  {one}");
    }
    if count > SHOWN {
        text += "\n  ...";
    }
    text
}
