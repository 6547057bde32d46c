use super::Bodies;
use crate::effects::Kept;
use crate::effects::inside::{Nesting, OutOfRange};
use crate::geometry::{Point, Pose, Triangle};
use crate::mesh::closed::Shells;
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::tree::{ByNumber, TreeView};

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TreeError {
    #[error(transparent)]
    Descent(#[from] DescentError),
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
}

/// Two meshes by their trees and the parts that their triangles make.
pub struct Trees<'a> {
    trees: [TreeView<'a>; 2],
    meshes: [(&'a Shells, ByNumber<'a>); 2],
    descent: &'a mut Descent,
    nesting: &'a mut Nesting,
}

impl<'a> Trees<'a> {
    /// The fixed and the moving tree, and what is kept of each.
    pub fn new(
        trees: [TreeView<'a>; 2],
        kept: &'a mut [Kept; 2],
        descent: &'a mut Descent,
        nesting: &'a mut Nesting,
    ) -> Self {
        let [of_fixed, of_moving] = kept;
        let meshes = [of_fixed.shells(&trees[0]), of_moving.shells(&trees[1])];
        Self { trees, meshes, descent, nesting }
    }
}

impl Bodies for Trees<'_> {
    type Error = TreeError;

    fn pairs(&mut self, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<(), TreeError> {
        let [fixed, moving] = &self.trees;
        Ok(self.descent.all_pairs(fixed, moving, pose, pairs)?)
    }

    fn way_out(&mut self, pose: &Pose, direction: &Point) -> Result<Option<f64>, TreeError> {
        let [(fixed, _), (moving, _)] = &self.meshes;
        Ok(self.nesting.way_out(fixed, moving, pose, direction)?)
    }

    fn triangles(&self, pair: Pair) -> [Triangle; 2] {
        [0, 1].map(|side: usize| self.meshes[side].1.triangle(pair[side]))
    }

    fn reach(&self) -> [Point; 2] {
        self.trees.each_ref().map(|tree| {
            let header = tree.header();
            [0, 1, 2].map(|k| header.low[k].abs().max(header.high[k].abs()))
        })
    }
}
