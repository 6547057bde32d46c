//! Simultaneous descent of two trees (section 3 of the paper): box against box down to the leaves,
//! then triangle against triangle, exactly or as closely as is asked for.

use super::node::{AabbNode, Child, ObbNode};
use super::placement::{BoxNode, Placement};
use super::roots::{CutTree, DistributedRoot, RootError, RootPair};
use super::sink::{All, Any, Counts, Gathered, Sink};
use super::wide::{self, Part, Query, Rooms, WideSink};
use super::{TreeKind, TreeView};
use crate::geometry::predicates::{StageCounter, StageCounts};
use crate::geometry::simd::SimdLevel;
use crate::geometry::triangle_test::PreparedTest;
use crate::geometry::{Point, Pose, TriangleTest};

/// (triangle of the fixed mesh, triangle of the moving mesh), numbered as in their files.
pub type Pair = [u32; 2];

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DescentError {
    /// Of all such vertices the first corner of the first triangle; corners count from 0.
    #[error(
        "corner {corner} of triangle {triangle} of the moving mesh leaves the range of 64-bit \
         numbers in this pose"
    )]
    Overflow { triangle: u32, corner: u32 },
    #[error("the trees are of different kinds ({fixed} and {moving}): build both alike")]
    Kinds { fixed: TreeKind, moving: TreeKind },
    #[error("{tree} tree: {source}")]
    Root { tree: &'static str, source: RootError },
}

/// Finds intersecting triangles of two trees. Holds its stack and queues between queries.
#[derive(Debug)]
pub struct Descent {
    level: SimdLevel,
    test: TriangleTest,
    /// Where predicates are counted, if they are.
    counter: Option<StageCounter>,
    stack: Vec<(u32, u32)>,
    wide: Box<Rooms>,
    seeds: Vec<[Part; 2]>,
}

impl Default for Descent {
    fn default() -> Self {
        Self::with_simd(SimdLevel::chosen())
    }
}

impl Descent {
    /// With these instructions for wide trees, or the best below them that the processor has. All
    /// give the same pairs.
    pub fn with_simd(level: SimdLevel) -> Self {
        Self::with(level, TriangleTest::Exact)
    }

    /// A pair is what passes this test, with these instructions for wide trees, or the best below
    /// them that the processor has. [`TriangleTest::F32`] finds other pairs with others.
    pub fn with(level: SimdLevel, test: TriangleTest) -> Self {
        let (stack, seeds) = (Vec::new(), Vec::new());
        Self { level, test, counter: None, stack, wide: Box::default(), seeds }
    }

    /// What is a pair from now on.
    pub fn set_test(&mut self, test: TriangleTest) {
        self.test = test;
    }

    /// Appends every pair to `pairs`, in no particular order.
    pub fn all_pairs(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        pose: &Pose,
        pairs: &mut Vec<Pair>,
    ) -> Result<(), DescentError> {
        self.visit_all(fixed, moving, pose, &mut All(pairs))
    }

    /// As [`Descent::all_pairs`], of the triangles below pairs of distributed roots, each given
    /// once. Those that [`super::roots::PreAnalysis`] finds have all pairs of a pose below them.
    pub fn all_pairs_below(
        &mut self,
        fixed: &CutTree<'_>,
        moving: &CutTree<'_>,
        pose: &Pose,
        roots: &[RootPair],
        pairs: &mut Vec<Pair>,
    ) -> Result<(), DescentError> {
        self.visit_below(fixed, moving, pose, roots, &mut All(pairs))
    }

    /// As [`Descent::any_pair`], of what [`Descent::all_pairs_below`] finds.
    pub fn any_pair_below(
        &mut self,
        fixed: &CutTree<'_>,
        moving: &CutTree<'_>,
        pose: &Pose,
        roots: &[RootPair],
    ) -> Result<bool, DescentError> {
        let mut sink = Any::default();
        self.visit_below(fixed, moving, pose, roots, &mut sink)?;
        Ok(sink.found)
    }

    /// As [`Descent::all_pairs_below`], and tells what it took.
    pub fn counted_pairs_below(
        &mut self,
        fixed: &CutTree<'_>,
        moving: &CutTree<'_>,
        pose: &Pose,
        roots: &[RootPair],
        pairs: &mut Vec<Pair>,
    ) -> Result<Counts, DescentError> {
        let mut sink = Gathered::all(pairs);
        self.visit_below(fixed, moving, pose, roots, &mut sink)?;
        Ok(sink.counts)
    }

    /// [`Accuracy::BoxesAt`](super::Accuracy::BoxesAt) where the pairs of distributed roots that meet
    /// are known: appends them, as long as they are roots that are here and no vertex overflows.
    pub fn boxes_below(
        &mut self,
        fixed: &CutTree<'_>,
        moving: &CutTree<'_>,
        pose: &Pose,
        roots: &[RootPair],
        pairs: &mut Vec<Pair>,
    ) -> Result<(), DescentError> {
        seeds_of(fixed, moving, roots, &mut self.seeds)?;
        check_below(moving, pose, roots)?;
        pairs.extend_from_slice(roots);
        Ok(())
    }

    fn visit_below<K: WideSink>(
        &mut self,
        fixed: &CutTree<'_>,
        moving: &CutTree<'_>,
        pose: &Pose,
        roots: &[RootPair],
        sink: &mut K,
    ) -> Result<(), DescentError> {
        let mut seeds = std::mem::take(&mut self.seeds);
        let found = seeds_of(fixed, moving, roots, &mut seeds).and_then(|()| {
            check_below(moving, pose, roots)?;
            self.visit(fixed.tree(), moving.tree(), Some(&seeds), pose, sink)
        });
        self.seeds = seeds;
        found
    }

    /// As [`Descent::all_pairs`], and tells what it took.
    pub fn counted_pairs(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        pose: &Pose,
        pairs: &mut Vec<Pair>,
    ) -> Result<Counts, DescentError> {
        let mut sink = Gathered::all(pairs);
        self.visit_all(fixed, moving, pose, &mut sink)?;
        Ok(sink.counts)
    }

    /// As [`Descent::counted_pairs`], and tells by which stage of the exact predicates each sign was
    /// decided. Zeros for a test that is not exact; signs that the 32-bit stage of wide trees made
    /// unnecessary are not among them.
    pub fn staged_pairs(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        pose: &Pose,
        pairs: &mut Vec<Pair>,
    ) -> Result<(Counts, StageCounts), DescentError> {
        self.counter = Some(StageCounter::default());
        let found = self.counted_pairs(fixed, moving, pose, pairs);
        let counter = self.counter.take().expect("it was made above");
        Ok((found?, counter.counts()))
    }

    /// Whether there is any pair; stops at the first.
    pub fn any_pair(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        pose: &Pose,
    ) -> Result<bool, DescentError> {
        let mut sink = Any::default();
        self.visit_all(fixed, moving, pose, &mut sink)?;
        Ok(sink.found)
    }

    fn visit_all<K: WideSink>(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        pose: &Pose,
        sink: &mut K,
    ) -> Result<(), DescentError> {
        check_range(moving, pose, 0..moving.triangle_count())?;
        self.visit(fixed, moving, None, pose, sink)
    }

    fn visit<K: WideSink>(
        &mut self,
        fixed: &TreeView<'_>,
        moving: &TreeView<'_>,
        seeds: Option<&[[Part; 2]]>,
        pose: &Pose,
        sink: &mut K,
    ) -> Result<(), DescentError> {
        let placement = Placement::new(fixed, moving, pose);
        let Self { level, test, counter, stack, wide, .. } = self;
        let prepared = PreparedTest::new(*test, placement.static_filter(), counter.as_ref());
        let placement = &placement;
        match (fixed.kind(), moving.kind()) {
            (TreeKind::Wide, TreeKind::Wide) => {
                let trees = [fixed, moving];
                let query = Query { trees, seeds, pose, placement, test: *test, prepared };
                wide::descend(wide, *level, &query, sink);
            }
            (TreeKind::Obb, TreeKind::Obb) => {
                let leaves = Leaves { fixed, moving, pose, test: prepared };
                leaves.descend::<ObbNode, K>(seeds, placement, stack, sink);
            }
            (TreeKind::Aabb, TreeKind::Aabb) => {
                let leaves = Leaves { fixed, moving, pose, test: prepared };
                leaves.descend::<AabbNode, K>(seeds, placement, stack, sink);
            }
            (fixed, moving) => return Err(DescentError::Kinds { fixed, moving }),
        }
        Ok(())
    }
}

/// Leaves of one triangle each, and how those are tested.
struct Leaves<'a> {
    fixed: &'a TreeView<'a>,
    moving: &'a TreeView<'a>,
    pose: &'a Pose,
    test: PreparedTest<'a>,
}

impl Leaves<'_> {
    /// The pair, if it is one, of two leaves whose boxes meet.
    #[inline]
    fn intersect(&self, a: u32, b: u32) -> Option<Pair> {
        let found = matches!(self.test, PreparedTest::Boxes) || {
            let placed = self.moving.corners(b).map(|v| self.pose.apply(v));
            self.test.intersect(&self.fixed.corners(a), &placed)
        };
        found.then(|| {
            [self.fixed.triangles()[a as usize].id, self.moving.triangles()[b as usize].id]
        })
    }

    fn descend<N: BoxNode, K: Sink>(
        &self,
        seeds: Option<&[[Part; 2]]>,
        placement: &Placement,
        stack: &mut Vec<(u32, u32)>,
        sink: &mut K,
    ) {
        let (a_nodes, b_nodes) = (self.fixed.nodes::<N>(), self.moving.nodes::<N>());
        stack.clear();
        for [a, b] in seeds.unwrap_or(&[[Part::FIRST; 2]]) {
            sink.boxes(1);
            if !a_nodes[a.node as usize].apart(&b_nodes[b.node as usize], placement) {
                stack.push((a.node, b.node));
            }
        }
        while let Some((a, b)) = stack.pop() {
            let (a_node, b_node) = (&a_nodes[a as usize], &b_nodes[b as usize]);
            match (a_node.link().child(), b_node.link().child()) {
                (Child::Leaf { rank: a }, Child::Leaf { rank: b }) => {
                    sink.triangles(1);
                    if let Some(pair) = self.intersect(a, b) {
                        sink.take(pair);
                        if sink.has_enough() {
                            return;
                        }
                    }
                }
                (Child::Inner { right }, b_child)
                    if matches!(b_child, Child::Leaf { .. })
                        || placement.first_is_larger(a_node, b_node) =>
                {
                    sink.boxes(2);
                    for child in [a + right, a + 1] {
                        if !a_nodes[child as usize].apart(b_node, placement) {
                            stack.push((child, b));
                        }
                    }
                }
                (_, Child::Inner { right }) => {
                    sink.boxes(2);
                    for child in [b + right, b + 1] {
                        if !a_node.apart(&b_nodes[child as usize], placement) {
                            stack.push((a, child));
                        }
                    }
                }
                (Child::Inner { .. }, Child::Leaf { .. }) => unreachable!("the second arm's case"),
            }
        }
    }
}

/// What the descents below these pairs start from. In a wide tree pairs that lie side by side
/// become one: then a box is tested against more lanes at a time.
fn seeds_of(
    fixed: &CutTree<'_>,
    moving: &CutTree<'_>,
    roots: &[RootPair],
    seeds: &mut Vec<[Part; 2]>,
) -> Result<(), DescentError> {
    seeds.clear();
    for &[i, j] in roots {
        let a = fixed.part(i).map_err(|source| DescentError::Root { tree: "fixed", source })?;
        let b = moving.part(j).map_err(|source| DescentError::Root { tree: "moving", source })?;
        match seeds.last_mut() {
            Some([last, other]) if last.node == a.node && *other == b => last.bits |= a.bits,
            Some([other, last]) if last.node == b.node && *other == a => last.bits |= b.bits,
            _ => seeds.push([a, b]),
        }
    }
    Ok(())
}

/// As [`check_range`], of the triangles below root pairs that are known to be right.
fn check_below(moving: &CutTree<'_>, pose: &Pose, roots: &[RootPair]) -> Result<(), DescentError> {
    let roots = roots.iter().map(|&[_, root]| &moving.roots()[root as usize]);
    check_range(moving.tree(), pose, roots.flat_map(DistributedRoot::ranks))
}

/// An error if a placed vertex of triangles of these ranks overflows. Looks at single vertices only
/// if the bounds might.
pub(super) fn check_range(
    moving: &TreeView<'_>,
    pose: &Pose,
    ranks: impl Iterator<Item = u32>,
) -> Result<(), DescentError> {
    let header = moving.header();
    let far: Point = [0, 1, 2].map(|i| header.low[i].abs().max(header.high[i].abs()));
    if pose.reach(far).iter().all(|c| c.is_finite()) {
        return Ok(());
    }
    let overflows = |v: &Point| !pose.apply(*v).iter().all(|c| c.is_finite());
    let corners = ranks.filter_map(|rank| {
        let corner = moving.corners(rank).iter().position(overflows)?;
        Some((moving.triangles()[rank as usize].id, corner as u32))
    });
    match corners.min() {
        None => Ok(()),
        Some((triangle, corner)) => Err(DescentError::Overflow { triangle, corner }),
    }
}
