//! A stack of equal blocks, each in full contact with its neighbours: what parts that were drawn on
//! a grid do to each other.

use crate::geometry::Point;
use crate::mesh::TriangleMesh;

/// Edge of a block, in metres: a power of two, so that whole steps of it are exact.
const STEP: f64 = 0.25;

pub(super) const TRIANGLES_OF_A_BLOCK: u32 = 12;

/// As many blocks along each axis as the budget allows, centred on the origin. Every block has
/// corners of its own.
pub(super) fn blocks(budget: u32) -> TriangleMesh {
    let count = (1..).find(|n: &u32| (n + 1).pow(3) > budget / TRIANGLES_OF_A_BLOCK);
    let count = count.expect("cubes grow without end");
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for cell in (0..count.pow(3)).map(|i| [i % count, i / count % count, i / count / count]) {
        let low = cell.map(|i| (f64::from(i) - 0.5 * f64::from(count)) * STEP);
        add_block(low, &mut vertices, &mut faces);
    }
    TriangleMesh::new(vertices, faces).expect("blocks are a valid mesh")
}

fn add_block(low: Point, vertices: &mut Vec<Point>, faces: &mut Vec<[u32; 3]>) {
    let first = vertices.len() as u32;
    // Corner i is the high one along axis k if bit k of i is set.
    vertices.extend(
        (0..8_u32)
            .map(|i| [0, 1, 2].map(|k: usize| low[k] + if i >> k & 1 == 1 { STEP } else { 0.0 })),
    );
    for axis in 0..3 {
        let (along, up) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let [low, high] = [0, 1 << axis].map(|base| {
            [base, base + along, base + along + up, base + up].map(|corner| first + corner)
        });
        let [[a, b, c, d], [e, f, g, h]] = [low, high];
        faces.extend([[a, d, c], [a, c, b], [e, f, g], [e, g, h]]);
    }
}
