//! `summary.json` and the `scenarios.csv` beside it.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::scenarios::{Column, Scenarios};
use super::{Body, ReadFile, Shown, SourceError, listed, table, unfinished};
use crate::report::Drawing;
use crate::report::figure::{Axis, Figure, Point, Scale, Series, Table, grouped, number};

#[derive(Deserialize)]
struct Run {
    accuracy: String,
    scenarios: u64,
    scenarios_asked: u64,
    #[serde(default)]
    answered_before: u64,
    colliding: u64,
    pairs: u64,
    set_aside: Vec<u32>,
    transport: String,
    matchmaker: String,
    simd: String,
    bytes_published: u64,
    bytes_copied: u64,
    relative_data_transfer: f64,
    scenarios_per_s: f64,
    /// By the names of `summary.json`: a stage that a version does not have is not shown.
    time: BTreeMap<String, f64>,
    compute_us: ComputeTimes,
    effects: Vec<Effect>,
    #[serde(default)]
    tree_costs: Vec<TreeCosts>,
    worker_reports: Vec<Worker>,
    scene: Bodies,
    fixed: Mesh,
    moving: Mesh,
}

#[derive(Deserialize)]
struct Bodies {
    fixed: Body,
    moving: Body,
}

#[derive(Deserialize)]
struct Mesh {
    triangles: u64,
    tree_bytes: u64,
}

#[derive(Deserialize)]
struct ComputeTimes {
    mean: f64,
    median: f64,
    p99: f64,
    max: f64,
    /// At 0, 10, ..., 100 %.
    #[serde(default)]
    deciles: Vec<f64>,
}

#[derive(Deserialize)]
struct Effect {
    effect: String,
    scenarios: u64,
    compute_s: f64,
    mean_us: f64,
    work: u64,
    work_unit: String,
}

#[derive(Deserialize)]
struct Worker {
    scenarios: u64,
    batches: u64,
    compute_s: f64,
    geometry_bytes_copied: u64,
    message_bytes: u64,
    restarts: u64,
}

#[derive(Deserialize)]
struct TreeCosts {
    tree: String,
    n_b: u64,
    n_p: u64,
    descent_s: f64,
    fit: Option<Fit>,
}

#[derive(Deserialize)]
struct Fit {
    c_b_ns: f64,
    c_p_ns: f64,
    mean_relative_error: f64,
}

/// Of `time` in the summary, the last two within the one before them.
const STAGES: [(&str, &str); 8] = [
    ("load", "load_s"),
    ("build", "build_s"),
    ("poses", "poses_s"),
    ("publish", "publish_s"),
    ("start workers", "start_workers_s"),
    ("scenarios", "scenarios_s"),
    ("pre-analysis", "pre_analysis_s"),
    ("matching", "matching_s"),
];

pub(super) fn show(file: &ReadFile<'_>) -> Result<Shown, SourceError> {
    let run: Run = file.parse()?;
    let path = file.folder.join("scenarios.csv");
    let scenarios = Scenarios::read(&path)?;
    if scenarios.rows != run.scenarios {
        let (found, expected) = (scenarios.rows, run.scenarios);
        return Err(SourceError::Scenarios { path, found, expected });
    }
    let pairs = scenarios.numbers("pairs");
    let drawings = [
        Some(compute_times(&run.compute_us)),
        (!pairs.is_empty()).then(|| pairs_of_scenarios(pairs)),
        (!run.worker_reports.is_empty()).then(|| workers(&run.worker_reports)),
        Some(stages(&run.time)),
        effects(&run.effects),
    ];
    let tables = [
        Some(totals(&run)),
        Some(worker_table(&run.worker_reports)),
        Some(effect_table(&run.effects)),
        (!run.tree_costs.is_empty()).then(|| cost_table(&run.tree_costs)),
        Some(column_table(&scenarios.columns)),
        word_table(&scenarios.columns),
    ];
    Ok(Shown {
        heading: format!("Run: {} against {}", run.scene.fixed.name(), run.scene.moving.name()),
        notes: notes(&run),
        drawings: drawings.into_iter().flatten().map(Drawing::from).collect(),
        tables: tables.into_iter().flatten().collect(),
    })
}

fn notes(run: &Run) -> Vec<String> {
    let mut notes = unfinished(run.scenarios, run.scenarios_asked);
    if run.answered_before > 0 {
        let before = grouped(run.answered_before);
        notes.push(format!("{before} scenarios are an earlier run's: times are of the others"));
    }
    if !run.set_aside.is_empty() {
        let count = grouped(run.set_aside.len() as u64);
        notes.push(format!("{count} scenarios have no answer: every worker at them died"));
    }
    notes
}

/// The share of scenarios that took at most so long.
fn compute_times(times: &ComputeTimes) -> Figure {
    let deciles = times.deciles.iter().enumerate().map(|(n, &us)| (10.0 * n as f64, us));
    let marked = [(50.0, times.median), (99.0, times.p99), (100.0, times.max)];
    let mut points: Vec<Point> =
        deciles.chain(marked).map(|(percent, us)| Point::at(us, percent)).collect();
    points.sort_by(|a, b| a.y.total_cmp(&b.y));
    points.dedup();
    let is_positive = points.iter().all(|point| point.x > 0.0);
    let label = "time computing a scenario, at most (us)";
    Figure {
        name: "compute_times".to_owned(),
        title: "Times of scenarios".to_owned(),
        x: if is_positive { Axis::log(label) } else { Axis::linear(label) },
        y: Axis::linear("share of scenarios (%)"),
        series: unnamed(points),
    }
}

/// How many scenarios have none, 1 to 9, 10 to 99 pairs, and so on.
fn pairs_of_scenarios(pairs: &[f64]) -> Figure {
    let digits = |&pairs: &f64| (pairs as u64).checked_ilog10().map_or(0, |log| log as usize + 1);
    let most = pairs.iter().map(digits).max().unwrap_or(0);
    let name = |digits: usize| match digits {
        0 => "none".to_owned(),
        _ => format!("{} to {}", grouped(power(digits - 1)), grouped(power(digits) - 1)),
    };
    let count = |wanted: usize| pairs.iter().filter(|pairs| digits(pairs) == wanted).count();
    bars(
        ["pairs_of_scenarios", "Pairs of scenarios"],
        ["pairs of triangles that touch", "scenarios"],
        (0..=most).map(|digits| (name(digits), count(digits) as f64)),
    )
}

fn power(digits: usize) -> u64 {
    10_u64.saturating_pow(digits as u32)
}

fn workers(reports: &[Worker]) -> Figure {
    let share = |name: &str, of: fn(&Worker) -> f64| {
        let sum: f64 = reports.iter().map(of).sum();
        let percent = |worker: &Worker| if sum > 0.0 { 100.0 * of(worker) / sum } else { 0.0 };
        let points = reports.iter().enumerate().map(|(n, w)| Point::at(n as f64, percent(w)));
        Series { name: name.to_owned(), points: points.collect() }
    };
    let names = (0..reports.len()).map(|number| number.to_string()).collect();
    Figure {
        name: "workers".to_owned(),
        title: "How the work was spread".to_owned(),
        x: Axis { label: "worker".to_owned(), scale: Scale::Names(names) },
        y: Axis::linear("share of all workers (%)"),
        series: vec![
            share("scenarios", |worker| worker.scenarios as f64),
            share("time computing", |worker| worker.compute_s),
        ],
    }
}

fn stages(time: &BTreeMap<String, f64>) -> Figure {
    let there =
        STAGES.iter().filter_map(|(name, key)| Some(((*name).to_owned(), *time.get(*key)?)));
    bars(
        [
            "stages",
            "Stages: workers start meanwhile; the last two are the master's, within scenarios",
        ],
        ["stage", "time (s)"],
        there,
    )
}

/// Those that took any time.
fn effects(effects: &[Effect]) -> Option<Figure> {
    let costs: Vec<_> = effects
        .iter()
        .filter(|effect| effect.mean_us > 0.0)
        .map(|effect| (effect.effect.clone(), effect.mean_us))
        .collect();
    let words = ["effects", "What effects cost"];
    let labels = ["effect", "time of a scenario that needs it, mean (us)"];
    let figure = bars(words, labels, costs.iter().cloned());
    (costs.len() > 1).then(|| Figure { y: Axis::log(labels[1]), ..figure })
}

fn bars(
    [name, title]: [&str; 2],
    [x, y]: [&str; 2],
    bars: impl Iterator<Item = (String, f64)>,
) -> Figure {
    let (names, heights): (Vec<String>, Vec<f64>) = bars.unzip();
    let points = heights.iter().enumerate().map(|(n, &height)| Point::at(n as f64, height));
    Figure {
        name: name.to_owned(),
        title: title.to_owned(),
        x: Axis { label: x.to_owned(), scale: Scale::Names(names) },
        y: Axis::linear(y),
        series: unnamed(points.collect()),
    }
}

fn unnamed(points: Vec<Point>) -> Vec<Series> {
    vec![Series { name: String::new(), points }]
}

fn totals(run: &Run) -> Table {
    let mesh = |body: &Body, mesh: &Mesh| {
        let (triangles, bytes) = (grouped(mesh.triangles), grouped(mesh.tree_bytes));
        format!("{}: {triangles} triangles, tree of {bytes} bytes", body.name())
    };
    let asked = grouped(run.scenarios_asked);
    let rows = [
        ("fixed", mesh(&run.scene.fixed, &run.fixed)),
        ("moving", mesh(&run.scene.moving, &run.moving)),
        ("scenarios", format!("{} of {asked}", grouped(run.scenarios))),
        ("colliding", grouped(run.colliding)),
        ("pairs", format!("{} ({})", grouped(run.pairs), run.accuracy)),
        ("scenarios a second", number(run.scenarios_per_s)),
        ("computing a scenario, mean (us)", number(run.compute_us.mean)),
        ("workers", grouped(run.worker_reports.len() as u64)),
        ("transport", run.transport.clone()),
        ("matchmaker", run.matchmaker.clone()),
        ("instruction set", run.simd.clone()),
        ("geometry put where all read it (bytes)", grouped(run.bytes_published)),
        ("geometry sent to single workers (bytes)", grouped(run.bytes_copied)),
        ("relative data transfer", number(run.relative_data_transfer)),
    ];
    listed("The run", rows.map(|(name, value)| [name.to_owned(), value]).to_vec())
}

fn worker_table(reports: &[Worker]) -> Table {
    let columns = [
        "worker",
        "scenarios",
        "batches",
        "computing (s)",
        "geometry sent to it (bytes)",
        "messages (bytes)",
        "replaced",
    ];
    let row = |(number_of, worker): (usize, &Worker)| {
        vec![
            number_of.to_string(),
            grouped(worker.scenarios),
            grouped(worker.batches),
            number(worker.compute_s),
            grouped(worker.geometry_bytes_copied),
            grouped(worker.message_bytes),
            grouped(worker.restarts),
        ]
    };
    table("Workers", &columns, reports.iter().enumerate().map(row).collect())
}

fn effect_table(effects: &[Effect]) -> Table {
    let columns = ["effect", "scenarios", "computing (s)", "mean (us)", "work", ""];
    let row = |effect: &Effect| {
        vec![
            effect.effect.clone(),
            grouped(effect.scenarios),
            number(effect.compute_s),
            number(effect.mean_us),
            grouped(effect.work),
            effect.work_unit.clone(),
        ]
    };
    table("Effects", &columns, effects.iter().map(row).collect())
}

fn cost_table(costs: &[TreeCosts]) -> Table {
    let columns = ["tree", "N_b", "N_p", "T (s)", "C_b (ns)", "C_p (ns)", "error of the fit (%)"];
    let row = |cost: &TreeCosts| {
        let fit =
            |of: fn(&Fit) -> f64| cost.fit.as_ref().map_or_else(String::new, |f| number(of(f)));
        vec![
            cost.tree.clone(),
            grouped(cost.n_b),
            grouped(cost.n_p),
            number(cost.descent_s),
            fit(|fit| fit.c_b_ns),
            fit(|fit| fit.c_p_ns),
            fit(|fit| 100.0 * fit.mean_relative_error),
        ]
    };
    table("Trees: T = N_b C_b + N_p C_p", &columns, costs.iter().map(row).collect())
}

/// Of what each scenario says, in numbers.
fn column_table(columns: &[Column]) -> Table {
    let row = |column: &Column| {
        let numbers = &column.numbers;
        let last = numbers.len().checked_sub(1)?;
        let quantiles = [0, last / 2, last].map(|place| number(numbers[place]));
        let start = [column.name.clone(), grouped(numbers.len() as u64)];
        Some(start.into_iter().chain(quantiles).collect())
    };
    let names =
        ["column of scenarios.csv", "scenarios with a value", "least", "median", "greatest"];
    table("What scenarios say", &names, columns.iter().filter_map(row).collect())
}

/// And in words, if they do.
fn word_table(columns: &[Column]) -> Option<Table> {
    let rows: Vec<_> = columns
        .iter()
        .flat_map(|column| {
            let row = |(word, &count): (&String, &u64)| {
                vec![column.name.clone(), word.clone(), grouped(count)]
            };
            column.words.iter().map(row)
        })
        .collect();
    let names = ["column of scenarios.csv", "value", "scenarios"];
    (!rows.is_empty()).then(|| table("What scenarios say in words", &names, rows))
}
