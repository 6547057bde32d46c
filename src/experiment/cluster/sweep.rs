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

/// How far simulating is.
pub enum Progress<'a> {
    /// So many more scenarios are answered.
    Answered(usize),
    Finished(&'a Simulated),
}

#[derive(Clone, PartialEq)]
struct Run {
    point: Point,
    rule: MatchRule,
    copies: Copies,
    compression: Compression,
    from: SubtreesFrom,
}

/// How many scenarios are simulated in all.
pub fn scenarios(config: &Config) -> usize {
    let of_run = |run: &Run| seeds(config, run.rule).count() * run.point.scenarios.get() as usize;
    distinct(&runs(config)).iter().map(of_run).sum()
}

/// Simulates all of them; `None` if interrupted. The recording has every cut of the configuration.
pub fn run(
    config: &Config,
    recording: &Recording,
    progress: &(dyn Fn(Progress<'_>) + Sync),
    interrupt: &AtomicBool,
) -> Option<Vec<Simulated>> {
    let load = |depths: [u32; 2]| {
        let cut = recording.cut(depths).expect("the recording has every cut");
        let of = |&compression| Load::of(recording, cut, compression, &config.scale);
        (depths, config.run.compression.iter().map(of).collect())
    };
    let loads: BTreeMap<_, Vec<_>> = config.cuts().into_iter().map(load).collect();
    let score_root = config.scale.score_root_ns.unwrap_or(recording.score_root_ns);
    let all = runs(config);
    let distinct = distinct(&all);
    let outcomes = distinct.par_iter().map(|run| {
        let cluster = cluster(config, run, score_root);
        let compressed = config.run.compression.iter().position(|&c| c == run.compression);
        let load = &loads[&run.point.depths][compressed.expect("it is of the configuration")];
        let answered = |scenarios| progress(Progress::Answered(scenarios));
        let sample = |seed| {
            let policy = policy(config, run, seed);
            let is_interrupted = interrupt.load(Ordering::Relaxed);
            let simulated =
                || simulate(load, &cluster, &policy, run.point.scenarios.get(), &answered);
            (!is_interrupted).then(simulated)
        };
        let samples = seeds(config, run.rule).map(sample).collect::<Option<Vec<_>>>()?;
        progress(Progress::Finished(&described(config, Varied::Nothing, run, samples.clone())));
        Some(samples)
    });
    let outcomes: Vec<_> = outcomes.collect::<Option<_>>()?;
    let simulated = all.iter().map(|(varied, run)| {
        let at = distinct.iter().position(|other| other == run).expect("it is one of them");
        described(config, *varied, run, outcomes[at].clone())
    });
    Some(simulated.collect())
}

fn described(config: &Config, varied: Varied, run: &Run, samples: Vec<Outcome>) -> Simulated {
    let Run { point, rule, copies, compression, from } = run.clone();
    let Point { scenarios, depths, buffer, nodes } = point;
    let cluster = cluster(config, run, 0.0);
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

fn cluster(config: &Config, run: &Run, score_root: f64) -> Cluster {
    Cluster {
        nodes: config.nodes(&run.point.nodes),
        master: config.master,
        link: config.link,
        messages: MessageCosts { score_root, ..config.messages },
        copies: run.copies,
        memory: config.memory,
    }
}

fn policy(config: &Config, run: &Run, seed: u64) -> Policy {
    let (scenarios, bytes) = (run.point.buffer.get(), config.run.buffer_bytes);
    let most_tasks = config.run.most_tasks;
    Policy {
        rule: run.rule,
        most_tasks,
        from: run.from,
        seed,
        buffer: BufferLimits { scenarios, bytes },
        holds_back: config.run.holds_back,
    }
}

fn seeds(config: &Config, rule: MatchRule) -> impl Iterator<Item = u64> + use<> {
    let (first, samples) = (config.run.match_seed, u64::from(config.run.samples.get()));
    first..first + if rule == MatchRule::Random { samples } else { 1 }
}

fn runs(config: &Config) -> Vec<(Varied, Run)> {
    let mut runs = Vec::new();
    for (varied, point) in points(config) {
        for &copies in &config.run.copies {
            for &compression in &config.run.compression {
                for &from in &config.run.subtrees_from {
                    runs.extend(config.run.matchmakers.iter().map(|&rule| {
                        let point = point.clone();
                        (varied, Run { point, rule, copies, compression, from })
                    }));
                }
            }
        }
    }
    runs
}

/// Sweeps have the run in common that is as configured.
fn distinct(runs: &[(Varied, Run)]) -> Vec<Run> {
    let mut distinct: Vec<Run> = Vec::new();
    for (_, run) in runs {
        if !distinct.contains(run) {
            distinct.push(run.clone());
        }
    }
    distinct
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
