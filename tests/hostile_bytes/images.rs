//! Images that are whole, and lie: each was a crash or a wrong answer of a descent.

use bumper::mesh::TriangleMesh;
use bumper::tree::{Block, BuildOptions, Header, TreeKind, TreeView, build};

use super::targets::set_hash;

/// Three triangles in one leaf of a wide tree.
fn image() -> Vec<Block> {
    let vertices = (0..5).map(|i| [f64::from(i), f64::from(i % 2), f64::from(i * i)]);
    let mesh = TriangleMesh::new(vertices.collect(), vec![[0, 1, 2], [1, 2, 3], [2, 3, 4]]);
    build(&mesh.expect("a valid mesh"), BuildOptions { kind: TreeKind::Wide }).blocks().to_vec()
}

fn refusal(change: impl FnOnce(&mut [u8], &Header)) -> String {
    let mut blocks = image();
    let header = *TreeView::new(&blocks).expect("as it was built").header();
    change(bytemuck::cast_slice_mut(&mut blocks), &header);
    set_hash(&mut blocks);
    TreeView::new(&blocks).expect_err("it lies").to_string()
}

fn put(bytes: &mut [u8], at: u64, number: &[u8]) {
    bytes[at as usize..][..number.len()].copy_from_slice(number);
}

/// Rows of a leaf: two corners on three axes of eight lanes each, the third, numbers of triangles.
const SECOND: u64 = 32;
const THIRD: u64 = 192;
const IDS: u64 = 288;

#[test]
fn rows_of_triangles_that_the_leaf_does_not_have_are_refused() {
    let words = "rows are not of its triangles";
    let with = |offset: u64, number: &[u8]| {
        refusal(|bytes, header| put(bytes, header.leaf_rows_at + offset, number))
    };
    for lane in 0..3 {
        assert!(with(IDS + 4 * lane, &77_u32.to_le_bytes()).contains(words));
    }
    for lane in 3..8 {
        assert!(with(IDS + 4 * lane, &0_u32.to_le_bytes()).contains(words));
        for corner in [0, SECOND, THIRD] {
            assert!(with(corner + 4 * lane, &0.5_f32.to_le_bytes()).contains(words));
        }
    }
}

/// Of a node: centres and half extents on three axes of eight lanes each, then children.
#[test]
fn a_box_that_leads_nowhere_is_refused() {
    for row in 0..6 {
        let refused = refusal(|bytes, header| {
            put(bytes, header.nodes_at + 32 * row + 28, &0.5_f32.to_le_bytes());
        });
        assert!(refused.contains("box without a child"), "{refused}");
    }
}

#[test]
fn bounds_that_do_not_hold_the_vertices_are_refused() {
    let low = std::mem::offset_of!(Header, low) as u64;
    let high = std::mem::offset_of!(Header, high) as u64;
    for (at, bound) in [(low, 0.5), (high + 16, 15.5), (low, f64::NAN), (high, f64::INFINITY)] {
        let refused = refusal(|bytes, _| put(bytes, at, &f64::to_le_bytes(bound)));
        assert!(refused.contains("not within finite bounds"), "{refused}");
    }
}

#[test]
fn a_unit_that_is_no_power_of_two_is_refused() {
    let at = std::mem::offset_of!(Header, unit) as u64;
    for unit in [0.0, -1.0, 3.0, 5e-324, f64::INFINITY, f64::NAN] {
        let refused = refusal(|bytes, _| put(bytes, at, &f64::to_le_bytes(unit)));
        assert!(refused.contains("origin and unit"), "{refused}");
    }
}
