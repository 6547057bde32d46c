use super::{
    sheet::{Ends, Sheet},
    turn::turn,
};
use crate::geometry::Point;

/// The skin over cross-sections that all have the same number of corners, straight between them.
/// Sections run along an axis and their corners counter-clockwise about it; a section may shrink
/// to a point where `ends` has a pole.
pub(super) fn loft(sections: Vec<Vec<Point>>, ends: Ends) -> Sheet {
    let corners = sections[0].len();
    let rows = sections.len() - usize::from(!ends.wrap[0]);
    let columns = corners - usize::from(!ends.wrap[1]);
    Sheet::new([rows, columns], ends, move |u, v| {
        let (row, column) = ((u as usize).min(rows - 1), (v as usize).min(columns - 1));
        let (s, t) = (u - row as f64, v - column as f64);
        let lower = &sections[row];
        let upper = &sections[(row + 1) % sections.len()];
        let next = (column + 1) % corners;
        std::array::from_fn(|k| {
            let low = lower[column][k] + (lower[next][k] - lower[column][k]) * t;
            let high = upper[column][k] + (upper[next][k] - upper[column][k]) * t;
            low + (high - low) * s
        })
    })
}

/// A closed body over its cross-sections, each end closed towards its middle.
pub(super) fn solid(mut sections: Vec<Vec<Point>>) -> Sheet {
    let first = middle(&sections[0]);
    let last = middle(&sections[sections.len() - 1]);
    sections.insert(0, first);
    sections.push(last);
    loft(sections, Ends::SOLID)
}

fn middle(section: &[Point]) -> Vec<Point> {
    let count = section.len() as f64;
    let centre = [0, 1, 2].map(|k| section.iter().map(|p| p[k]).sum::<f64>() / count);
    vec![centre; section.len()]
}

/// A plate of constant thickness: a counter-clockwise outline that is star-shaped about the mean
/// of its corners, from one height to another.
pub(super) fn prism(outline: &[[f64; 2]], from: f64, to: f64) -> Sheet {
    solid(vec![at_height(outline, from), at_height(outline, to)])
}

/// A plate with a similar hole around the origin, `hole` times as large.
pub(super) fn pierced_prism(outline: &[[f64; 2]], hole: &[[f64; 2]], from: f64, to: f64) -> Sheet {
    let rings = [(hole, from), (outline, from), (outline, to), (hole, to)];
    loft(rings.map(|(ring, height)| at_height(ring, height)).to_vec(), Ends::RING)
}

fn at_height(outline: &[[f64; 2]], height: f64) -> Vec<Point> {
    outline.iter().map(|p| [p[0], p[1], height]).collect()
}

/// A box around the origin with its edges broken by `chamfer`; sharp where that is 0.
pub(super) fn block(size: Point, chamfer: f64) -> Sheet {
    tapered_block(size, [size[0], size[1]], chamfer)
}

/// A block whose top is another rectangle than its bottom.
pub(super) fn tapered_block(size: Point, top: [f64; 2], chamfer: f64) -> Sheet {
    let half = size[2] / 2.0;
    let bottom = [size[0], size[1]];
    if chamfer == 0.0 {
        let ring = |size: [f64; 2], z: f64| at_height(&rectangle(size), z);
        return solid(vec![ring(bottom, -half), ring(top, half)]);
    }
    let cut = 0.4 * chamfer;
    let narrowest = bottom.into_iter().chain(top).fold(f64::INFINITY, f64::min);
    assert!(narrowest > 2.0 * (chamfer + cut), "the chamfer leaves nothing of a side");
    let ring = |size: [f64; 2], inset: f64, z: f64| {
        at_height(&broken_rectangle(size.map(|side| side - 2.0 * inset), cut), z)
    };
    solid(vec![
        ring(bottom, chamfer, -half),
        ring(bottom, 0.0, chamfer - half),
        ring(top, 0.0, half - chamfer),
        ring(top, chamfer, half),
    ])
}

/// Counter-clockwise, around the origin.
pub(super) fn rectangle([x, y]: [f64; 2]) -> [[f64; 2]; 4] {
    let (x, y) = (x / 2.0, y / 2.0);
    [[x, -y], [x, y], [-x, y], [-x, -y]]
}

/// A rectangle with its corners cut off.
pub(super) fn broken_rectangle([x, y]: [f64; 2], cut: f64) -> [[f64; 2]; 8] {
    let (x, y) = (x / 2.0, y / 2.0);
    let (a, b) = (x - cut, y - cut);
    [[x, -b], [x, b], [a, y], [-a, y], [-x, b], [-x, -b], [-a, -y], [a, -y]]
}

/// `teeth` trapezoids between the radii of root and tip, and the root circle with as many corners.
pub(super) fn gear(teeth: usize, root: f64, tip: f64, hole: f64) -> [Vec<[f64; 2]>; 2] {
    /// Where along a tooth's share of the turn its corners are: root, root, tip, tip.
    const CORNERS: [f64; 4] = [0.0, 0.4, 0.55, 0.85];
    let ring = |radii: [f64; 4]| {
        (0..4 * teeth)
            .map(|corner| {
                let share = (corner / 4) as f64 + CORNERS[corner % 4];
                turn(share / teeth as f64).map(|c| c * radii[corner % 4])
            })
            .collect()
    };
    [ring([root, root, tip, tip]), ring([hole; 4])]
}
