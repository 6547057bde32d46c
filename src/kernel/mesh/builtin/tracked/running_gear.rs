//! The left side's road wheels, sprocket, idler, return rollers and suspension.

use std::rc::Rc;

use super::{TRACK, belt::Circle};
use crate::{
    geometry::Point,
    mesh::builtin::{
        assembly::Assembly,
        budget::Detail,
        loft::{block, gear, pierced_prism, prism},
        placement::Placement,
        revolution::{annulus, cylinder, turned_ring, turned_solid},
        sheet::Sheet,
        turn::turn,
    },
};

/// The line of the track's pins over the ground, and the wheels' way inside it (m).
const PIN_LINE: f64 = 0.055;
const PIN_TO_WHEEL: f64 = 0.024;
const WHEEL_RADIUS: f64 = 0.305;
const WHEEL_HEIGHT: f64 = PIN_LINE + PIN_TO_WHEEL + WHEEL_RADIUS;
const ROAD_WHEELS: [f64; 5] = [1.33, 0.665, 0.0, -0.665, -1.33];
/// Middle (x, z) and pitch radius (m).
const SPROCKET: Circle = Circle { centre: [2.00, 0.66], radius: 0.246 };
const IDLER: Circle = Circle { centre: [-2.00, 0.53], radius: 0.25 };
const SPROCKET_TEETH: usize = 10;
const RETURN_ROLLERS: [f64; 3] = [1.0, 0.0, -1.0];
const ROLLER_RADIUS: f64 = 0.085;
/// Middle of each disc of a double wheel, from the middle of the track (m).
const DISC_OFFSET: f64 = 0.095;

/// What the track runs around, as the line of its pins.
pub(super) fn belt_circles() -> [Circle; 4] {
    let wheel = |x| Circle { centre: [x, WHEEL_HEIGHT], radius: WHEEL_RADIUS + PIN_TO_WHEEL };
    [wheel(ROAD_WHEELS[4]), wheel(ROAD_WHEELS[0]), SPROCKET, IDLER]
}

pub(super) fn running_gear(detail: Detail) -> Assembly {
    let mut gear = Assembly::default();
    let at = |x: f64, z: f64| Placement::AXLE.moved(x, TRACK, z);
    let wheel = double_wheel(detail, WHEEL_RADIUS);
    for x in ROAD_WHEELS {
        gear.include(&wheel, at(x, WHEEL_HEIGHT));
    }
    let idler = double_wheel(detail, IDLER.radius - PIN_TO_WHEEL);
    gear.include(&idler, at(IDLER.centre[0], IDLER.centre[1]));
    gear.include(&sprocket(detail), at(SPROCKET.centre[0], SPROCKET.centre[1]));
    if detail >= Detail::Parts {
        let run = |x: f64| {
            let t = (x - IDLER.centre[0]) / (SPROCKET.centre[0] - IDLER.centre[0]);
            let top = |c: Circle| c.centre[1] + c.radius;
            top(IDLER) + (top(SPROCKET) - top(IDLER)) * t
        };
        for x in RETURN_ROLLERS {
            let z = run(x) - PIN_TO_WHEEL - ROLLER_RADIUS;
            gear.include(&return_roller(), at(x, z));
        }
        for (i, x) in ROAD_WHEELS.into_iter().enumerate() {
            suspension(&mut gear, x, i == 0 || i == ROAD_WHEELS.len() - 1);
        }
    }
    gear
}

/// Axle along z, the outer side towards +z.
fn double_wheel(detail: Detail, radius: f64) -> Assembly {
    let mut wheel = Assembly::default();
    let mut put = |sheet, placement| wheel.put(sheet, placement);
    if detail == Detail::Outline {
        put(cylinder(radius, -DISC_OFFSET - 0.055, DISC_OFFSET + 0.055), Placement::HERE);
        return wheel;
    }
    if detail == Detail::Parts {
        for side in [-DISC_OFFSET, DISC_OFFSET] {
            let (rim, hub, w) = (radius - 0.045, 0.03 + radius / 4.0, 0.054);
            let disc = [[-w, 0.0], [-w, radius], [w, radius], [w, rim], [0.01, hub], [0.01, 0.0]];
            put(turned_solid(&disc), Placement::at(0.0, 0.0, side));
        }
        put(cylinder(0.06, -0.17, 0.17), Placement::HERE);
        return wheel;
    }
    let rubber = radius - 0.045;
    for side in [-1.0, 1.0] {
        let at = Placement::at(0.0, 0.0, side * DISC_OFFSET);
        let w = 0.054;
        let tyre = turned_ring(&[
            [-w, rubber],
            [-w, radius - 0.008],
            [-w + 0.008, radius],
            [w - 0.008, radius],
            [w, radius - 0.008],
            [w, rubber],
        ]);
        put(tyre.finer(0.7, 1.2), at);
        let dish = [-0.05, 0.05].map(|rim| rim * side);
        put(wheel_disc(rubber, dish), at);
    }
    put(
        turned_solid(&[
            [-0.17, 0.0],
            [-0.17, 0.075],
            [0.11, 0.075],
            [0.13, 0.065],
            [0.165, 0.055],
            [0.175, 0.035],
            [0.175, 0.0],
        ]),
        Placement::HERE,
    );
    ring_of_bolts(&mut wheel, 10, 0.105, DISC_OFFSET + 0.005);
    ring_of_bolts(&mut wheel, 6, 0.045, 0.155);
    wheel
}

/// A dished steel disc within the tyre, its rim from `inner` to `outer` along the axle.
fn wheel_disc(radius: f64, [inner, outer]: [f64; 2]) -> Sheet {
    let (low, high) = (inner.min(outer), inner.max(outer));
    let web = 0.012;
    let dish = 0.6 * inner;
    turned_ring(&[
        [dish - web, 0.06],
        [dish - web, 0.15],
        [-web, radius - 0.045],
        [low, radius - 0.012],
        [low, radius],
        [high, radius],
        [high, radius - 0.012],
        [web, radius - 0.045],
        [dish + web, 0.15],
        [dish + web, 0.06],
    ])
}

fn sprocket(detail: Detail) -> Assembly {
    let mut sprocket = Assembly::default();
    let mut put = |sheet, placement| sprocket.put(sheet, placement);
    let pitch = SPROCKET.radius;
    let [outline, hole] = gear(SPROCKET_TEETH, pitch - 0.03, pitch + 0.025, 0.12);
    if detail == Detail::Outline {
        put(cylinder(pitch, -0.13, 0.13), Placement::HERE);
        return sprocket;
    }
    if detail == Detail::Parts {
        for side in [-0.115, 0.115] {
            put(prism(&outline, side - 0.022, side + 0.022), Placement::HERE);
        }
        put(cylinder(0.12, -0.20, 0.20), Placement::HERE);
        return sprocket;
    }
    for side in [-0.115, 0.115] {
        put(pierced_prism(&outline, &hole, side - 0.022, side + 0.022), Placement::HERE);
        put(annulus(0.11, 0.175, side - 0.034, side + 0.034), Placement::HERE);
    }
    put(
        turned_solid(&[
            [-0.20, 0.0],
            [-0.20, 0.13],
            [0.06, 0.13],
            [0.15, 0.115],
            [0.165, 0.08],
            [0.20, 0.06],
            [0.21, 0.0],
        ]),
        Placement::HERE,
    );
    ring_of_bolts(&mut sprocket, SPROCKET_TEETH, 0.155, 0.145);
    sprocket
}

fn return_roller() -> Assembly {
    let mut roller = Assembly::default();
    for side in [-DISC_OFFSET, DISC_OFFSET] {
        let (r, w) = (ROLLER_RADIUS, 0.035);
        roller.put(
            turned_solid(&[
                [-w, 0.0],
                [-w, r - 0.01],
                [0.01 - w, r],
                [w - 0.01, r],
                [w, r - 0.01],
                [w, 0.0],
            ]),
            Placement::at(0.0, 0.0, side),
        );
    }
    roller.put(cylinder(0.03, -0.26, 0.15), Placement::HERE);
    roller
}

/// Trailing arm, its pivot in the hull, bump stop; a shock absorber on the outer wheels.
fn suspension(gear: &mut Assembly, x: f64, damped: bool) {
    let hull = TRACK - 0.24;
    let pivot = [x + 0.28, hull + 0.03, WHEEL_HEIGHT + 0.14];
    let (along, length) = Placement::between(pivot, [x, hull + 0.03, WHEEL_HEIGHT]);
    let arm = block([0.07, 0.05, length + 0.08], 0.012);
    gear.put(arm, Placement::at(0.0, 0.0, length / 2.0).within(&along));
    let axle = |at: Point| Placement::AXLE.moved(at[0], at[1], at[2]);
    gear.put(cylinder(0.062, -0.10, 0.04), axle(pivot));
    gear.put(cylinder(0.045, -0.05, 0.10), axle([x, hull + 0.03, WHEEL_HEIGHT]));
    gear.put(block([0.10, 0.10, 0.06], 0.015), Placement::at(x + 0.05, hull, WHEEL_HEIGHT + 0.33));
    if damped {
        let foot = [x + 0.05, hull + 0.08, WHEEL_HEIGHT + 0.05];
        let (along, length) = Placement::between(foot, [x - 0.22, hull + 0.08, 0.86]);
        gear.put(cylinder(0.032, 0.0, length * 0.6), along);
        gear.put(cylinder(0.022, length * 0.5, length), along);
    }
}

/// Bolt heads in a circle around the axle, on a face at a height along it.
fn ring_of_bolts(assembly: &mut Assembly, count: usize, radius: f64, face: f64) {
    const HEAD: f64 = 0.0125;
    const HEIGHT: f64 = 0.03;
    let hexagon: [[f64; 2]; 6] = std::array::from_fn(|k| turn(k as f64 / 6.0).map(|c| c * HEAD));
    let bolt = Rc::new(prism(&hexagon, 0.0, HEIGHT));
    for k in 0..count {
        let angle = Placement::turned(2, k as f64 / count as f64);
        assembly.put(Rc::clone(&bolt), Placement::at(radius, 0.0, face).within(&angle));
    }
}
