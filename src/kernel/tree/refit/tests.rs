use super::super::wide::Below;
use super::super::{BuildOptions, build};
use super::*;

/// A sheet of triangles that share vertices; moved by a wave the rougher the more it is.
fn sheet(side: u32, wave: f64) -> TriangleMesh {
    let vertex = |i: u32, j: u32| {
        let (x, y) = (f64::from(i), f64::from(j));
        let (a, b) = ((1.7 * x + 0.9 * y).sin(), (2.3 * y - 1.1 * x).cos());
        [x + wave * a, y + wave * b, 0.3 * (x * y).sin() + wave * a * b]
    };
    let vertices = (0..side * side).map(|at| vertex(at / side, at % side)).collect();
    let square = |at: u32| {
        let at = at / (side - 1) * side + at % (side - 1);
        [[at, at + 1, at + side], [at + 1, at + side + 1, at + side]]
    };
    let faces = (0..(side - 1) * (side - 1)).flat_map(square).collect();
    TriangleMesh::new(vertices, faces).unwrap()
}

/// In the coordinates of its nodes, by rank.
fn triangle_of(view: &TreeView<'_>, rank: u32) -> Triangle {
    let Header { origin, unit, .. } = view.header();
    view.corners(rank).map(|v| [0, 1, 2].map(|k| (v[k] - origin[k]) / unit))
}

/// The coordinates of a point along the rounded axes of a box, as the descent takes it to be.
fn in_box(center: [f32; 3], axes: &Axes, v: &Point) -> Point {
    let columns = axes.map(|row| nalgebra::Vector3::from(widen(row)));
    let inverse = nalgebra::Matrix3::from_columns(&columns).try_inverse().unwrap();
    let center = widen(center);
    (inverse * nalgebra::Vector3::from([0, 1, 2].map(|k| v[k] - center[k]))).into()
}

fn assert_within(half: &Point, s: &Point) {
    assert!((0..3).all(|k| s[k].abs() <= half[k] + 1e-14), "{s:?} is out of {half:?}");
}

/// Every box contains the triangles below it.
fn check_binary<N: Refit>(view: &TreeView<'_>, center: fn(&N) -> [f32; 3]) {
    let nodes = view.nodes::<N>();
    for (node, below) in nodes.iter().zip(ranges(nodes)) {
        for v in below.flat_map(|rank| triangle_of(view, rank)) {
            assert_within(&node.half(), &in_box(center(node), &node.own_axes(), &v));
        }
    }
}

/// Every box contains the triangles below it; those of a leaf are in its rows.
fn check_wide(view: &TreeView<'_>, node: u32, above: &mut Vec<[Point; 2]>) {
    let node = &view.wide_nodes()[node as usize];
    for lane in 0..node.lanes() {
        above.push([&node.center, &node.half].map(|rows| widen(rows.map(|row| row[lane]))));
        match node.child[lane].below() {
            Below::Node(child) => check_wide(view, child, above),
            Below::Leaf(leaf) => check_leaf(view, leaf as usize, above),
        }
        above.pop();
    }
}

fn check_leaf(view: &TreeView<'_>, leaf: usize, above: &[[Point; 2]]) {
    let (leaves, rows) = (view.leaf_boxes(), &view.leaf_rows()[leaf]);
    let end = leaves.get(leaf + 1).map_or(view.triangle_count(), |next| next.first);
    let leaf = &leaves[leaf];
    let size: f64 = widen(leaf.half).iter().sum();
    for (lane, rank) in (leaf.first..end).enumerate() {
        assert_eq!(rows.ids[lane], view.triangles()[rank as usize].id);
        for (corner, v) in triangle_of(view, rank).iter().enumerate() {
            for [center, half] in above {
                assert_within(half, &[0, 1, 2].map(|k| v[k] - center[k]));
            }
            assert_within(&widen(leaf.half), &in_box(leaf.center, &leaf.axes, v));
            for k in 0..3 {
                let row = match corner {
                    0 => rows.first_two[k][lane],
                    1 => rows.first_two[k][wide::WIDTH + lane],
                    _ => rows.third[k][lane],
                };
                let along: f64 = (0..3)
                    .map(|i| f64::from(leaf.axes[k][i]) * (v[i] - f64::from(leaf.center[i])))
                    .sum();
                // What the descent's error bounds start from.
                assert!((f64::from(row) - along).abs() <= size / f64::from(1 << 24) + 1e-15);
            }
        }
    }
}

#[test]
fn every_box_contains_what_has_moved_below_it() {
    for side in [2, 3, 5, 12, 30] {
        for kind in TreeKind::ALL {
            let image = build(&sheet(side, 0.0), BuildOptions { kind });
            for wave in [1e-6, 0.05, 0.4, 20.0] {
                let mut image = image.clone();
                refit(&mut image, &sheet(side, wave)).unwrap();
                let view = image.view();
                match kind {
                    TreeKind::Obb => check_binary::<ObbNode>(&view, |node| node.center),
                    TreeKind::Aabb => check_binary::<AabbNode>(&view, |node| node.center),
                    TreeKind::Wide => check_wide(&view, 0, &mut Vec::new()),
                }
                let halves = match kind {
                    TreeKind::Wide => {
                        view.leaf_boxes().iter().map(|leaf| widen(leaf.half)).collect()
                    }
                    TreeKind::Obb => leaf_halves::<ObbNode>(&view),
                    TreeKind::Aabb => leaf_halves::<AabbNode>(&view),
                };
                let longest = longest_diagonal(halves.into_par_iter());
                assert_eq!(view.header().leaf_diameter, longest);
            }
        }
    }
}

fn leaf_halves<N: Node>(view: &TreeView<'_>) -> Vec<Point> {
    let is_leaf = |node: &&N| matches!(node.link().child(), Child::Leaf { .. });
    view.nodes::<N>().iter().filter(is_leaf).map(Node::half).collect()
}
