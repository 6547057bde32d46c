//! What accuracy costs in time, and what is wrong without it: the same scenarios at every level, on
//! this thread, held against the exact answers.

use std::hint::black_box;
use std::sync::atomic::{AtomicBool, Ordering};

use super::contact_error::ContactError;
use super::difference::Difference;
use crate::effects::contacts;
use crate::geometry::predicates::StageCounts;
use crate::geometry::simd::SimdLevel;
use crate::geometry::{Pose, TriangleTest};
use crate::tree::ByNumber;
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::tree::roots::PreAnalysis;
use crate::tree::{Accuracy, BoxDepth, Counts, TreeKind, TreeView};
use crate::workers::clock::thread_ns;

/// Timed runs of a scenario at a level, each right after an untimed one. The fastest counts: what
/// disturbs only slows.
const ROUNDS: usize = 3;

/// One level, over all scenarios.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AccuracyRow {
    pub level: Accuracy,
    /// Processor time of a scenario, each the fastest of three warm runs of its pose.
    pub time_us: Times,
    /// Mean time over that of the exact level.
    pub over_exact: f64,
    /// Scenarios that it calls colliding, and are not.
    pub false_hits: u32,
    /// The other way round.
    pub false_misses: u32,
    /// Exact pairs that it does not find.
    pub missing: u64,
    /// Pairs that it finds, or stands for, and are none.
    pub extra: u64,
    /// `missing` and `extra` over the number of exact pairs.
    pub wrong_pairs: f64,
    /// Of the contact points of the exact pairs that it finds too. Boxes have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_error_m: Option<ContactErrors>,
    /// Those of them for which plain floating point has no contact point, and so no error of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_contact: Option<u64>,
    /// N_b: box tests of the mean scenario.
    pub box_tests: f64,
    /// N_p: triangle tests of the mean scenario.
    pub triangle_tests: f64,
    /// Those of them that the vectors of 32-bit numbers left to a test of their own. Wide trees only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_open: Option<f64>,
    /// Signs of the mean scenario by the stage that decided them. Only exact predicates have stages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signs: Option<Signs>,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Times {
    pub mean: f64,
    pub median: f64,
    pub p99: f64,
}

/// Distance of a pair's contact points from the true ones in metres, the greatest in either
/// direction; of the exact level the bound that is certified. In 32 bits the contact points are
/// those of coordinates that are rounded as they are, far from the origin or not.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ContactErrors {
    pub median: f64,
    pub worst: f64,
}

/// As [`StageCounts`], a scenario.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Signs {
    pub filter: f64,
    pub structure: f64,
    pub grid: f64,
    pub expansions: f64,
    pub integers: f64,
}

#[derive(Debug, thiserror::Error)]
#[error("scenario {scenario}: {source}")]
pub struct AccuracyError {
    pub scenario: usize,
    pub source: DescentError,
}

/// What is compared.
pub struct Load<'a> {
    pub fixed: TreeView<'a>,
    pub moving: TreeView<'a>,
    pub poses: &'a [Pose],
    /// The exact one is measured in any case.
    pub levels: &'a [Accuracy],
    pub simd: SimdLevel,
}

/// Rows in the order of the levels, each once, the exact one last if it is not among them; and over
/// how many scenarios, which are fewer after an interrupt.
pub struct Measured {
    pub rows: Vec<AccuracyRow>,
    pub scenarios: usize,
    /// Exact pairs in all of them.
    pub pairs: u64,
    /// Scenarios that have any.
    pub colliding: u32,
}

/// `progress` is told of each finished scenario.
pub fn measure(
    load: &Load<'_>,
    progress: &dyn Fn(),
    interrupt: &AtomicBool,
) -> Result<Measured, AccuracyError> {
    let mut levels = Vec::new();
    for &level in load.levels.iter().chain([&Accuracy::EXACT]) {
        if !levels.contains(&level) {
            levels.push(level);
        }
    }
    let meshes = [ByNumber::new(load.fixed), ByNumber::new(load.moving)];
    let mut contenders: Vec<_> = levels.iter().map(|&level| Contender::new(level, load)).collect();
    let exact = levels.iter().position(|&l| l == Accuracy::EXACT).expect("it was added");
    let mut measured = Measured { rows: Vec::new(), scenarios: 0, pairs: 0, colliding: 0 };
    for (scenario, pose) in load.poses.iter().enumerate() {
        if interrupt.load(Ordering::Relaxed) {
            break;
        }
        let truth = one_scenario(&mut contenders, &meshes, exact, pose)
            .map_err(|source| AccuracyError { scenario, source })?;
        measured.scenarios += 1;
        measured.pairs += truth;
        measured.colliding += u32::from(truth > 0);
        progress();
    }
    if measured.scenarios > 0 {
        let exact_us = contenders[exact].times().mean;
        measured.rows = contenders.iter().map(|c| c.row(exact_us, measured.pairs)).collect();
    }
    Ok(measured)
}

/// The levels take turns, so that whatever else the machine does, it does to all. Returns the number
/// of exact pairs.
fn one_scenario(
    contenders: &mut [Contender<'_>],
    meshes: &[ByNumber<'_>; 2],
    exact: usize,
    pose: &Pose,
) -> Result<u64, DescentError> {
    contenders[exact].answer(pose)?;
    let mut truth = contenders[exact].pairs.clone();
    contacts::sort(&mut truth);
    for contender in &mut *contenders {
        contender.count(pose)?;
        contender.compare(&truth, meshes);
        contender.find_contact_errors(&truth, meshes, pose);
    }
    let mut fastest = vec![u64::MAX; contenders.len()];
    for _ in 0..ROUNDS {
        for (contender, fastest) in contenders.iter_mut().zip(&mut fastest) {
            contender.answer(pose)?;
            let begin = thread_ns();
            contender.answer(pose)?;
            *fastest = (*fastest).min(thread_ns() - begin);
            black_box(&contender.pairs);
        }
    }
    for (contender, ns) in contenders.iter_mut().zip(fastest) {
        contender.ns.push(ns);
    }
    Ok(truth.len() as u64)
}

/// A level at work, and what came of it so far.
struct Contender<'a> {
    level: Accuracy,
    fixed: TreeView<'a>,
    moving: TreeView<'a>,
    by: By<'a>,
    /// Of the last scenario: of triangles, or of boxes.
    pairs: Vec<Pair>,
    /// A number for each scenario.
    ns: Vec<u64>,
    counts: Counts,
    stages: StageCounts,
    false_hits: u32,
    false_misses: u32,
    missing: u64,
    extra: u64,
    /// A number for each pair that has contact points.
    contact_errors: Vec<f64>,
    without_contact: u64,
}

enum By<'a> {
    Triangles(Descent),
    Boxes(Box<PreAnalysis<'a>>),
}

impl<'a> Contender<'a> {
    fn new(level: Accuracy, load: &Load<'a>) -> Self {
        let Load { fixed, moving, simd, .. } = *load;
        let by = match level {
            Accuracy::Pairs(test) => By::Triangles(Descent::with(simd, test)),
            Accuracy::BoxesAt(depth) => {
                By::Boxes(Box::new(PreAnalysis::new(fixed, depth.cut(), moving, depth.cut())))
            }
        };
        Self {
            level,
            fixed,
            moving,
            by,
            pairs: Vec::new(),
            ns: Vec::new(),
            counts: Counts::default(),
            stages: StageCounts::default(),
            false_hits: 0,
            false_misses: 0,
            missing: 0,
            extra: 0,
            contact_errors: Vec::new(),
            without_contact: 0,
        }
    }

    /// What is timed.
    fn answer(&mut self, pose: &Pose) -> Result<(), DescentError> {
        self.pairs.clear();
        match &mut self.by {
            By::Triangles(descent) => {
                descent.all_pairs(&self.fixed, &self.moving, pose, &mut self.pairs)
            }
            By::Boxes(analysis) => analysis.boxes_that_meet(pose, &mut self.pairs).map(drop),
        }
    }

    /// The same again, slower.
    fn count(&mut self, pose: &Pose) -> Result<(), DescentError> {
        self.pairs.clear();
        match &mut self.by {
            By::Triangles(descent) if self.level == Accuracy::EXACT => {
                let (counts, stages) =
                    descent.staged_pairs(&self.fixed, &self.moving, pose, &mut self.pairs)?;
                self.counts += counts;
                self.stages += stages;
            }
            By::Triangles(descent) => {
                self.counts +=
                    descent.counted_pairs(&self.fixed, &self.moving, pose, &mut self.pairs)?;
            }
            By::Boxes(analysis) => {
                self.counts.boxes += analysis.boxes_that_meet(pose, &mut self.pairs)?;
            }
        }
        Ok(())
    }

    /// Sorted exact pairs against those found last.
    fn compare(&mut self, truth: &[Pair], meshes: &[ByNumber<'_>; 2]) {
        self.false_hits += u32::from(truth.is_empty() && !self.pairs.is_empty());
        self.false_misses += u32::from(!truth.is_empty() && self.pairs.is_empty());
        contacts::sort(&mut self.pairs);
        let difference = match &self.by {
            By::Triangles(_) => Difference::of_pairs(truth, &self.pairs),
            By::Boxes(analysis) => {
                let roots = [analysis.fixed_roots(), analysis.moving_roots()];
                Difference::of_boxes(truth, &self.pairs, roots, meshes)
            }
        };
        self.missing += difference.missing;
        self.extra += difference.extra;
    }

    /// After [`Contender::compare`], which has sorted what was found.
    fn find_contact_errors(&mut self, truth: &[Pair], meshes: &[ByNumber<'_>; 2], pose: &Pose) {
        let Accuracy::Pairs(test) = self.level else { return };
        let is_found = |pair: &&Pair| self.pairs.binary_search(pair).is_ok();
        for &pair in truth.iter().filter(is_found) {
            match ContactError::of(test, meshes, pose, pair) {
                Some(ContactError::Distance(metres)) => self.contact_errors.push(metres),
                Some(ContactError::NoContact) => self.without_contact += 1,
                None => {}
            }
        }
    }

    fn contact_errors(&self) -> Option<ContactErrors> {
        let mut sorted = self.contact_errors.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let worst = *sorted.last()?;
        Some(ContactErrors { median: sorted[(sorted.len() - 1) / 2], worst })
    }

    fn times(&self) -> Times {
        let mut sorted = self.ns.clone();
        sorted.sort_unstable();
        let last = sorted.len() - 1;
        let us = |percent: usize| sorted[last * percent / 100] as f64 * 1e-3;
        let mean = sorted.iter().sum::<u64>() as f64 / sorted.len() as f64 * 1e-3;
        Times { mean, median: us(50), p99: us(99) }
    }

    /// In plain floating point.
    fn is_plain(&self) -> bool {
        use TriangleTest::{F32, F64};
        matches!(self.level, Accuracy::Pairs(F32 | F64))
    }

    fn row(&self, exact_us: f64, pairs: u64) -> AccuracyRow {
        let time_us = self.times();
        let mean = |sum: u64| sum as f64 / self.ns.len() as f64;
        let in_32_bits = self.fixed.kind() == TreeKind::Wide && matches!(self.by, By::Triangles(_));
        let stages = &self.stages;
        AccuracyRow {
            level: self.level,
            time_us,
            over_exact: time_us.mean / exact_us,
            false_hits: self.false_hits,
            false_misses: self.false_misses,
            missing: self.missing,
            extra: self.extra,
            wrong_pairs: (self.missing + self.extra) as f64 / pairs.max(1) as f64,
            contact_error_m: self.contact_errors(),
            without_contact: self.is_plain().then_some(self.without_contact),
            box_tests: mean(self.counts.boxes),
            triangle_tests: mean(self.counts.triangles),
            left_open: in_32_bits.then(|| mean(self.counts.exact)),
            signs: (self.level == Accuracy::EXACT).then(|| Signs {
                filter: mean(stages.filter),
                structure: mean(stages.structure),
                grid: mean(stages.grid),
                expansions: mean(stages.expansions),
                integers: mean(stages.integers),
            }),
        }
    }
}

/// What is compared if nothing else is asked for: a sweep of depths, then all that look at triangles.
pub fn all_levels() -> Vec<Accuracy> {
    let at_depth = |depth| BoxDepth::new(depth).expect("far less than the deepest");
    let depths = (2..=14).step_by(2).map(|depth| Accuracy::BoxesAt(at_depth(depth)));
    depths.chain(TriangleTest::ALL.map(Accuracy::Pairs)).collect()
}
