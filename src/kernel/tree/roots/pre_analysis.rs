use super::top::{Top, top_of};
use super::{Cut, CutTree, DistributedRoot, RootPair};
use crate::geometry::Pose;
use crate::geometry::simd::SimdLevel;
use crate::tree::descent::{DescentError, check_range};
use crate::tree::node::ObbNode;
use crate::tree::placement::{BoxNode, Placement};
use crate::tree::wide::{self, Queues, WideNode};
use crate::tree::{TreeKind, TreeView};

/// Pre-analysis of scenarios: the pairs of distributed roots whose boxes meet.
///
/// Whatever kind the trees are, what is above the roots is descended as a wide tree of its own.
#[derive(Debug)]
pub struct PreAnalysis<'a> {
    fixed: Side<'a>,
    moving: Side<'a>,
    queues: Box<Queues>,
}

#[derive(Debug)]
struct Side<'a> {
    cut: CutTree<'a>,
    /// Its leaves are the roots, by number.
    top: Vec<WideNode>,
}

impl<'a> Side<'a> {
    fn new(tree: TreeView<'a>, cut: Cut) -> Self {
        let Top { nodes, roots } = top_of(&tree, cut);
        Self { cut: CutTree::from_roots(tree, roots), top: wide::collapsed(&nodes) }
    }

    fn tree(&self) -> &TreeView<'a> {
        self.cut.tree()
    }

    fn detach(self) -> DetachedSide {
        DetachedSide { roots: self.cut.into_roots(), top: self.top }
    }
}

/// A [`PreAnalysis`] without its trees, to be kept where they are not borrowed for as long.
#[derive(Debug)]
pub struct Detached {
    fixed: DetachedSide,
    moving: DetachedSide,
    queues: Box<Queues>,
}

#[derive(Debug)]
struct DetachedSide {
    roots: Vec<DistributedRoot>,
    top: Vec<WideNode>,
}

impl DetachedSide {
    fn attach(self, tree: TreeView<'_>) -> Side<'_> {
        Side { cut: CutTree::from_roots(tree, self.roots), top: self.top }
    }
}

impl Detached {
    /// `fixed` and `moving`: the trees that it was made of, wherever they are now.
    pub fn attach<'a>(self, fixed: TreeView<'a>, moving: TreeView<'a>) -> PreAnalysis<'a> {
        let Self { fixed: fixed_side, moving: moving_side, queues } = self;
        let (fixed, moving) = (fixed_side.attach(fixed), moving_side.attach(moving));
        PreAnalysis { fixed, moving, queues }
    }
}

impl<'a> PreAnalysis<'a> {
    /// # Panics
    /// If the trees are of different kinds.
    pub fn new(fixed: TreeView<'a>, fixed_cut: Cut, moving: TreeView<'a>, moving_cut: Cut) -> Self {
        assert_eq!(fixed.kind(), moving.kind(), "trees of one scene are of one kind");
        let (fixed, moving) = (Side::new(fixed, fixed_cut), Side::new(moving, moving_cut));
        Self { fixed, moving, queues: Box::default() }
    }

    pub fn detach(self) -> Detached {
        let Self { fixed, moving, queues } = self;
        Detached { fixed: fixed.detach(), moving: moving.detach(), queues }
    }

    /// What a descent below root pairs starts from.
    pub fn fixed(&self) -> &CutTree<'a> {
        &self.fixed.cut
    }

    pub fn moving(&self) -> &CutTree<'a> {
        &self.moving.cut
    }

    pub fn fixed_roots(&self) -> &[DistributedRoot] {
        self.fixed.cut.roots()
    }

    pub fn moving_roots(&self) -> &[DistributedRoot] {
        self.moving.cut.roots()
    }

    /// [`PreAnalysis::overlapping_roots`] as the answer to a scenario, which has none if a vertex of
    /// it overflows.
    pub fn boxes_that_meet(
        &mut self,
        pose: &Pose,
        pairs: &mut Vec<RootPair>,
    ) -> Result<u64, DescentError> {
        let moving = self.moving.tree();
        check_range(moving, pose, 0..moving.triangle_count())?;
        Ok(self.overlapping_roots(pose, pairs))
    }

    /// Replaces `pairs` by those whose boxes meet, each once. Every intersecting pair of triangles
    /// lies below one of them. Returns how many pairs of boxes were tested.
    pub fn overlapping_roots(&mut self, pose: &Pose, pairs: &mut Vec<RootPair>) -> u64 {
        pairs.clear();
        let Self { fixed, moving, queues } = self;
        let (tops, trees) = ([&fixed.top[..], &moving.top[..]], [fixed.tree(), moving.tree()]);
        let mut tests = wide::meeting_leaves(queues, SimdLevel::chosen(), tops, trees, pose, pairs);
        if fixed.tree().kind() == TreeKind::Obb {
            let placement = Placement::new(fixed.tree(), moving.tree(), pose);
            let [a, b] =
                [fixed, moving].map(|side| (side.tree().nodes::<ObbNode>(), side.cut.roots()));
            let node = |(nodes, roots): (&'a [ObbNode], &[DistributedRoot]), number: u32| {
                nodes[roots[number as usize].node as usize]
            };
            tests += pairs.len() as u64;
            pairs.retain(|&[i, j]| !node(a, i).apart(&node(b, j), &placement));
        }
        tests
    }
}
