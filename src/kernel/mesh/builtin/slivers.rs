//! A box whose faces are cut into strips that get thinner and thinner towards an edge: the long thin
//! triangles that exporters make of curved trimmed faces.

use crate::geometry::Point;
use crate::mesh::TriangleMesh;

/// In metres.
const SIZE: Point = [2.0, 1.0, 1.5];

/// How often the width of the strips halves: from some tenth of a metre to less than a nanometre.
const OCTAVES: u32 = 30;

const FACES: u32 = 6;

pub(super) const FEWEST_TRIANGLES: u32 = 2 * FACES * (OCTAVES + 1);

/// With as many strips an octave as the budget allows. Half of all triangles are a hundred thousand
/// times as long as they are wide, the thinnest a thousand million times.
pub(super) fn slivers(budget: u32) -> TriangleMesh {
    let strips_of_an_octave = (budget / (2 * FACES) - 1) / OCTAVES;
    let fractions = fractions(strips_of_an_octave);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for is_high in [false, true] {
            add_face(axis, is_high, &fractions, &mut vertices, &mut faces);
        }
    }
    TriangleMesh::new(vertices, faces).expect("strips are a valid mesh")
}

/// Where the strips end, from 0 to 1.
fn fractions(strips_of_an_octave: u32) -> Vec<f64> {
    let mut ends = vec![0.0];
    let mut begin = 1.0 / f64::from(1 << OCTAVES);
    ends.push(begin);
    for _ in 0..OCTAVES {
        let step = |i| begin + begin * (f64::from(i) / f64::from(strips_of_an_octave));
        ends.extend((1..=strips_of_an_octave).map(step));
        begin *= 2.0;
    }
    ends
}

/// Strips lie side by side along the next axis and stretch along the one after it.
fn add_face(
    axis: usize,
    is_high: bool,
    fractions: &[f64],
    vertices: &mut Vec<Point>,
    faces: &mut Vec<[u32; 3]>,
) {
    let (across, along) = ((axis + 1) % 3, (axis + 2) % 3);
    let first = vertices.len() as u32;
    for &fraction in fractions {
        for end in [-0.5, 0.5] {
            let mut corner = [0.0; 3];
            corner[axis] = if is_high { 0.5 } else { -0.5 } * SIZE[axis];
            corner[across] = (fraction - 0.5) * SIZE[across];
            corner[along] = end * SIZE[along];
            vertices.push(corner);
        }
    }
    for strip in 0..fractions.len() as u32 - 1 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first + 2 * strip + corner);
        let mut pair = [[a, c, d], [a, d, b]];
        if !is_high {
            pair.iter_mut().for_each(|face| face.swap(1, 2));
        }
        faces.extend(pair);
    }
}
