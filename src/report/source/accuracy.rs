//! `accuracy.json`.

use serde::Deserialize;

use super::{Body, ReadFile, Shown, SourceError, table, unfinished};
use crate::geometry::TriangleTest;
use crate::report::Drawing;
use crate::report::accuracy_plot::{self, AccuracyPlot, Mark};
use crate::report::figure::{Axis, Figure, Point, Series, number};
use crate::tree::Accuracy;

#[derive(Deserialize)]
struct Report {
    scenarios: u64,
    scenarios_asked: u64,
    simd: String,
    levels: Vec<Level>,
    scene: Scene,
}

#[derive(Deserialize)]
struct Scene {
    fixed: Body,
    moving: Body,
    tree: String,
}

#[derive(Deserialize)]
struct Level {
    #[serde(deserialize_with = "level")]
    level: Accuracy,
    time_us: Times,
    over_exact: f64,
    false_hits: u32,
    false_misses: u32,
    missing: u64,
    extra: u64,
    wrong_pairs: f64,
    contact_error_m: Option<ContactErrors>,
}

#[derive(Deserialize)]
struct Times {
    mean: f64,
    median: f64,
    p99: f64,
}

#[derive(Deserialize)]
struct ContactErrors {
    median: f64,
    worst: f64,
}

fn level<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Accuracy, D::Error> {
    let text = String::deserialize(deserializer)?;
    text.parse().map_err(serde::de::Error::custom)
}

pub(super) fn show(file: &ReadFile<'_>) -> Result<Shown, SourceError> {
    let report: Report = file.parse()?;
    let Scene { fixed, moving, tree } = &report.scene;
    let names = format!("{} against {}", fixed.name(), moving.name());
    let title = format!("{names}: {} scenarios, {tree} trees, {}", report.scenarios, report.simd);
    let plot = AccuracyPlot { title, marks: report.levels.iter().map(mark).collect() };
    let mut drawings = vec![Drawing::Accuracy(plot)];
    drawings.push(by_depth(&report.levels).into());
    let columns = [
        "level",
        "mean (us)",
        "median (us)",
        "p99 (us)",
        "over exact",
        "false hits",
        "false misses",
        "pairs missing",
        "pairs extra",
        "contact error: median (m)",
        "worst (m)",
    ];
    Ok(Shown {
        heading: format!("Accuracy: {names}"),
        notes: unfinished(report.scenarios, report.scenarios_asked),
        drawings,
        tables: vec![table("Every level", &columns, report.levels.iter().map(cells).collect())],
    })
}

fn cells(row: &Level) -> Vec<String> {
    let metres = |error: Option<f64>| error.map_or_else(String::new, number);
    let error = row.contact_error_m.as_ref();
    let numbers = [
        row.time_us.mean,
        row.time_us.median,
        row.time_us.p99,
        row.over_exact,
        f64::from(row.false_hits),
        f64::from(row.false_misses),
        row.missing as f64,
        row.extra as f64,
    ];
    let errors = [error.map(|error| error.median), error.map(|error| error.worst)];
    let numbers = numbers.map(number).into_iter().chain(errors.map(metres));
    [row.level.to_string()].into_iter().chain(numbers).collect()
}

fn mark(row: &Level) -> Mark {
    let group = match row.level {
        Accuracy::BoxesAt(_) => 4,
        Accuracy::Pairs(TriangleTest::Boxes) => 0,
        Accuracy::Pairs(TriangleTest::F32) => 1,
        Accuracy::Pairs(TriangleTest::F64) => 3,
        Accuracy::Pairs(TriangleTest::Exact) => accuracy_plot::EXACT,
    };
    let (name, error) = (row.level.to_string(), row.wrong_pairs);
    Mark { name, time_us: row.time_us.mean, error, group }
}

/// The sweep of depths, and what looks at triangles, which has no depth, as lines across.
fn by_depth(levels: &[Level]) -> Figure {
    let mut sweep = Vec::new();
    for row in levels {
        if let Accuracy::BoxesAt(depth) = row.level {
            sweep.push(Point::at(f64::from(depth.get()), row.time_us.mean));
        }
    }
    sweep.sort_by(|a, b| a.x.total_cmp(&b.x));
    let deepest = sweep.last().map_or(1.0, |last| last.x);
    let mut series = vec![Series { name: "boxes(depth)".to_owned(), points: sweep }];
    for row in levels {
        if let Accuracy::Pairs(_) = row.level {
            let points = [0.0, deepest].map(|depth| Point::at(depth, row.time_us.mean)).to_vec();
            series.push(Series { name: row.level.to_string(), points });
        }
    }
    Figure {
        name: "depth".to_owned(),
        title: "What stopping at a depth of both trees saves".to_owned(),
        x: Axis::linear("depth"),
        y: Axis::log("processor time of a scenario, mean (us)"),
        series,
    }
}
