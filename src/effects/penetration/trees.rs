use super::Bodies;
use crate::effects::inside::{Nesting, OutOfRange};
use crate::geometry::{Point, Pose, Triangle};
use crate::mesh::closed::Shells;
use crate::tree::TreeView;
use crate::tree::descent::{Descent, DescentError, Pair};

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TreeError {
    #[error(transparent)]
    Descent(#[from] DescentError),
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
}

/// Two meshes by their trees and the parts that their triangles make.
#[derive(Debug)]
pub struct Trees<'a> {
    trees: [TreeView<'a>; 2],
    /// Each triangle's number in its file and its rank among the leaves, sorted.
    ranks: [Vec<[u32; 2]>; 2],
    shells: [Shells; 2],
    descent: &'a mut Descent,
    nesting: Nesting,
}

impl<'a> Trees<'a> {
    pub fn new(fixed: TreeView<'a>, moving: TreeView<'a>, descent: &'a mut Descent) -> Self {
        let trees = [fixed, moving];
        let shells = |tree: &TreeView<'_>| {
            Shells::of(tree.vertices(), tree.triangles().iter().map(|triangle| triangle.vertices))
        };
        let (ranks, shells) = (trees.each_ref().map(ranks), trees.each_ref().map(shells));
        Self { trees, ranks, shells, descent, nesting: Nesting::default() }
    }
}

fn ranks(tree: &TreeView<'_>) -> Vec<[u32; 2]> {
    let triangles = tree.triangles().iter().zip(0..);
    let mut ranks: Vec<_> = triangles.map(|(triangle, rank)| [triangle.id, rank]).collect();
    ranks.sort_unstable();
    ranks
}

impl Bodies for Trees<'_> {
    type Error = TreeError;

    fn pairs(&mut self, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<(), TreeError> {
        let [fixed, moving] = &self.trees;
        Ok(self.descent.all_pairs(fixed, moving, pose, pairs)?)
    }

    fn way_out(&mut self, pose: &Pose, direction: &Point) -> Result<Option<f64>, TreeError> {
        let [fixed, moving] = &self.shells;
        Ok(self.nesting.way_out(fixed, moving, pose, direction)?)
    }

    fn triangles(&self, [a, b]: Pair) -> [Triangle; 2] {
        [(0, a), (1, b)].map(|(i, id)| {
            let at = self.ranks[i].partition_point(|&[other, _]| other < id);
            self.trees[i].corners(self.ranks[i][at][1])
        })
    }

    fn reach(&self) -> [Point; 2] {
        self.trees.each_ref().map(|tree| {
            let header = tree.header();
            [0, 1, 2].map(|k| header.low[k].abs().max(header.high[k].abs()))
        })
    }
}
