//! Builds a tree top down (sections 6.1 and 6.2 of the paper), on all cores, the same bits on any
//! number of them: every subtree knows its place in the output beforehand.

use rayon::prelude::*;

use super::fit::{Axes, IDENTITY, fit_box, gaussian_axes, triangle_axes};
use super::node::{AabbNode, Link, Node, ObbNode};
use super::split::{Interval, SweepRoom, median_split, weighted_sweep};
use crate::geometry::Triangle;

/// Below this many triangles a subtree is not worth another task.
const PARALLEL_BUILD: usize = 2048;

/// From this depth on sets are halved, so that no mesh, however it is made, gets a deep tree.
const HALVE_FROM_DEPTH: u32 = 48;

/// Which way a box of a kind is turned.
pub trait Orient: Node {
    fn axes(triangles: &[Triangle], ids: &[u32]) -> Axes;
}

impl Orient for ObbNode {
    fn axes(triangles: &[Triangle], ids: &[u32]) -> Axes {
        match ids {
            [id] => triangle_axes(&triangles[*id as usize]),
            _ => gaussian_axes(triangles, ids),
        }
    }
}

impl Orient for AabbNode {
    fn axes(_triangles: &[Triangle], _ids: &[u32]) -> Axes {
        IDENTITY
    }
}

/// What a subtree is made in: each slice is as long as its set of triangles.
struct Room<'a> {
    ids: &'a mut [u32],
    intervals: &'a mut [Interval],
    sweep: SweepRoom<'a>,
}

impl<'a> Room<'a> {
    fn reborrow(&mut self) -> Room<'_> {
        let SweepRoom { sorted, lowest_after, order } = &mut self.sweep;
        let sweep = SweepRoom { sorted, lowest_after, order };
        Room { ids: self.ids, intervals: self.intervals, sweep }
    }

    fn split_at(self, count: usize) -> (Self, Self) {
        let (ids, ids_right) = self.ids.split_at_mut(count);
        let (intervals, intervals_right) = self.intervals.split_at_mut(count);
        let (sorted, sorted_right) = self.sweep.sorted.split_at_mut(count);
        let (lowest_after, lowest_right) = self.sweep.lowest_after.split_at_mut(count);
        let (order, order_right) = self.sweep.order.split_at_mut(count);
        let left = SweepRoom { sorted, lowest_after, order };
        let right =
            SweepRoom { sorted: sorted_right, lowest_after: lowest_right, order: order_right };
        (
            Self { ids, intervals, sweep: left },
            Self { ids: ids_right, intervals: intervals_right, sweep: right },
        )
    }

    /// Puts the ids in the order that the split chose.
    fn reorder(&mut self) {
        let chosen = self.sweep.order.iter().map(|&i| self.ids[i as usize]);
        for (slot, id) in self.sweep.sorted.iter_mut().zip(chosen) {
            *slot = u64::from(id);
        }
        for (id, &slot) in self.ids.iter_mut().zip(self.sweep.sorted.iter()) {
            *id = slot as u32;
        }
    }
}

/// The nodes depth first, and the triangles' numbers in the order of their leaves.
pub fn build_nodes<N: Orient>(triangles: &[Triangle]) -> (Vec<N>, Vec<u32>) {
    let n = triangles.len();
    let mut nodes = Vec::new();
    (0..2 * n - 1).into_par_iter().map(|_| N::zeroed()).collect_into_vec(&mut nodes);
    let mut ids: Vec<u32> = (0..n as u32).collect();
    let room = Room {
        ids: &mut ids,
        intervals: &mut vec![Interval::default(); n],
        sweep: SweepRoom {
            sorted: &mut vec![0; n],
            lowest_after: &mut vec![0.0; n],
            order: &mut vec![0; n],
        },
    };
    Subtree { nodes: &mut nodes, room, first_rank: 0, depth: 0 }.build(triangles);
    (nodes, ids)
}

struct Subtree<'a, N> {
    nodes: &'a mut [N],
    room: Room<'a>,
    first_rank: u32,
    depth: u32,
}

impl<N: Orient> Subtree<'_, N> {
    fn build(self, triangles: &[Triangle]) {
        if self.room.ids.len() < PARALLEL_BUILD {
            self.build_gathered(triangles);
        } else if let Some([left, right]) = self.split(triangles) {
            rayon::join(|| left.build(triangles), || right.build(triangles));
        }
    }

    /// From a copy of its triangles that are together and stay in the cache.
    fn build_gathered(mut self, triangles: &[Triangle]) {
        let ids = &mut *self.room.ids;
        let gathered: Vec<Triangle> = ids.iter().map(|&id| triangles[id as usize]).collect();
        let names = ids.to_vec();
        ids.iter_mut().zip(0..).for_each(|(id, number)| *id = number);
        let Self { nodes, room, first_rank, depth } = &mut self;
        Subtree { nodes, room: room.reborrow(), first_rank: *first_rank, depth: *depth }
            .build_alone(&gathered);
        self.room.ids.iter_mut().for_each(|id| *id = names[*id as usize]);
    }

    fn build_alone(self, triangles: &[Triangle]) {
        if let Some([left, right]) = self.split(triangles) {
            left.build_alone(triangles);
            right.build_alone(triangles);
        }
    }
}

impl<'a, N: Orient> Subtree<'a, N> {
    /// Makes the root; both subtrees below, none below a leaf.
    fn split(self, triangles: &[Triangle]) -> Option<[Self; 2]> {
        let Self { nodes, mut room, first_rank, depth } = self;
        let axes = N::axes(triangles, room.ids);
        let fit = fit_box(triangles, room.ids, &axes, room.intervals);
        let (root, below) = nodes.split_first_mut()?;
        if room.ids.len() == 1 {
            *root = N::new(fit.center, fit.half, &axes, Link::leaf(first_rank));
            return None;
        }
        let swept = if depth < HALVE_FROM_DEPTH {
            weighted_sweep(room.intervals, &mut room.sweep)
        } else {
            None
        };
        let count = swept.unwrap_or_else(|| median_split(room.intervals, &mut room.sweep));
        room.reorder();
        *root = N::new(fit.center, fit.half, &axes, Link::inner(2 * count as u32));
        let (left, right) = below.split_at_mut(2 * count - 1);
        let (left_room, right_room) = room.split_at(count);
        let right_rank = first_rank + count as u32;
        let depth = depth + 1;
        Some([
            Subtree { nodes: left, room: left_room, first_rank, depth },
            Subtree { nodes: right, room: right_room, first_rank: right_rank, depth },
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::super::node::{Child, widen};
    use super::*;
    use crate::geometry::Point;

    /// Depth of the deepest leaf; panics unless every node's box contains its triangles.
    fn checked_depth<N: Orient>(triangles: &[Triangle], frame: fn(&N) -> ([f32; 3], Axes)) -> u32 {
        let (nodes, ids) = build_nodes::<N>(triangles);
        let mut seen = ids.clone();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..triangles.len() as u32), "each triangle has one leaf");
        let mut open = vec![(0, 0..ids.len(), 0)];
        let mut deepest = 0;
        while let Some((at, ranks, depth)) = open.pop() {
            deepest = deepest.max(depth);
            let (center, axes) = frame(&nodes[at]);
            let (center, half) = (widen(center), nodes[at].half());
            for v in ids[ranks.clone()].iter().flat_map(|&id| triangles[id as usize]) {
                assert!(contains(center, half, &axes, v), "node {at} lacks {v:?}");
            }
            if let Child::Inner { right } = nodes[at].link().child() {
                let middle = ranks.start + right as usize / 2;
                open.push((at + 1, ranks.start..middle, depth + 1));
                open.push((at + right as usize, middle..ranks.end, depth + 1));
            }
        }
        deepest
    }

    /// In the skewed frame of the rounded axes, as the descent takes a box to be.
    fn contains(center: Point, half: Point, axes: &Axes, v: Point) -> bool {
        let columns = axes.map(|row| nalgebra::Vector3::from(widen(row)));
        let matrix = nalgebra::Matrix3::from_columns(&columns);
        let from_center = nalgebra::Vector3::from([0, 1, 2].map(|i| v[i] - center[i]));
        let s = matrix.try_inverse().expect("axes are independent") * from_center;
        (0..3).all(|i| s[i].abs() <= half[i] + 1e-14)
    }

    fn soup(size: u32) -> Vec<Triangle> {
        let wave = |i: u32, k: u32| f64::from((i * 37 + k * k * 101) % 83) / 83.0 - 0.5;
        let near = |i: u32, k: u32| f64::from((i * 13 + k * 7) % 11) / 500.0;
        (0..size)
            .map(|i| [0, 3, 6].map(|corner| [0, 1, 2].map(|k| wave(i, k) + near(i, corner + k))))
            .collect()
    }

    #[test]
    fn every_box_contains_its_triangles_for_1_to_100_triangles() {
        for size in 1..=100 {
            checked_depth::<ObbNode>(&soup(size), |node| (node.center, node.axes));
            checked_depth::<AabbNode>(&soup(size), |node| (node.center, IDENTITY));
        }
    }

    #[test]
    fn a_tree_of_scattered_triangles_is_not_deep() {
        let depth = checked_depth::<ObbNode>(&soup(4096), |node| (node.center, node.axes));
        assert!((12..=30).contains(&depth), "depth {depth}");
    }

    #[test]
    fn equal_nested_and_degenerate_triangles_do_not_make_a_tree_deep() {
        let equal = vec![[[0.1, 0.2, 0.3], [0.4, 0.2, 0.3], [0.1, 0.5, 0.3]]; 3000];
        let points = vec![[[0.5; 3]; 3]; 3000];
        let nested: Vec<Triangle> = (0..1000)
            .map(|i| {
                let size = 0.5_f64.powi(i % 120);
                [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]]
            })
            .collect();
        for triangles in [equal, points, nested] {
            let limit = HALVE_FROM_DEPTH + triangles.len().ilog2() + 1;
            assert!(checked_depth::<ObbNode>(&triangles, |node| (node.center, node.axes)) <= limit);
            assert!(checked_depth::<AabbNode>(&triangles, |node| (node.center, IDENTITY)) <= limit);
        }
    }
}
