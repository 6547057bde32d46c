//! What is bolted to the hull: hatches, grilles, lamps, hooks, tools, aerials.

use std::rc::Rc;

use super::hull::{GLACIS_FOOT, GLACIS_TOP, REAR, ROOF, SIDE};
use crate::{
    geometry::Point,
    mesh::builtin::{
        assembly::Assembly,
        budget::Detail,
        loft::{block, prism, tapered_block},
        placement::Placement,
        revolution::{cylinder, torus, turned_solid},
        turn::turn,
    },
};

pub(super) fn fittings(detail: Detail) -> Assembly {
    let mut fittings = Assembly::default();
    roof(&mut fittings, detail);
    if detail == Detail::Outline {
        return fittings;
    }
    glacis(&mut fittings, detail);
    let mut left = Assembly::default();
    lamps(&mut left, detail);
    if detail == Detail::Full {
        hooks(&mut left);
        bolts(&mut left);
        smoke_launchers(&mut left);
        aerial(&mut fittings);
        tools(&mut fittings);
    }
    fittings.include_on_both_sides(&left);
    fittings
}

fn rod(assembly: &mut Assembly, from: Point, to: Point, radius: f64) {
    let (along, length) = Placement::between(from, to);
    assembly.put(cylinder(radius, 0.0, length), along);
}

/// Driver's hatch on the left, engine grilles on the right, cargo hatch at the rear.
fn roof(fittings: &mut Assembly, detail: Detail) {
    let mut put = |sheet, x, y, z| fittings.put(sheet, Placement::at(x, y, ROOF + z));
    put(tapered_block([1.30, 1.30, 0.06], [1.26, 1.26], 0.02).finer(0.7, 0.7), -1.35, 0.0, 0.025);
    if detail == Detail::Outline {
        return;
    }
    put(
        turned_solid(&[[-0.01, 0.0], [-0.01, 0.30], [0.04, 0.29], [0.07, 0.20], [0.075, 0.0]]),
        0.86,
        0.55,
        0.0,
    );
    put(block([0.80, 0.74, 0.04], 0.01), 0.78, -0.55, 0.01);
    put(block([0.44, 0.60, 0.05], 0.012), 0.20, -0.80, 0.015);
    if detail < Detail::Full {
        return;
    }
    for k in 0..16 {
        let slat = block([0.016, 0.66, 0.05], 0.003);
        fittings.put(
            slat,
            Placement::turned(1, 0.08).moved(0.45 + 0.044 * f64::from(k), -0.55, ROOF + 0.045),
        );
    }
    for k in 0..4 {
        let angle = Placement::turned(2, (f64::from(k) - 1.5) / 9.0);
        let at = Placement::at(0.36, 0.0, 0.03).within(&angle).moved(0.86, 0.55, ROOF);
        fittings.put(tapered_block([0.11, 0.17, 0.11], [0.07, 0.15], 0.012), at);
    }
    for side in [-0.4, 0.4] {
        fittings.put(cylinder(0.03, -0.10, 0.10), Placement::AXLE.moved(-0.69, side, ROOF + 0.05));
        fittings.put(block([0.16, 0.06, 0.03], 0.006), Placement::at(-0.74, side, ROOF + 0.065));
    }
    fittings.put(cylinder(0.10, 0.0, 0.12), Placement::at(-1.75, 0.42, ROOF + 0.03));
    let muffler =
        [[0.0, 0.0], [0.0, 0.075], [0.30, 0.075], [0.30, 0.055], [0.42, 0.05], [0.42, 0.0]];
    fittings.put(turned_solid(&muffler), Placement::FORWARD.moved(0.02, -1.06, ROOF + 0.06));
    for [x, y] in [[1.12, 1.08], [1.12, -1.08], [-2.1, 1.08], [-2.1, -1.08]] {
        fittings.put(torus(0.05, 0.012), Placement::UPRIGHT.moved(x, y, ROOF + 0.04));
    }
}

/// The trim vane folded against the glacis, with its hinges and stiffeners.
fn glacis(fittings: &mut Assembly, detail: Detail) {
    let way = [0, 1].map(|k| GLACIS_TOP[k] - GLACIS_FOOT[k]);
    let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
    let [x, z] = way.map(|c| c / length);
    // On the slope z runs up, y across and x out of the plate.
    let slope = Placement::facing([z, 0.0, -x], [x, 0.0, z], [GLACIS_FOOT[0], 0.0, GLACIS_FOOT[1]]);
    let mut put = |sheet, across: f64, along: f64, above: f64| {
        fittings.put(sheet, Placement::at(above, across, along * length).within(&slope));
    };
    put(block([0.04, 2.20, 0.74], 0.010).finer(0.7, 0.7), 0.0, 0.42, 0.05);
    if detail < Detail::Full {
        return;
    }
    for k in -3..=3 {
        put(block([0.03, 0.05, 0.68], 0.008), f64::from(k) * 0.34, 0.42, 0.08);
    }
    for across in [-0.8, -0.3, 0.3, 0.8] {
        put(block([0.08, 0.07, 0.10], 0.012), across, 0.10, 0.04);
    }
    put(block([0.05, 0.70, 0.16], 0.012), -0.55, 0.87, 0.02);
    put(block([0.06, 0.30, 0.10], 0.012), 0.60, 0.88, 0.02);
}

fn lamps(left: &mut Assembly, detail: Detail) {
    let lamp = Rc::new(turned_solid(&[
        [-0.10, 0.0],
        [-0.10, 0.03],
        [-0.06, 0.065],
        [0.0, 0.075],
        [0.012, 0.07],
        [0.02, 0.0],
    ]));
    for y in [0.80, 0.98] {
        left.put(Rc::clone(&lamp), Placement::FORWARD.moved(2.33, y, 1.31));
    }
    left.put(block([0.10, 0.42, 0.03], 0.006), Placement::at(2.24, 0.89, 1.22));
    left.put(block([0.05, 0.16, 0.09], 0.012), Placement::at(REAR[0] - 0.05, 1.18, 1.10));
    if detail < Detail::Full {
        return;
    }
    for y in [0.69, 0.89, 1.09] {
        rod(left, [2.22, y, 1.22], [2.42, y, 1.40], 0.011);
        rod(left, [2.42, y, 1.40], [2.10, y, 1.42], 0.011);
    }
    rod(left, [2.42, 0.68, 1.40], [2.42, 1.10, 1.40], 0.011);
}

fn hooks(left: &mut Assembly) {
    for [x, z] in [[2.36, 0.80], [-2.36, 0.66]] {
        left.put(block([0.12, 0.05, 0.14], 0.012), Placement::at(x, 0.62, z));
        left.put(
            torus(0.06, 0.016),
            Placement::at(x + if x > 0.0 { 0.09 } else { -0.09 }, 0.62, z),
        );
    }
    for z in [0.75, 0.90] {
        rod(left, [REAR[0] - 0.02, 0.80, z], [REAR[0] - 0.12, 0.80, z], 0.012);
        rod(left, [REAR[0] - 0.12, 0.80, z], [REAR[0] - 0.12, 1.10, z], 0.012);
    }
    left.put(block([0.30, 0.12, 0.18], 0.02), Placement::at(-1.60, SIDE + 0.06, 1.55));
    left.put(
        tapered_block([0.90, 0.16, 0.26], [0.88, 0.14], 0.02),
        Placement::at(-0.30, SIDE + 0.07, 1.56),
    );
    for x in [-0.55, -0.05] {
        left.put(block([0.05, 0.02, 0.10], 0.004), Placement::at(x, SIDE + 0.15, 1.60));
    }
}

/// Rows of bolt heads along the side and the skirts.
fn bolts(left: &mut Assembly) {
    let hexagon: [[f64; 2]; 6] = std::array::from_fn(|k| turn(k as f64 / 6.0).map(|c| c * 0.016));
    let bolt = Rc::new(prism(&hexagon, 0.0, 0.016));
    let mut row = |count: usize, first: f64, step: f64, y: f64, z: f64| {
        for k in 0..count {
            let x = first + step * k as f64;
            left.put(Rc::clone(&bolt), Placement::AXLE.moved(x, y, z));
        }
    };
    row(30, -2.14, 0.147, SIDE + 0.018, 1.00);
    row(24, -2.20, 0.150, SIDE - 0.002, 1.76);
    row(28, -2.20, 0.150, SIDE - 0.002, 1.10);
}

fn smoke_launchers(left: &mut Assembly) {
    for k in 0..4 {
        let from = [1.36, 0.72 + 0.10 * f64::from(k), ROOF - 0.01];
        let to = [1.52, 0.74 + 0.12 * f64::from(k), ROOF + 0.17];
        rod(left, from, to, 0.038);
    }
    left.put(block([0.12, 0.44, 0.04], 0.008), Placement::at(1.33, 0.88, ROOF + 0.01));
}

fn aerial(fittings: &mut Assembly) {
    for (x, y) in [(-0.55, 1.05), (-2.10, -0.90)] {
        let base =
            [[0.0, 0.0], [0.0, 0.06], [0.05, 0.05], [0.06, 0.025], [0.20, 0.02], [0.20, 0.0]];
        fittings.put(turned_solid(&base), Placement::at(x, y, ROOF));
        rod(fittings, [x, y, ROOF + 0.18], [x - 0.06, y, ROOF + 0.66], 0.006);
    }
}

/// Shovel, pick and crowbar on the left of the roof, a tow cable on the right.
fn tools(fittings: &mut Assembly) {
    let z = ROOF + 0.03;
    rod(fittings, [0.45, 1.05, z], [-0.45, 1.05, z], 0.018);
    fittings
        .put(tapered_block([0.28, 0.21, 0.02], [0.26, 0.19], 0.004), Placement::at(0.58, 1.05, z));
    rod(fittings, [0.35, 0.94, z], [-0.45, 0.94, z], 0.018);
    fittings.put(block([0.05, 0.40, 0.05], 0.010), Placement::at(0.36, 0.98, z));
    rod(fittings, [-0.75, 1.12, z], [-2.0, 1.12, z], 0.015);
    rod(fittings, [-0.3, -1.18, z], [-2.0, -1.18, z], 0.013);
    rod(fittings, [-0.3, -1.12, z], [-2.0, -1.12, z], 0.013);
    for x in [-0.3, -2.0] {
        fittings.put(torus(0.055, 0.016), Placement::at(x, -1.15, z));
    }
    for x in [-0.3, 0.2] {
        fittings.put(block([0.05, 0.26, 0.035], 0.006), Placement::at(x, 1.0, ROOF + 0.015));
    }
}
