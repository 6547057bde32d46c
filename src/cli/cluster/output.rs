//! `cluster.json`, the figures beside it, and what is printed.

use serde::Serialize;

use crate::experiment::cluster::Saturation;
use crate::experiment::cluster::recording::{Recording, Subject};
use crate::experiment::cluster::sweep::Simulated;
use crate::experiment::cluster::validate::Validated;
use crate::report::figure::{Figure, Table};
use crate::report::{Machine, Versions};

/// `cluster.json`.
#[derive(Serialize)]
pub struct ClusterReport {
    schema_version: u32,
    kind: &'static str,
    name: String,
    versions: Versions,
    machine: Machine,
    recorded: Recorded,
    /// What has to be known to read the figures.
    notes: Vec<String>,
    figures: Vec<Figure>,
    tables: Vec<Table>,
    /// Of each series of a sweep over units.
    saturation: Vec<Saturation>,
    /// With `--validate`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    validation: Vec<Validated>,
    /// Every simulated run.
    points: Vec<Simulated>,
}

/// What the costs come from.
#[derive(Serialize)]
struct Recorded {
    subject: Subject,
    processor: String,
    scenarios: usize,
    serial_s: f64,
    tree_bytes: [u64; 2],
    box_test_ns: f64,
    score_root_ns: f64,
}

impl Recorded {
    fn of(recording: &Recording) -> Self {
        Self {
            subject: recording.subject.clone(),
            processor: recording.processor.clone(),
            scenarios: recording.serial_ns.len(),
            serial_s: 1e-9 * recording.serial_ns.iter().sum::<u64>() as f64,
            tree_bytes: recording.tree_bytes,
            box_test_ns: recording.box_test_ns,
            score_root_ns: recording.score_root_ns,
        }
    }
}

impl ClusterReport {
    const SCHEMA_VERSION: u32 = 1;

    pub fn new(
        name: &str,
        recording: &Recording,
        figures: Vec<Figure>,
        tables: Vec<Table>,
        saturation: Vec<Saturation>,
        validation: Vec<Validated>,
        points: Vec<Simulated>,
    ) -> Self {
        Self {
            schema_version: Self::SCHEMA_VERSION,
            kind: "cluster",
            name: name.to_owned(),
            versions: Versions::this(),
            machine: Machine::this(),
            recorded: Recorded::of(recording),
            notes: saturation.iter().map(Saturation::sentence).collect(),
            figures,
            tables,
            saturation,
            validation,
            points,
        }
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("string keys and plain values") + "\n"
    }

    pub fn text(&self) -> String {
        let Recorded { scenarios, serial_s, processor, .. } = &self.recorded;
        let mut text =
            format!("recorded: {scenarios} scenarios, {serial_s:.3} s serially on {processor}\n");
        for table in &self.tables {
            text += &format!("\n{}", table.to_text());
        }
        if !self.notes.is_empty() {
            text += "\n";
        }
        for note in &self.notes {
            text += &format!("{note}\n");
        }
        text
    }
}

/// What messages were found to cost; none if nothing was validated.
pub fn messages_table(validated: &[Validated]) -> Option<Table> {
    let columns = [
        "transport",
        "send, us",
        "wake up, us",
        "receive, us",
        "gathered, us",
        "copying, MB/s",
        "scoring a root, ns",
    ];
    let row = |row: &Validated| {
        let messages = &row.messages;
        let us = |ns: u64| format!("{:.3}", 1e-3 * ns as f64);
        vec![
            row.transport.name().to_owned(),
            us(messages.send),
            us(messages.wake_up),
            us(messages.receive),
            us(messages.gathered),
            format!("{:.0}", 1e-6 * messages.copy_bytes_per_s),
            format!("{:.2}", messages.score_root),
        ]
    };
    (!validated.is_empty()).then(|| Table {
        title: "messages on this machine".to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: validated.iter().map(row).collect(),
    })
}

/// None if nothing was validated.
pub fn validation_table(validated: &[Validated]) -> Option<Table> {
    let columns = [
        "transport",
        "workers",
        "serial, s",
        "simulated, s",
        "best measured, s",
        "median, s",
        "simulated / best",
        "simulated / median",
    ];
    let row = |row: &Validated| {
        vec![
            row.transport.name().to_owned(),
            row.workers.to_string(),
            format!("{:.4}", row.serial_s),
            format!("{:.4}", row.simulated_s),
            format!("{:.4}", row.best_s),
            format!("{:.4}", row.median_s),
            format!("{:.3}", row.over_best),
            format!("{:.3}", row.over_median),
        ]
    };
    (!validated.is_empty()).then(|| Table {
        title: "simulated against measured on this machine".to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: validated.iter().map(row).collect(),
    })
}
