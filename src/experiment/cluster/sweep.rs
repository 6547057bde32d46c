//! All runs of a configuration: each value of each sweep, by each matchmaker, with geometry copied as
//! often as is asked for.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use serde::Serialize;

use super::config::{Config, Point};
use super::load::Load;
use super::machine::{Cluster, Copies, MessageCosts};
use super::outcome::Outcome;
use super::recording::Recording;
use super::simulation::{Policy, simulate};
use crate::scene::{Compression, MatchRule, SubtreesFrom};
use crate::scheduler::assignment::BufferLimits;

/// What is not the same for all runs of a sweep (section 7.2 to 7.5 of the paper).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Varied {
    Nothing,
    Scenarios,
    Depth,
    Buffer,
    Units,
}

/// A point of a sweep, simulated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Simulated {
    pub varied: Varied,
    /// The value: scenarios, d of the fixed tree, q, or weighted cores.
    pub x: f64,
    pub scenarios: u32,
    pub depths: [u32; 2],
    pub buffer_scenarios: u32,
    /// Of each group.
    pub nodes: Vec<u32>,
    pub workers: usize,
    pub matchmaker: MatchRule,
    pub copies: Copies,
    pub compression: Compression,
    pub subtrees_from: SubtreesFrom,
    /// One a seed where the matchmaker draws, otherwise one.
    pub samples: Vec<Outcome>,
}

impl Simulated {
    pub fn mean(&self, value: impl Fn(&Outcome) -> f64) -> f64 {
        self.samples.iter().map(value).sum::<f64>() / self.samples.len() as f64
    }

    /// Least and most of the samples.
    pub fn spread(&self, value: impl Fn(&Outcome) -> f64) -> Option<[f64; 2]> {
        let values = || self.samples.iter().map(&value);
        let ends = || Some([values().reduce(f64::min)?, values().reduce(f64::max)?]);
        (self.samples.len() > 1).then(ends).flatten()
    }

    /// Whether some node's memory is not enough: such a run would not have come to its end.
    pub fn is_out_of_memory(&self) -> bool {
        self.samples.iter().any(|outcome| outcome.memory.is_exceeded())
    }
}

#[derive(Clone)]
struct Task {
    varied: Varied,
    point: Point,
    rule: MatchRule,
    copies: Copies,
    compression: Compression,
    from: SubtreesFrom,
}

/// How many runs there are in all.
pub fn count(config: &Config) -> usize {
    let samples = |task: &Task| seeds(config, task.rule).count();
    tasks(config).iter().map(samples).sum()
}

/// Simulates all of them; `None` if interrupted. The recording has every cut of the configuration.
/// `progress` is told of each run.
pub fn run(
    config: &Config,
    recording: &Recording,
    progress: &(dyn Fn() + Sync),
    interrupt: &AtomicBool,
) -> Option<Vec<Simulated>> {
    let load = |depths: [u32; 2]| {
        let cut = recording.cut(depths).expect("the recording has every cut");
        let of = |&compression| Load::of(recording, cut, compression, &config.scale);
        (depths, config.run.compression.iter().map(of).collect())
    };
    let loads: BTreeMap<_, Vec<_>> = config.cuts().into_iter().map(load).collect();
    let score_root = config.scale.score_root_ns.unwrap_or(recording.score_root_ns);
    let simulated = tasks(config).into_par_iter().map(|task| {
        let cluster = cluster(config, &task, score_root);
        let compressed = config.run.compression.iter().position(|&c| c == task.compression);
        let load = &loads[&task.point.depths][compressed.expect("it is of the configuration")];
        let sample = |seed| {
            if interrupt.load(Ordering::Relaxed) {
                return None;
            }
            let policy = policy(config, &task, seed);
            let outcome = simulate(load, &cluster, &policy, task.point.scenarios.get());
            progress();
            Some(outcome)
        };
        let samples = seeds(config, task.rule).map(sample).collect::<Option<Vec<_>>>()?;
        Some(described(task, &cluster, samples))
    });
    simulated.collect()
}

fn described(task: Task, cluster: &Cluster, samples: Vec<Outcome>) -> Simulated {
    let Task { varied, point, rule, copies, compression, from } = task;
    let Point { scenarios, depths, buffer, nodes } = point;
    let x = match varied {
        Varied::Nothing | Varied::Scenarios => f64::from(scenarios.get()),
        Varied::Depth => f64::from(depths[0]),
        Varied::Buffer => f64::from(buffer.get()),
        Varied::Units => cluster.bound(),
    };
    Simulated {
        varied,
        x,
        scenarios: scenarios.get(),
        depths,
        buffer_scenarios: buffer.get(),
        nodes,
        workers: cluster.workers(),
        matchmaker: rule,
        copies,
        compression,
        subtrees_from: from,
        samples,
    }
}

fn cluster(config: &Config, task: &Task, score_root: f64) -> Cluster {
    Cluster {
        nodes: config.nodes(&task.point.nodes),
        master: config.master,
        link: config.link,
        messages: MessageCosts { score_root, ..config.messages },
        copies: task.copies,
        memory: config.memory,
    }
}

fn policy(config: &Config, task: &Task, seed: u64) -> Policy {
    let (scenarios, bytes) = (task.point.buffer.get(), config.run.buffer_bytes);
    let most_tasks = config.run.most_tasks;
    Policy {
        rule: task.rule,
        most_tasks,
        from: task.from,
        seed,
        buffer: BufferLimits { scenarios, bytes },
    }
}

fn seeds(config: &Config, rule: MatchRule) -> impl Iterator<Item = u64> + use<> {
    let (first, samples) = (config.run.match_seed, u64::from(config.run.samples.get()));
    first..first + if rule == MatchRule::Random { samples } else { 1 }
}

fn tasks(config: &Config) -> Vec<Task> {
    let mut tasks = Vec::new();
    for (varied, point) in points(config) {
        for &copies in &config.run.copies {
            for &compression in &config.run.compression {
                for &from in &config.run.subtrees_from {
                    tasks.extend(config.run.matchmakers.iter().map(|&rule| {
                        let point = point.clone();
                        Task { varied, point, rule, copies, compression, from }
                    }));
                }
            }
        }
    }
    tasks
}

fn points(config: &Config) -> Vec<(Varied, Point)> {
    let (base, sweep) = (&config.run.point, &config.sweep);
    let mut points = vec![(Varied::Nothing, base.clone())];
    let scenarios = sweep.scenarios.iter().map(|&scenarios| Point { scenarios, ..base.clone() });
    points.extend(scenarios.map(|point| (Varied::Scenarios, point)));
    let [_, moving] = base.depths;
    let depths = sweep.depths.iter().map(|&d| Point { depths: [d, moving], ..base.clone() });
    points.extend(depths.map(|point| (Varied::Depth, point)));
    let buffer = sweep.buffer.iter().map(|&buffer| Point { buffer, ..base.clone() });
    points.extend(buffer.map(|point| (Varied::Buffer, point)));
    let nodes = sweep.nodes.iter().map(|nodes| Point { nodes: nodes.clone(), ..base.clone() });
    points.extend(nodes.map(|point| (Varied::Units, point)));
    points
}
