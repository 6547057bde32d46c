//! A road wheel of a car, its axle along z, the outer face towards +z.

use std::rc::Rc;

use crate::mesh::builtin::{
    assembly::Assembly,
    budget::Detail,
    loft::{block, gear, pierced_prism, prism, solid},
    placement::Placement,
    revolution::{annulus, cylinder, turned_ring, turned_skin, turned_solid},
    sheet::Sheet,
    turn::turn,
};

/// Rolling radius, half the width of the tread, and radius of the rim's edge (m): a 205/55 R16.
pub(super) const RADIUS: f64 = 0.316;
const HALF_WIDTH: f64 = 0.1025;
const RIM_RADIUS: f64 = 0.212;
/// Depth of the tread's grooves (m).
const TREAD: f64 = 0.008;
const TREAD_RIBS: [[f64; 2]; 4] =
    [[-0.082, -0.050], [-0.040, -0.005], [0.005, 0.040], [0.050, 0.082]];
const TREAD_BLOCKS: usize = 48;
const SPOKES: usize = 5;
const WHEEL_NUTS: usize = 5;

pub(super) fn wheel(detail: Detail) -> Assembly {
    let mut wheel = Assembly::default();
    let mut put = |sheet, placement| wheel.put(sheet, placement);
    if detail == Detail::Outline {
        let w = HALF_WIDTH;
        put(
            turned_solid(&[[-w, 0.0], [-w, RADIUS], [w, RADIUS], [w, RIM_RADIUS], [w - 0.04, 0.0]]),
            Placement::HERE,
        );
        return wheel;
    }
    put(tyre().finer(1.0, 1.8), Placement::HERE);
    put(rim().finer(1.0, 1.8), Placement::HERE);
    for k in 0..SPOKES {
        let angle = Placement::turned(2, k as f64 / SPOKES as f64);
        for side in [-1.0, 1.0] {
            put(spoke(side), angle);
        }
    }
    put(hub_cap().finer(1.5, 1.0), Placement::HERE);
    put(annulus(0.075, 0.140, -0.005, 0.017), Placement::at(0.0, 0.0, 0.012));
    put(turned_solid(&[[-0.06, 0.0], [-0.06, 0.07], [0.02, 0.082], [0.02, 0.0]]), Placement::HERE);
    if detail == Detail::Full {
        tread(&mut wheel);
        fastenings(&mut wheel);
    }
    wheel
}

/// Tread surface, shoulders, side walls and beads around a hollow.
fn tyre() -> Sheet {
    let (w, base) = (HALF_WIDTH, RADIUS - TREAD);
    turned_ring(&[
        [-w + 0.012, RIM_RADIUS],
        [-w - 0.004, RIM_RADIUS + 0.03],
        [-w - 0.006, RIM_RADIUS + 0.055],
        [-w + 0.004, base - 0.018],
        [-w + 0.020, base],
        [w - 0.020, base],
        [w - 0.004, base - 0.018],
        [w + 0.006, RIM_RADIUS + 0.055],
        [w + 0.004, RIM_RADIUS + 0.03],
        [w - 0.012, RIM_RADIUS],
        [w - 0.020, base - 0.03],
        [0.020 - w, base - 0.03],
    ])
}

fn tread(wheel: &mut Assembly) {
    let [outline, hole] = gear(TREAD_BLOCKS, RADIUS - TREAD, RADIUS, RADIUS - TREAD - 0.004);
    for (rib, [from, to]) in TREAD_RIBS.into_iter().enumerate() {
        let offset = Placement::turned(2, rib as f64 * 0.37 / TREAD_BLOCKS as f64);
        wheel.put(pierced_prism(&outline, &hole, from, to).finer(0.6, 0.6), offset);
    }
}

fn rim() -> Sheet {
    let w = HALF_WIDTH - 0.014;
    turned_skin(&[
        [-w - 0.004, RIM_RADIUS + 0.006],
        [-w + 0.006, RIM_RADIUS - 0.010],
        [-0.03, RIM_RADIUS - 0.030],
        [0.06, RIM_RADIUS - 0.030],
        [w - 0.012, RIM_RADIUS - 0.012],
        [w + 0.006, RIM_RADIUS + 0.006],
        [w + 0.006, RIM_RADIUS - 0.004],
    ])
}

/// One half of a forked spoke, along x; `side` tells which.
fn spoke(side: f64) -> Sheet {
    // (radius, sideways, half width, rear face, front face)
    const STATIONS: [[f64; 5]; 4] = [
        [0.040, 0.012, 0.012, 0.035, 0.075],
        [0.090, 0.018, 0.013, 0.040, 0.078],
        [0.140, 0.030, 0.012, 0.046, 0.080],
        [0.194, 0.048, 0.015, 0.050, 0.084],
    ];
    solid(
        STATIONS
            .map(|[radius, aside, half, rear, front]| {
                let y = aside * side;
                let edge = half * 0.6;
                vec![
                    [radius, y + half, rear],
                    [radius, y + half, front - 0.006],
                    [radius, y + edge, front],
                    [radius, y - edge, front],
                    [radius, y - half, front - 0.006],
                    [radius, y - half, rear],
                ]
            })
            .to_vec(),
    )
}

fn hub_cap() -> Sheet {
    turned_solid(&[
        [0.03, 0.0],
        [0.03, 0.062],
        [0.076, 0.058],
        [0.082, 0.034],
        [0.084, 0.030],
        [0.092, 0.026],
        [0.094, 0.0],
    ])
}

/// Wheel nuts, valve, brake caliper and pads.
fn fastenings(wheel: &mut Assembly) {
    let nut = Rc::new(prism(&hexagon(0.011), 0.07, 0.090));
    for k in 0..WHEEL_NUTS {
        let on_circle = Placement::at(0.047, 0.0, 0.0);
        let angle = Placement::turned(2, (k as f64 + 0.5) / WHEEL_NUTS as f64);
        wheel.put(Rc::clone(&nut), on_circle.within(&angle));
    }
    wheel.put(cylinder(0.004, 0.05, 0.095), Placement::at(0.176, 0.0, 0.0));
    let caliper = block([0.055, 0.13, 0.075], 0.010);
    wheel.put(caliper, Placement::at(-0.115, 0.0, 0.014));
    for z in [-0.008, 0.036] {
        wheel.put(block([0.05, 0.10, 0.012], 0.003), Placement::at(-0.108, 0.0, z));
    }
}

fn hexagon(radius: f64) -> [[f64; 2]; 6] {
    std::array::from_fn(|k| turn(k as f64 / 6.0).map(|c| c * radius))
}
