//! One sample of a point: run for real, its answers checked.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use super::plan::{Evaluation, Setting, Step};
use super::speed::{Cores, best_possible, weighted_serial_s};
use crate::experiment::throughput::{self, Load, ThroughputError, Turn};
use crate::geometry::Pose;
use crate::scene::MatchRule;
use crate::scheduler::client_manager::EngineReport;
use crate::tree::TreeImage;

/// Models that are there, with all their scenarios.
pub struct Loaded {
    pub fixed: Arc<TreeImage>,
    pub moving: Arc<TreeImage>,
    pub poses: Vec<Pose>,
}

/// What tells loaded models from others: samples of a point are of the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Their name.
    pub models: String,
    pub fixed: TreeFacts,
    pub moving: TreeFacts,
    pub scenarios: usize,
    /// 64-bit XXH3 of their poses, in hexadecimal.
    pub poses_xxh3: String,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TreeFacts {
    pub triangles: u32,
    pub bytes: usize,
    /// 64-bit XXH3 of its image, in hexadecimal.
    pub xxh3: String,
}

impl Loaded {
    pub fn facts(&self, models: &str) -> Facts {
        Facts {
            models: models.to_owned(),
            fixed: TreeFacts::of(&self.fixed),
            moving: TreeFacts::of(&self.moving),
            scenarios: self.poses.len(),
            poses_xxh3: hexadecimal(xxh3_64(bytemuck::cast_slice(&self.poses))),
        }
    }
}

impl TreeFacts {
    fn of(image: &TreeImage) -> Self {
        Self {
            triangles: image.view().triangle_count(),
            bytes: size_of_val(image.blocks()),
            xxh3: hexadecimal(image.view().hash()),
        }
    }
}

fn hexadecimal(hash: u64) -> String {
    format!("{hash:016x}")
}

/// Times in seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Their name.
    pub models: String,
    /// Which of the values that are varied, from 0.
    pub at: usize,
    /// Absent: no engine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub matchmaker: Option<MatchRule>,
    /// From 0.
    pub sample: u32,
    pub scenarios: usize,
    /// Of triangles that touch, in all of them.
    pub pairs: u64,
    /// Of one core, without an engine.
    pub serial_s: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parallel: Option<Parallel>,
}

/// A run of an engine, right after the serial one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parallel {
    pub workers: u32,
    /// Section 7.1 of the paper; the same as the serial time where no worker is slowed.
    pub weighted_serial_s: f64,
    /// First batch sent to last result received.
    pub parallel_s: f64,
    /// The first over the second (section 7.2).
    pub speedup: f64,
    /// Section 7.1.1: how many cores of this machine the workers are worth.
    pub best_possible: f64,
    /// Bytes of subtrees that the master sent, and over the bytes of both trees (section 7.2).
    pub bytes_sent: u64,
    pub relative_data_transfer: f64,
    /// Bytes of subtrees that workers had from each other.
    pub bytes_from_workers: u64,
    pub first_result_s: f64,
    pub pre_analysis_s: f64,
    pub matching_s: f64,
}

/// Why there is no sample.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    #[error(transparent)]
    Throughput(#[from] ThroughputError),
    #[error("worker {0} died, so that the times say nothing")]
    WorkerDied(usize),
}

impl MeasureError {
    pub fn is_interrupt(&self) -> bool {
        matches!(self, Self::Throughput(ThroughputError::Interrupted))
    }
}

/// The serial run, and if the step has a matchmaker, that of an engine whose workers are of
/// `program`. Answers that differ are an error.
pub fn measure(
    evaluation: &Evaluation,
    step: &Step,
    loaded: &Loaded,
    program: &Path,
    interrupt: &AtomicBool,
) -> Result<Sample, MeasureError> {
    let setting = evaluation.setting(step, loaded.poses.len());
    let load = Load {
        fixed: (Arc::clone(&loaded.fixed), setting.cuts[0]),
        moving: (Arc::clone(&loaded.moving), setting.cuts[1]),
        poses: &loaded.poses[..setting.scenarios],
        engine: setting.engine.clone(),
        program: program.to_owned(),
    };
    let (answers, serial_s, report) = match step.matchmaker {
        None => {
            let (answers, serial_s) = throughput::serial(&load, interrupt)?;
            (answers, serial_s, None)
        }
        Some(_) => {
            let Turn { answers, serial_s, report } =
                throughput::in_turn(&load, &setting.engine, interrupt)?;
            (answers, serial_s, Some(report))
        }
    };
    let parallel = report.map(|report| Parallel::new(&setting, serial_s, &report)).transpose()?;
    Ok(Sample {
        models: evaluation.models[step.models].name.clone(),
        at: step.at,
        matchmaker: step.matchmaker,
        sample: step.sample,
        scenarios: setting.scenarios,
        pairs: answers.iter().map(|(pairs, _)| u64::from(*pairs)).sum(),
        serial_s,
        parallel,
    })
}

impl Parallel {
    fn new(setting: &Setting, serial_s: f64, report: &EngineReport) -> Result<Self, MeasureError> {
        let died = report.workers.iter().position(|worker| worker.died || worker.restarts > 0);
        if let Some(worker) = died {
            return Err(MeasureError::WorkerDied(worker));
        }
        let slowed = |factor| Cores { count: 1, serial_s: serial_s * factor };
        let cores: Vec<Cores> = setting.slowdowns().into_iter().map(slowed).collect();
        let weighted_serial_s = weighted_serial_s(&cores);
        Ok(Self {
            workers: cores.len() as u32,
            weighted_serial_s,
            parallel_s: report.scenarios_s,
            speedup: weighted_serial_s / report.scenarios_s,
            best_possible: best_possible(serial_s, &cores),
            bytes_sent: report.bytes_sent,
            relative_data_transfer: report.relative_data_transfer,
            bytes_from_workers: report.transfer.bytes_from_workers,
            first_result_s: report.first_result_s,
            pre_analysis_s: report.pre_analysis_s,
            matching_s: report.matching_s,
        })
    }
}

impl Sample {
    /// Which of the experiment it is; `None` if it is none of them.
    pub fn step(&self, evaluation: &Evaluation) -> Option<Step> {
        let models = evaluation.models.iter().position(|models| models.name == self.models)?;
        let step = Step { models, at: self.at, matchmaker: self.matchmaker, sample: self.sample };
        evaluation.steps().contains(&step).then_some(step)
    }
}
