//! What a level of accuracy finds, held against the exact pairs.

use std::collections::BTreeSet;

use crate::tree::ByNumber;
use crate::tree::descent::Pair;
use crate::tree::roots::{DistributedRoot, RootPair};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Exact pairs that are not found.
    pub missing: u64,
    /// Pairs that are found, and are none.
    pub extra: u64,
}

impl Difference {
    /// Both sorted.
    pub fn of_pairs(truth: &[Pair], found: &[Pair]) -> Self {
        if truth == found {
            return Self { missing: 0, extra: 0 };
        }
        let [truth, found]: [BTreeSet<_>; 2] = [truth, found].map(|pairs| pairs.iter().collect());
        let count = |a: &BTreeSet<_>, b| a.difference(b).count() as u64;
        Self { missing: count(&truth, &found), extra: count(&found, &truth) }
    }

    /// Pairs of boxes, sorted, which stand for all pairs of triangles below them. `roots`: whose boxes
    /// they are, of each tree.
    pub fn of_boxes(
        truth: &[Pair],
        boxes: &[RootPair],
        roots: [&[DistributedRoot]; 2],
        meshes: &[ByNumber<'_>; 2],
    ) -> Self {
        let root = |side: usize, number: u32| {
            let rank = meshes[side].rank(number);
            // Roots are in the order of their ranks, and every rank is below one.
            roots[side].partition_point(|root| root.first <= rank) as u32 - 1
        };
        let is_found = |&&[i, j]: &&Pair| boxes.binary_search(&[root(0, i), root(1, j)]).is_ok();
        let found = truth.iter().filter(is_found).count() as u64;
        let triangles = |side: usize, root: u32| u64::from(roots[side][root as usize].triangles);
        let stood_for: u64 = boxes.iter().map(|&[i, j]| triangles(0, i) * triangles(1, j)).sum();
        let extra = stood_for.checked_sub(found).expect("what is found is below the boxes");
        Self { missing: truth.len() as u64 - found, extra }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::mesh::MeshSource;
    use crate::tree::descent::Descent;
    use crate::tree::roots::{Cut, PreAnalysis};
    use crate::tree::{BuildOptions, TreeKind, build};

    #[test]
    fn a_pair_of_boxes_that_is_lost_is_seen_by_the_pairs_below_it() {
        let mesh = "builtin:blocks?triangles=350".parse::<MeshSource>().unwrap().load().unwrap();
        let pose = Pose { translation: [0.75, 0.0, 0.25], ..Pose::IDENTITY };
        for kind in TreeKind::ALL {
            let image = build(&mesh, BuildOptions { kind });
            let tree = image.view();
            let (mut truth, mut boxes) = (Vec::new(), Vec::new());
            Descent::default().all_pairs(&tree, &tree, &pose, &mut truth).unwrap();
            let mut analysis = PreAnalysis::new(tree, Cut::Depth(4), tree, Cut::Depth(3));
            analysis.boxes_that_meet(&pose, &mut boxes).unwrap();
            boxes.sort_unstable();
            let meshes = [ByNumber::new(tree), ByNumber::new(tree)];
            let roots = [analysis.fixed_roots(), analysis.moving_roots()];
            let all = Difference::of_boxes(&truth, &boxes, roots, &meshes);
            assert_eq!(all.missing, 0);
            // Each pair lies below one pair of boxes, so what each alone has adds up.
            let alone: Vec<Difference> = (0..boxes.len())
                .map(|at| Difference::of_boxes(&truth, &boxes[at..=at], roots, &meshes))
                .collect();
            let count = truth.len() as u64;
            assert_eq!(alone.iter().map(|one| count - one.missing).sum::<u64>(), count);
            assert_eq!(alone.iter().map(|one| one.extra).sum::<u64>(), all.extra);
            let lost = alone.iter().position(|one| one.missing < count).unwrap();
            boxes.remove(lost);
            let without = Difference::of_boxes(&truth, &boxes, roots, &meshes);
            assert_eq!(without.missing, count - alone[lost].missing);
            assert_eq!(without.extra, all.extra - alone[lost].extra);
        }
    }

    #[test]
    fn pairs_are_missing_or_extra() {
        let difference = Difference::of_pairs(&[[0, 1], [2, 3]], &[[0, 1], [1, 1], [5, 0]]);
        assert_eq!(difference, Difference { missing: 1, extra: 2 });
    }
}
