//! What an experiment varies, as its file has it.

use serde::Deserialize;

use crate::experiment::evaluation::plan::{Units, Vary};
use crate::scene::{
    Distribution, OutOfRange, SceneError, Slowdown, Source, Spanned, WorkerCount, buffer_scenarios,
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VaryFile {
    serial_percent: Option<Spanned<Vec<i64>>>,
    scenarios_percent: Option<Spanned<Vec<i64>>>,
    depth: Option<Spanned<Vec<i64>>>,
    buffer: Option<Spanned<Vec<i64>>>,
    units: Option<Spanned<Vec<Units>>>,
    slowdown: Option<Spanned<f64>>,
}

/// Exactly one thing is.
pub(super) fn vary(source: &Source<'_>, file: &Spanned<VaryFile>) -> Result<Vary, SceneError> {
    let VaryFile { serial_percent, scenarios_percent, depth, buffer, units, slowdown } =
        file.get_ref();
    if let (Some(slowdown), None) = (slowdown, units) {
        let reason = "is that of the slow ones of `vary.units`, which is missing";
        return Err(source.wrong(slowdown, "vary.slowdown", reason));
    }
    let percent = |key, values| rising(source, key, values, percent);
    match (serial_percent, scenarios_percent, depth, buffer, units) {
        (Some(values), None, None, None, None) => {
            Ok(Vary::SerialPercent(percent("vary.serial_percent", values)?))
        }
        (None, Some(values), None, None, None) => {
            Ok(Vary::ScenariosPercent(percent("vary.scenarios_percent", values)?))
        }
        (None, None, Some(values), None, None) => {
            let depth = |d| Distribution::at_depth(d).map(|_| d as u32);
            Ok(Vary::Depth(rising(source, "vary.depth", values, depth)?))
        }
        (None, None, None, Some(values), None) => {
            Ok(Vary::Buffer(rising(source, "vary.buffer", values, buffer_scenarios)?))
        }
        (None, None, None, None, Some(units)) => vary_units(source, units, slowdown.as_ref()),
        _ => {
            let reason = "has to say one thing that is varied: `serial_percent`, \
                          `scenarios_percent`, `depth`, `buffer` or `units`";
            Err(source.wrong(file, "vary", reason))
        }
    }
}

fn percent(n: i64) -> Result<u32, String> {
    let valid = (1..=100).contains(&n);
    if valid { Ok(n as u32) } else { Err(format!("{n} is not a percentage from 1 to 100")) }
}

/// Each value checked; there is one, and each is greater than the one before.
fn rising<T, E: std::fmt::Display>(
    source: &Source<'_>,
    key: &str,
    values: &Spanned<Vec<i64>>,
    check: impl Fn(i64) -> Result<T, E>,
) -> Result<Vec<T>, SceneError> {
    let numbers = values.get_ref();
    if numbers.is_empty() || !numbers.windows(2).all(|pair| pair[0] < pair[1]) {
        let reason = "is not a list of one or more numbers, each greater than the one before";
        return Err(source.wrong(values, key, reason));
    }
    let checked = numbers.iter().map(|&n| check(n)).collect::<Result<_, _>>();
    checked.map_err(|error| source.wrong(values, key, error))
}

fn vary_units(
    source: &Source<'_>,
    units: &Spanned<Vec<Units>>,
    slowdown: Option<&Spanned<f64>>,
) -> Result<Vary, SceneError> {
    let wrong = |reason: String| source.wrong(units, "vary.units", reason);
    let all = units.get_ref();
    if all.is_empty() {
        return Err(wrong("is empty: write one or more, as `{ fast = 2, slow = 1 }`".to_owned()));
    }
    for (index, one) in all.iter().enumerate() {
        let workers = i64::from(one.fast) + i64::from(one.slow);
        WorkerCount::new(workers).map_err(|error: OutOfRange| wrong(error.to_string()))?;
        if all[..index].contains(one) {
            return Err(wrong(format!("has {} fast and {} slow ones twice", one.fast, one.slow)));
        }
    }
    if slowdown.is_none() && all.iter().any(|one| one.slow > 0) {
        return Err(wrong("has slow ones: say with `vary.slowdown` how slow".to_owned()));
    }
    let slowdown = source.checked(slowdown, "vary.slowdown", Slowdown::NONE, Slowdown::new)?;
    Ok(Vary::Units { units: all.clone(), slowdown })
}
