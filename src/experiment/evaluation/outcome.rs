//! `experiment.json`: what the samples say, as the paper's figures and tables.

mod view;

use serde::Serialize;
use serde_json::Value;

use self::view::View;
use super::plan::{Evaluation, Models, Step, Vary};
use super::sample::{Facts, Sample};
use super::store::Kept;
use crate::report::figure::{Figure, Table};
use crate::report::{Machine, Versions};
use crate::scene::{Compression, SubtreesFrom};

/// Of all samples that there are, be they all that are to be or not.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome<'a> {
    schema_version: u32,
    kind: &'static str,
    name: &'a str,
    versions: Versions,
    machine: Machine,
    pub samples: usize,
    pub samples_asked: usize,
    setup: &'a Value,
    models: &'a [Facts],
    /// What has to be known to read the figures.
    pub notes: Vec<String>,
    pub figures: Vec<Figure>,
    pub tables: Vec<Table>,
    /// In the order in which they were measured.
    points: &'a [Sample],
}

const SCHEMA_VERSION: u32 = 1;

impl<'a> Outcome<'a> {
    pub fn new(evaluation: &'a Evaluation, setup: &'a Value, kept: &'a Kept) -> Self {
        let machine = Machine::this();
        let view = View { evaluation, samples: &kept.samples, cores: machine.cores };
        Self {
            schema_version: SCHEMA_VERSION,
            kind: "experiment",
            name: &evaluation.name,
            versions: Versions::this(),
            samples: kept.samples.len(),
            samples_asked: evaluation.steps().len(),
            setup,
            models: &kept.models,
            notes: view.notes(),
            figures: view.figures(),
            tables: view.tables(),
            points: &kept.samples,
            machine,
        }
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("string keys and plain values") + "\n"
    }
}

impl View<'_> {
    fn notes(&self) -> Vec<String> {
        let evaluation = self.evaluation;
        let samples = evaluation.samples;
        let mut notes =
            vec![format!("mean of {samples} samples a point, and the least and the most")];
        let steps = evaluation.steps().len();
        if self.samples.len() < steps {
            notes.push(format!("not finished: {} of {steps} samples", self.samples.len()));
        }
        if evaluation.vary.is_serial() {
            return notes;
        }
        notes.push(
            "speedup: weighted serial time over parallel time, both measured in turn; relative \
             data transfer: bytes of subtrees sent over the bytes of both trees"
                .to_owned(),
        );
        for models in evaluation.models.iter().filter(|models| !models.sends_subtrees()) {
            let (name, transport) = (&models.name, models.scene.engine.transport.name());
            notes.push(format!(
                "{name}: over {transport} workers use the geometry in place: no subtree is sent"
            ));
        }
        for Models { name, scene } in &evaluation.models {
            if scene.engine.compress != Compression::None {
                notes.push(format!("{name}: subtrees are sent compressed, and counted as sent"));
            }
            if scene.engine.subtrees_from != SubtreesFrom::Master {
                notes.push(format!(
                    "{name}: what workers have from each other is not in the relative data transfer"
                ));
            }
        }
        if self.samples.iter().any(|sample| self.is_oversubscribed(sample)) {
            let cores = self.cores;
            let which = match evaluation.vary {
                Vary::Units { .. } => "points with * have",
                _ => "there are",
            };
            notes.push(format!("{which} more workers than the {cores} cores of this machine"));
        }
        let is_slowed =
            |step: &Step| evaluation.setting(step, 1).slowdowns().iter().any(|f| *f > 1.0);
        if evaluation.steps().iter().any(is_slowed) {
            notes.push(
                "a speedup is over the mean of fast and slow cores, what is best possible is \
                 counted in fast ones, as in the paper: with slow workers the one can be above the \
                 other"
                    .to_owned(),
            );
        }
        notes
    }
}

#[cfg(test)]
mod tests;
