//! Armour: tub, superstructure, ramp, skirts, mudguards.

use super::TRACK;
use crate::mesh::builtin::{
    assembly::Assembly,
    budget::Detail,
    loft::{block, prism, tapered_block},
    placement::Placement,
    revolution::cylinder,
    sheet::Sheet,
};

/// Half widths of the tub between the tracks and of the superstructure over them (m).
const TUB: f64 = 0.83;
pub(super) const SIDE: f64 = 1.27;
/// Roof (m above the ground), and the ends of the glacis (x, z).
pub(super) const ROOF: f64 = 1.83;
pub(super) const GLACIS_TOP: [f64; 2] = [1.32, ROOF];
pub(super) const GLACIS_FOOT: [f64; 2] = [2.38, 1.09];
/// Rear plate: x at its foot and at the roof (m).
pub(super) const REAR: [f64; 2] = [-2.36, -2.30];
const SKIRTS: usize = 5;

pub(super) fn hull(detail: Detail) -> Assembly {
    let mut hull = Assembly::default();
    hull.put(side_view(&tub(), TUB).finer(0.7, 0.7), Placement::UPRIGHT);
    hull.put(side_view(&superstructure(), SIDE).finer(0.7, 0.7), Placement::UPRIGHT);
    hull.put(block([0.06, 1.42, 1.10], 0.0).finer(0.7, 0.7), Placement::at(-2.37, 0.0, 1.18));
    if detail == Detail::Outline {
        return hull;
    }
    hull.put(block([0.03, 0.62, 0.88], 0.01), Placement::at(-2.405, 0.22, 1.16));
    for side in [-0.55, 0.0, 0.55] {
        let hinge = Placement::AXLE.moved(-2.41, side, 0.64);
        hull.put(cylinder(0.035, -0.11, 0.11), hinge);
    }
    let mut left = Assembly::default();
    for k in 0..SKIRTS {
        let x = -1.76 + 0.88 * k as f64;
        left.put(
            block([0.87, 0.014, 0.30], 0.003).finer(0.7, 0.7),
            Placement::at(x, SIDE + 0.012, 0.88),
        );
    }
    left.put(
        tapered_block([0.46, 0.42, 0.03], [0.44, 0.40], 0.006),
        Placement::at(2.30, TRACK - 0.02, 1.00),
    );
    left.put(block([0.022, 0.42, 0.22], 0.005), Placement::at(2.53, TRACK - 0.02, 0.90));
    left.put(block([0.022, 0.42, 0.26], 0.005), Placement::at(-2.44, TRACK - 0.02, 0.88));
    left.put(
        tapered_block([0.30, 0.44, 0.70], [0.26, 0.42], 0.03),
        Placement::at(-2.50, 0.98, 1.36),
    );
    hull.include_on_both_sides(&left);
    hull
}

/// An outline in x and z, extended to both sides.
fn side_view(outline: &[[f64; 2]], half_width: f64) -> Sheet {
    prism(outline, -half_width, half_width)
}

fn tub() -> [[f64; 2]; 6] {
    [
        [1.96, 0.44],
        [2.30, 0.72],
        [GLACIS_FOOT[0], 1.05],
        [-2.30, 1.05],
        [-2.30, 0.62],
        [-2.12, 0.44],
    ]
}

fn superstructure() -> [[f64; 2]; 6] {
    [[-2.28, 0.97], [2.30, 0.97], GLACIS_FOOT, GLACIS_TOP, [REAR[1], ROOF], [REAR[0], 1.20]]
}
