//! `bench_transport.json` and `bench_engine.json`.

use serde::Deserialize;

use super::{ReadFile, Shown, SourceError, table};
use crate::report::figure::{Axis, Figure, Point, Series, number};

#[derive(Deserialize)]
struct Bench<R> {
    rows: Vec<R>,
}

#[derive(Deserialize)]
struct Latency {
    transport: String,
    wake_up: String,
    bytes: u64,
    count: u64,
    one_way: Quantiles,
    round_trip: Quantiles,
    megabytes_per_s: f64,
}

/// Microseconds.
#[derive(Deserialize)]
struct Quantiles {
    median: f64,
    p99: f64,
    p99_9: f64,
}

#[derive(Deserialize)]
struct Throughput {
    transport: String,
    matchmaker: String,
    workers: u32,
    runs: u32,
    scenarios_per_s: f64,
    over_serial: f64,
    first_result_s: f64,
    start_workers_s: f64,
    relative_data_transfer: f64,
    pre_analysis_us: f64,
    matching_us: f64,
}

pub(super) fn show_transport(file: &ReadFile<'_>) -> Result<Shown, SourceError> {
    let Bench { rows } = file.parse::<Bench<Latency>>()?;
    let series = |value: fn(&Latency) -> f64| {
        Series::grouped(rows.iter().map(|row| {
            let name = format!("{}, {}", row.transport, row.wake_up);
            (name, Point::at(row.bytes as f64, value(row)))
        }))
    };
    let latency = Figure {
        name: "latency".to_owned(),
        title: "Handing a subtree over to a worker".to_owned(),
        x: Axis::log("bytes"),
        y: Axis::log("one way, median (us)"),
        series: series(|row| row.one_way.median),
    };
    let bandwidth = Figure {
        name: "bandwidth".to_owned(),
        title: "Subtrees handed over one after the other, each acknowledged".to_owned(),
        y: Axis::log("MB/s"),
        series: series(|row| row.megabytes_per_s),
        ..latency.clone()
    };
    let columns = [
        "transport",
        "wake-up",
        "bytes",
        "count",
        "one way: median (us)",
        "p99",
        "p99.9",
        "there and back: median (us)",
        "p99",
        "p99.9",
        "MB/s",
    ];
    let cells = |row: &Latency| {
        let Latency { one_way: there, round_trip: back, .. } = row;
        let times = [there, back].map(|times| [times.median, times.p99, times.p99_9]);
        let sizes = [row.bytes as f64, row.count as f64];
        let numbers = sizes.iter().chain(times.as_flattened()).chain([&row.megabytes_per_s]);
        let names = [row.transport.clone(), row.wake_up.clone()];
        names.into_iter().chain(numbers.map(|&value| number(value))).collect()
    };
    Ok(Shown {
        heading: "Bench: transports".to_owned(),
        notes: Vec::new(),
        drawings: vec![latency.into(), bandwidth.into()],
        tables: vec![table("Every combination", &columns, rows.iter().map(cells).collect())],
    })
}

pub(super) fn show_engine(file: &ReadFile<'_>) -> Result<Shown, SourceError> {
    let Bench { rows } = file.parse::<Bench<Throughput>>()?;
    let figure = |name: &str, title: &str, y: &str, value: fn(&Throughput) -> f64| Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        x: Axis::linear("workers"),
        y: Axis::linear(y),
        series: Series::grouped(rows.iter().map(|row| {
            let name = format!("{}, {}", row.transport, row.matchmaker);
            (name, Point::at(f64::from(row.workers), value(row)))
        })),
    };
    let per_second =
        figure("throughput", "Scenarios a second", "scenarios / s", |row| row.scenarios_per_s);
    let speedup = figure(
        "speedup",
        "Speedup over one thread without an engine",
        "times as many scenarios a second",
        |row| row.over_serial,
    );
    let transfer = figure(
        "data_transfer",
        "Relative data transfer",
        "bytes of subtrees sent / bytes of both trees",
        |row| row.relative_data_transfer,
    );
    let columns = [
        "transport",
        "matchmaker",
        "workers",
        "runs",
        "scenarios/s",
        "over serial",
        "start (ms)",
        "first result (ms)",
        "relative data transfer",
        "master, a scenario (us)",
    ];
    let cells = |row: &Throughput| {
        let numbers = [
            f64::from(row.workers),
            f64::from(row.runs),
            row.scenarios_per_s,
            row.over_serial,
            1e3 * row.start_workers_s,
            1e3 * row.first_result_s,
            row.relative_data_transfer,
            row.pre_analysis_us + row.matching_us,
        ];
        let names = [row.transport.clone(), row.matchmaker.clone()];
        names.into_iter().chain(numbers.map(number)).collect()
    };
    Ok(Shown {
        heading: "Bench: engines".to_owned(),
        notes: Vec::new(),
        drawings: vec![per_second.into(), speedup.into(), transfer.into()],
        tables: vec![table("Every combination", &columns, rows.iter().map(cells).collect())],
    })
}
