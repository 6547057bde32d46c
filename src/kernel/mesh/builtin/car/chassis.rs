//! Below and behind the panels: floor, engine bay, suspension, exhaust, tank.

use super::{AXLE_HEIGHT, FRONT_AXLE, REAR_AXLE, TRACK};
use crate::{
    geometry::Point,
    mesh::builtin::{
        assembly::Assembly,
        budget::Detail,
        loft::{block, gear, pierced_prism, tapered_block},
        placement::Placement,
        revolution::{cylinder, torus, turned_solid},
    },
};

/// Coils and thickness of a suspension spring, shown as stacked rings.
const SPRING_RINGS: usize = 6;
const FLOOR: f64 = 0.20;

pub(super) fn chassis(detail: Detail) -> Assembly {
    let mut chassis = Assembly::default();
    let mut put =
        |size, x, z| chassis.put(block(size, 0.0).finer(0.5, 0.5), Placement::at(x, 0.0, z));
    put([2.00, 1.50, 0.03], -0.02, FLOOR);
    put([0.75, 0.94, 0.03], -1.35, FLOOR + 0.12);
    if detail == Detail::Outline {
        return chassis;
    }
    put([0.03, 1.30, 0.55], 1.00, 0.52);
    put([0.03, 1.10, 0.50], -1.17, 0.55);
    put([0.06, 0.90, 0.42], 1.93, 0.42);
    let mut left = Assembly::default();
    suspension(&mut left, detail);
    chassis.include_on_both_sides(&left);
    engine(&mut chassis, detail);
    exhaust(&mut chassis);
    chassis.put(
        tapered_block([0.40, 0.90, 0.20], [0.36, 0.80], 0.04),
        Placement::at(-0.72, 0.0, 0.29),
    );
    chassis.put(block([0.10, 1.36, 0.10], 0.02), Placement::at(2.03, 0.0, 0.47));
    chassis.put(block([0.10, 1.30, 0.10], 0.02), Placement::at(-2.08, 0.0, 0.47));
    chassis
}

fn rod(assembly: &mut Assembly, from: Point, to: Point, radius: f64) {
    let (along, length) = Placement::between(from, to);
    assembly.put(cylinder(radius, 0.0, length), along);
}

fn suspension(left: &mut Assembly, detail: Detail) {
    let hub = TRACK / 2.0 - 0.06;
    for (axle, top) in [(FRONT_AXLE, 0.80), (REAR_AXLE, 0.76)] {
        let z = AXLE_HEIGHT;
        rod(left, [axle + 0.18, 0.30, z - 0.08], [axle, hub, z - 0.10], 0.020);
        rod(left, [axle - 0.18, 0.30, z - 0.08], [axle, hub, z - 0.10], 0.020);
        rod(left, [axle, 0.08, z], [axle, hub, z], 0.016);
        rod(left, [axle, hub - 0.06, z - 0.05], [axle - 0.03, hub - 0.13, top], 0.022);
        left.put(block([0.09, 0.06, 0.20], 0.015), Placement::at(axle, hub - 0.02, z));
        if detail == Detail::Full {
            let from = [axle - 0.01, hub - 0.09, z + 0.18];
            let (along, length) = Placement::between(from, [axle - 0.03, hub - 0.13, top]);
            for ring in 0..SPRING_RINGS {
                let height = length * ring as f64 / SPRING_RINGS as f64;
                left.put(torus(0.055, 0.007), Placement::at(0.0, 0.0, height).within(&along));
            }
        }
    }
    rod(left, [0.96, 0.0, 0.24], [FRONT_AXLE - 0.14, hub - 0.03, AXLE_HEIGHT], 0.012);
}

fn engine(chassis: &mut Assembly, detail: Detail) {
    let mut put = |sheet, x, y, z| chassis.put(sheet, Placement::at(x, y, z));
    put(tapered_block([0.40, 0.52, 0.34], [0.34, 0.50], 0.03), 1.52, -0.10, 0.42);
    put(tapered_block([0.26, 0.48, 0.10], [0.18, 0.44], 0.02), 1.52, -0.10, 0.63);
    put(block([0.26, 0.20, 0.20], 0.015), 1.60, 0.44, 0.56);
    put(tapered_block([0.36, 0.36, 0.30], [0.26, 0.26], 0.04), 1.48, 0.32, 0.36);
    if detail < Detail::Full {
        return;
    }
    for k in 0..4 {
        let y = -0.28 + 0.12 * f64::from(k);
        rod(chassis, [1.40, y, 0.60], [1.25, y, 0.50], 0.022);
        rod(chassis, [1.64, y, 0.58], [1.76, y, 0.42], 0.018);
        chassis.put(cylinder(0.018, 0.0, 0.05), Placement::at(1.52, y, 0.67));
    }
    let right = Placement::AXLE.moved(1.52, -0.40, 0.0);
    for (x, z, teeth) in [(0.0, 0.32, 28), (0.10, 0.48, 18), (-0.10, 0.48, 18), (0.0, 0.58, 22)] {
        let radius = 0.0035 * teeth as f64;
        let [outline, hole] = gear(teeth, radius - 0.004, radius, radius * 0.35);
        chassis.put(
            pierced_prism(&outline, &hole, -0.03, 0.0).finer(0.5, 0.5),
            right.moved(x, 0.0, z),
        );
    }
    for side in [-0.24, 0.24] {
        let fan = Placement::FORWARD.moved(1.86, side, 0.42);
        chassis.put(torus(0.17, 0.012), fan);
        for blade in 0..7 {
            let turn = Placement::turned(2, f64::from(blade) / 7.0);
            let pitched = Placement::turned(0, 0.08).moved(0.09, 0.0, 0.0);
            chassis.put(block([0.14, 0.06, 0.006], 0.0), pitched.within(&turn).within(&fan));
        }
    }
}

fn exhaust(chassis: &mut Assembly) {
    const PIPE: [Point; 5] = [
        [1.25, -0.10, 0.30],
        [0.95, 0.0, 0.17],
        [-0.95, 0.0, 0.17],
        [-1.25, -0.30, 0.27],
        [-2.20, -0.45, 0.24],
    ];
    for ends in PIPE.windows(2) {
        rod(chassis, ends[0], ends[1], 0.026);
    }
    let muffler = [[0.0, 0.0], [0.0, 0.07], [0.02, 0.09], [0.48, 0.09], [0.50, 0.07], [0.50, 0.0]];
    let along = Placement::FORWARD;
    chassis.put(turned_solid(&muffler), along.moved(-2.02, -0.43, 0.27));
    chassis
        .put(turned_solid(&muffler.map(|[z, r]| [z * 0.7, r * 0.7])), along.moved(0.10, 0.0, 0.17));
    chassis.put(cylinder(0.034, 0.0, 0.14), along.moved(-2.235, -0.45, 0.24));
}
