//! Every case in every way there is to answer it.

use std::collections::HashMap;
use std::fmt;

use rayon::prelude::*;
use serde::Serialize;

use super::{Cases, MeshCase, PairCase, Suite, TransformCase};
use crate::geometry::boxes::bounds;
use crate::geometry::predicates::StaticFilter;
use crate::geometry::simd::SimdLevel;
use crate::geometry::triangle_test::PreparedTest;
use crate::geometry::{Pose, Triangle, TriangleTest};
use crate::mesh::TriangleMesh;
use crate::tree::descent::{Descent, Pair};
use crate::tree::roots::PreAnalysis;
use crate::tree::{Accuracy, BoxDepth, BuildOptions, TreeKind, TreeView, build};

/// Of the level that only looks at the boxes there.
fn depth() -> BoxDepth {
    BoxDepth::new(4).expect("it is not too deep")
}

/// The code that answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Way {
    /// The test of one triangle against another.
    Triangles,
    /// The descent of two trees of this kind. Only wide ones use vector instructions.
    Trees(TreeKind, SimdLevel),
    /// The placing of a point.
    Pose,
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Triangles => f.write_str("triangle pair"),
            Self::Trees(TreeKind::Wide, simd) => write!(f, "{} {simd}", TreeKind::Wide),
            Self::Trees(kind, _) => kind.fmt(f),
            Self::Pose => f.write_str("pose"),
        }
    }
}

impl Serialize for Way {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// All that differ on this machine.
fn tree_ways() -> impl Iterator<Item = (TreeKind, SimdLevel)> {
    TreeKind::ALL.into_iter().flat_map(|kind| {
        let levels = match kind {
            TreeKind::Wide => SimdLevel::available(),
            TreeKind::Obb | TreeKind::Aabb => vec![SimdLevel::Portable],
        };
        levels.into_iter().map(move |simd| (kind, simd))
    })
}

/// The cases of a family that were answered at one level in one way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub family: String,
    pub level: Accuracy,
    pub way: Way,
    pub cases: u32,
    pub wrong: u32,
}

/// A case that was answered wrongly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wrong {
    pub suite: String,
    pub line: usize,
    pub family: String,
    pub level: Accuracy,
    pub way: Way,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// From the coarsest to exact.
    pub levels: Vec<Accuracy>,
    pub cases: usize,
    /// Families in the order of the suites, the ways of each together.
    pub rows: Vec<Row>,
    /// In exact.
    pub wrong: Vec<Wrong>,
}

/// What one case came to: the ways in which it was answered, and whether rightly.
struct Outcome<'a> {
    family: &'a str,
    line: usize,
    answers: Vec<(Accuracy, Way, bool)>,
}

/// Answers every case of the suites at every level in every way that applies. `on_done` is told of
/// some more cases that are done, from any thread.
pub fn check(suites: &[Suite], on_done: &(dyn Fn(u64) + Sync)) -> Report {
    let levels =
        [Accuracy::BoxesAt(depth())].into_iter().chain(TriangleTest::ALL.map(Accuracy::Pairs));
    let report = Report { levels: levels.collect(), cases: 0, rows: Vec::new(), wrong: Vec::new() };
    let mut count = Count { report, rows: HashMap::new() };
    for suite in suites {
        let outcomes = match &suite.cases {
            Cases::Pairs(cases) => outcomes(cases, pair_case, on_done),
            Cases::Meshes(cases) => outcomes(cases, mesh_case, on_done),
            Cases::Transforms(cases) => outcomes(cases, transform_case, on_done),
        };
        for outcome in outcomes {
            count.add(&suite.name, &outcome);
        }
    }
    count.report
}

/// In the order of the cases.
fn outcomes<'a, C: Sync>(
    cases: &'a [C],
    answer: impl Fn(&mut Descents, &'a C) -> Outcome<'a> + Sync,
    on_done: &(dyn Fn(u64) + Sync),
) -> Vec<Outcome<'a>> {
    const TOGETHER: usize = 64;
    let of_some = |some: &'a [C]| {
        let mut descents = Descents::new();
        let outcomes: Vec<_> = some.iter().map(|case| answer(&mut descents, case)).collect();
        on_done(some.len() as u64);
        outcomes
    };
    cases.par_chunks(TOGETHER).flat_map_iter(of_some).collect()
}

/// A report in the making.
struct Count<'a> {
    report: Report,
    /// Where in the report each row is.
    rows: HashMap<(&'a str, Accuracy, Way), usize>,
}

impl<'a> Count<'a> {
    fn add(&mut self, suite: &str, outcome: &Outcome<'a>) {
        let &Outcome { family, line, ref answers } = outcome;
        self.report.cases += 1;
        for &(level, way, right) in answers {
            let row = self.row(family, level, way);
            row.cases += 1;
            row.wrong += u32::from(!right);
            if !right && level == Accuracy::EXACT {
                let (suite, family) = (suite.to_owned(), family.to_owned());
                self.report.wrong.push(Wrong { suite, line, family, level, way });
            }
        }
    }

    fn row(&mut self, family: &'a str, level: Accuracy, way: Way) -> &mut Row {
        let rows = &mut self.report.rows;
        let at = *self.rows.entry((family, level, way)).or_insert_with(|| {
            rows.push(Row { family: family.to_owned(), level, way, cases: 0, wrong: 0 });
            rows.len() - 1
        });
        &mut rows[at]
    }
}

/// One for each way to descend.
struct Descents {
    all: Vec<(TreeKind, SimdLevel, Descent)>,
    pairs: Vec<Pair>,
}

impl Descents {
    fn new() -> Self {
        let descent = |(kind, simd)| (kind, simd, Descent::with_simd(simd));
        Self { all: tree_ways().map(descent).collect(), pairs: Vec::new() }
    }

    /// Whether the meshes' pairs are these, in ascending order.
    fn answers(
        &mut self,
        meshes: [&TriangleMesh; 2],
        pose: &Pose,
        truth: &[Pair],
    ) -> Vec<(Accuracy, Way, bool)> {
        let mut answers = Vec::new();
        for kind in TreeKind::ALL {
            let images = meshes.map(|mesh| build(mesh, BuildOptions { kind }));
            let trees = images.each_ref().map(|image| image.view());
            for (_, simd, descent) in self.all.iter_mut().filter(|(of, ..)| *of == kind) {
                for test in TriangleTest::ALL {
                    descent.set_test(test);
                    let right = finds(descent, trees, pose, truth, &mut self.pairs);
                    answers.push((Accuracy::Pairs(test), Way::Trees(kind, *simd), right));
                }
            }
            answers.push(boxes_answer(trees, pose, truth));
        }
        answers
    }
}

/// Whether the descent finds the pairs, and also that there are any.
fn finds(
    descent: &mut Descent,
    [fixed, moving]: [TreeView<'_>; 2],
    pose: &Pose,
    truth: &[Pair],
    pairs: &mut Vec<Pair>,
) -> bool {
    pairs.clear();
    let found = descent.all_pairs(&fixed, &moving, pose, pairs);
    pairs.sort_unstable();
    found.is_ok()
        && *pairs == truth
        && descent.any_pair(&fixed, &moving, pose) == Ok(!truth.is_empty())
}

/// Whether boxes of the trees meet, all of which are looked at with the best instructions.
fn boxes_answer(
    [fixed, moving]: [TreeView<'_>; 2],
    pose: &Pose,
    truth: &[Pair],
) -> (Accuracy, Way, bool) {
    let cut = depth().cut();
    let mut boxes = Vec::new();
    let found = PreAnalysis::new(fixed, cut, moving, cut).boxes_that_meet(pose, &mut boxes).is_ok();
    let simd = match fixed.kind() {
        TreeKind::Wide => SimdLevel::chosen(),
        TreeKind::Obb | TreeKind::Aabb => SimdLevel::Portable,
    };
    let right = found && boxes.is_empty() == truth.is_empty();
    (Accuracy::BoxesAt(depth()), Way::Trees(fixed.kind(), simd), right)
}

/// As two triangles, and as two meshes of one triangle each.
fn pair_case<'a>(descents: &mut Descents, case: &'a PairCase) -> Outcome<'a> {
    let (low, high) = bounds(case.a.iter().chain(&case.b));
    let filter = StaticFilter::for_extent([0, 1, 2].map(|k| high[k] - low[k]));
    let answer = |test| PreparedTest::new(test, filter, None).intersect(&case.a, &case.b);
    let right = |test| (Accuracy::Pairs(test), Way::Triangles, answer(test) == case.intersect());
    let mut answers = TriangleTest::ALL.map(right).to_vec();
    let meshes = [&case.a, &case.b].map(mesh_of);
    let truth: &[Pair] = if case.intersect() { &[[0, 0]] } else { &[] };
    answers.extend(descents.answers(meshes.each_ref(), &Pose::IDENTITY, truth));
    Outcome { family: &case.family, line: case.line, answers }
}

fn mesh_of(triangle: &Triangle) -> TriangleMesh {
    TriangleMesh::new(triangle.to_vec(), vec![[0, 1, 2]]).expect("its numbers are finite")
}

fn mesh_case<'a>(descents: &mut Descents, case: &'a MeshCase) -> Outcome<'a> {
    let pose = Pose::from_quaternion(case.quaternion, case.pose.translation);
    let right = bits(&pose.rotation).eq(bits(&case.pose.rotation));
    let mut answers = descents.answers([&case.fixed, &case.moving], &case.pose, &case.pairs);
    answers.push((Accuracy::EXACT, Way::Pose, right));
    Outcome { family: case.family(), line: case.line, answers }
}

fn transform_case<'a>(_: &mut Descents, case: &'a TransformCase) -> Outcome<'a> {
    let pose = Pose::from_quaternion(case.quaternion, case.translation);
    let right = bits(&pose.rotation).eq(bits(&case.rotation))
        && bits(&pose.apply(case.point)).eq(bits(&case.placed));
    let answers = vec![(Accuracy::EXACT, Way::Pose, right)];
    Outcome { family: "transforms", line: case.line, answers }
}

fn bits(numbers: &[f64]) -> impl Iterator<Item = u64> {
    numbers.iter().map(|number| number.to_bits())
}
