//! Simulated runs as figures and tables: those of figures 10 to 13 of the paper.

use super::config::Config;
use super::saturation::{Saturation, by_workers};
use super::sweep::{Simulated, Varied};
use crate::report::figure::{Axis, Figure, Point, Series, Table, number};

/// What a sweep is called, in files and for people, and its x axis.
struct Words {
    stem: &'static str,
    title: &'static str,
    x: &'static str,
}

fn words(varied: Varied) -> Words {
    let [stem, title, x] = match varied {
        Varied::Nothing => ["run", "as configured", "scenarios"],
        Varied::Scenarios => ["scenarios", "by amount of scenarios", "scenarios"],
        Varied::Depth => ["depth", "by depth of distribution", "d of the fixed tree"],
        Varied::Buffer => ["buffer", "by size of the scenarios' buffer", "q, scenarios"],
        Varied::Units => ["units", "by processing units", "weighted cores"],
    };
    Words { stem, title, x }
}

/// The name of a run's series: whatever there is more than one of.
fn series_name(config: &Config, run: &Simulated) -> String {
    let mut parts = Vec::new();
    if config.run.matchmakers.len() > 1 {
        parts.push(run.matchmaker.name().to_owned());
    }
    if config.run.copies.len() > 1 {
        parts.push(format!("a copy a {}", run.copies.name()));
    }
    if config.run.compression.len() > 1 {
        parts.push(match run.compression {
            crate::scene::Compression::None => "plain".to_owned(),
            packed => packed.name().to_owned(),
        });
    }
    if config.run.subtrees_from.len() > 1 {
        parts.push(format!("from {}", run.subtrees_from.name()));
    }
    match parts.is_empty() {
        true => run.matchmaker.name().to_owned(),
        false => parts.join(", "),
    }
}

/// What a run is, and what came of it, in a line.
pub fn line(config: &Config, run: &Simulated) -> String {
    let Simulated { workers, scenarios, depths, buffer_scenarios, .. } = run;
    format!(
        "simulated: {workers} workers, {scenarios} scenarios, d = {}, q = {buffer_scenarios}, {}: \
         speedup {:.1}",
        depths[0],
        series_name(config, run),
        run.mean(|outcome| outcome.speedup)
    )
}

fn varied(simulated: &[Simulated]) -> Vec<Varied> {
    let mut varied: Vec<_> = simulated.iter().map(|run| run.varied).collect();
    varied.dedup();
    varied
}

fn of(simulated: &[Simulated], varied: Varied) -> impl Iterator<Item = &Simulated> {
    simulated.iter().filter(move |run| run.varied == varied)
}

/// Two figures a sweep, and what is used of everything over units.
pub fn figures(config: &Config, simulated: &[Simulated]) -> Vec<Figure> {
    let mut figures = Vec::new();
    for varied in varied(simulated).into_iter().filter(|varied| *varied != Varied::Nothing) {
        let runs: Vec<_> = of(simulated, varied).collect();
        figures.push(speedup(config, varied, &runs));
        figures.push(transfer(config, varied, &runs));
    }
    if of(simulated, Varied::Units).next().is_some() {
        figures.push(utilisation(config, simulated));
    }
    figures
}

/// Points of runs that a node's memory is not enough for are left out, as the paper's are.
fn lines(
    config: &Config,
    runs: &[&Simulated],
    value: impl Fn(&super::Outcome) -> f64,
) -> Vec<Series> {
    let finished = runs.iter().filter(|run| !run.is_out_of_memory());
    Series::grouped(finished.map(|run| {
        let point = Point { x: run.x, y: run.mean(&value), spread: run.spread(&value) };
        (series_name(config, run), point)
    }))
}

fn speedup(config: &Config, varied: Varied, runs: &[&Simulated]) -> Figure {
    let Words { stem, title, x } = words(varied);
    let mut series = lines(config, runs, |outcome| outcome.speedup);
    let mut bounds: Vec<_> = runs
        .iter()
        .map(|run| Point::at(run.x, run.mean(|outcome| outcome.speedup_bound)))
        .collect();
    bounds.sort_by(|a, b| a.x.total_cmp(&b.x));
    bounds.dedup();
    series.push(Series { name: "best possible".to_owned(), points: bounds });
    Figure {
        name: format!("{}-{stem}-speedup", config.name),
        title: format!("Speedup {title}, simulated"),
        x: Axis::linear(x),
        y: Axis::linear("speedup over one core, weighted"),
        series,
    }
}

fn transfer(config: &Config, varied: Varied, runs: &[&Simulated]) -> Figure {
    let Words { stem, title, x } = words(varied);
    Figure {
        name: format!("{}-{stem}-transfer", config.name),
        title: format!("Relative data transfer {title}, simulated"),
        x: Axis::linear(x),
        y: Axis::linear("bytes sent over bytes of both trees"),
        series: lines(config, runs, |outcome| outcome.relative_data_transfer),
    }
}

/// Of the first series.
fn utilisation(config: &Config, simulated: &[Simulated]) -> Figure {
    let first = series_name(config, &simulated[0]);
    let all = of(simulated, Varied::Units);
    let runs = by_workers(all.filter(|run| series_name(config, run) == first));
    let line = |name: &str, value: fn(&super::Outcome) -> f64| Series {
        name: name.to_owned(),
        points: runs
            .iter()
            .map(|run| Point::at(run.workers as f64, 100.0 * run.mean(value)))
            .collect(),
    };
    Figure {
        name: format!("{}-units-utilisation", config.name),
        title: format!("What is used of what all workers share ({first}), simulated"),
        x: Axis::linear("workers"),
        y: Axis::linear("used, %"),
        series: vec![
            line("master", |outcome| outcome.utilisation.master),
            line("link", |outcome| outcome.utilisation.link),
            line("fullest memory", |outcome| outcome.memory.fullest),
            line("workers, computing", |outcome| outcome.utilisation.computing),
        ],
    }
}

/// A table a sweep.
pub fn tables(config: &Config, simulated: &[Simulated]) -> Vec<Table> {
    let table = |varied| {
        let runs: Vec<_> = of(simulated, varied).collect();
        Table {
            title: format!("{}, {}", config.name, words(varied).title),
            columns: columns(words(varied).x),
            rows: runs.iter().map(|run| row(config, run)).collect(),
        }
    };
    varied(simulated).into_iter().map(table).collect()
}

fn columns(x: &str) -> Vec<String> {
    let columns = [
        x,
        "workers",
        "series",
        "time, s",
        "speedup",
        "of",
        "over core 1",
        "of",
        "transfer",
        "sent, MB",
        "master, %",
        "waits, %",
        "link, %",
        "workers, %",
        "fullest memory, %",
        "memory, MB",
    ];
    columns.map(str::to_owned).to_vec()
}

fn row(config: &Config, run: &Simulated) -> Vec<String> {
    let mean = |value: fn(&super::Outcome) -> f64| run.mean(value);
    let percent = |value: fn(&super::Outcome) -> f64| format!("{:.0}", 100.0 * run.mean(value));
    let memory = percent(|outcome| outcome.memory.fullest);
    vec![
        number((run.x * 10.0).round() / 10.0),
        run.workers.to_string(),
        series_name(config, run),
        format!("{:.4}", mean(|outcome| outcome.time_s)),
        format!("{:.2}", mean(|outcome| outcome.speedup)),
        format!("{:.1}", mean(|outcome| outcome.speedup_bound)),
        format!("{:.2}", mean(|outcome| outcome.over_first)),
        format!("{:.1}", mean(|outcome| outcome.bound)),
        format!("{:.2}", mean(|outcome| outcome.relative_data_transfer)),
        format!("{:.1}", 1e-6 * mean(|outcome| outcome.bytes_sent)),
        percent(|outcome| outcome.utilisation.master),
        percent(|outcome| outcome.utilisation.master_blocked),
        percent(|outcome| outcome.utilisation.link),
        percent(|outcome| outcome.utilisation.computing),
        if run.is_out_of_memory() { format!("{memory}: not enough") } else { memory },
        format!("{:.0}", 1e-6 * mean(|outcome| outcome.memory.bytes)),
    ]
}

/// Of each series over units, what saturates first.
pub fn saturations(config: &Config, simulated: &[Simulated]) -> Vec<Saturation> {
    let mut names = Vec::new();
    for run in of(simulated, Varied::Units) {
        let name = series_name(config, run);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let saturation = |name: &String| {
        let own = simulated.iter().filter(|run| series_name(config, run) == *name);
        Saturation::of(name, &by_workers(own))
    };
    names.iter().filter_map(saturation).collect()
}
