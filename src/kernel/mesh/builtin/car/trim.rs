//! What is fixed to the body from outside: lamps, grille, mirrors, handles, plates, wipers.

use std::rc::Rc;

use super::{
    panels::{band, strip},
    shell::{BELT, body, canopy, greenhouse, plan_of},
};
use crate::{
    geometry::Point,
    mesh::builtin::{
        assembly::Assembly,
        budget::Detail,
        loft::{block, solid, tapered_block},
        placement::Placement,
        revolution::{annulus, cylinder, turned_skin, turned_solid},
    },
};

/// Where the lamps are on the plan, and their lower edges (m).
const HEADLAMP: [f64; 2] = [0.50, 0.965];
const HEADLAMP_FOOT: f64 = 0.541;
const TAIL_LAMP: [f64; 2] = [2.035, 2.355];
const TAIL_LAMP_FOOT: f64 = 0.626;
const GRILLE_SLATS: usize = 5;
const INTAKE_SLATS: usize = 4;
/// A number plate, thickness, width and height (m).
const PLATE: [f64; 3] = [0.006, 0.52, 0.11];

pub(super) fn trim(detail: Detail) -> Assembly {
    let mut trim = Assembly::default();
    trim.include_on_both_sides(&left(detail));
    trim.include(&middle(detail), Placement::HERE);
    trim
}

fn left(detail: Detail) -> Assembly {
    let mut left = Assembly::default();
    let mut lens = |plan, foot, shares, depth| {
        left.put(strip(detail, plan, foot, shares, depth), Placement::HERE);
    };
    lens(HEADLAMP, HEADLAMP_FOOT, [0.0, 1.0], 0.014);
    lens(TAIL_LAMP, TAIL_LAMP_FOOT, [0.0, 0.25], 0.012);
    lens(TAIL_LAMP, TAIL_LAMP_FOOT, [0.26, 0.62], -0.004);
    lens(TAIL_LAMP, TAIL_LAMP_FOOT, [0.63, 1.0], 0.004);
    mirror(&mut left, detail);
    if detail == Detail::Full {
        behind_the_headlamp(&mut left);
        for x in [-0.10, -0.82] {
            door_handle(&mut left, x);
        }
        left.put(cylinder(0.035, -0.005, 0.02), facing_forward(0.62, 0.34, 0.02));
        left.put(annulus(0.036, 0.045, -0.005, 0.026), facing_forward(0.62, 0.34, 0.02));
    }
    left
}

/// A placement on the nose whose z axis looks ahead.
fn facing_forward(s: f64, z: f64, depth: f64) -> Placement {
    let [x, y, z] = body(s, z, depth);
    Placement::FORWARD.moved(x, y, z)
}

fn behind_the_headlamp(left: &mut Assembly) {
    const BOWL: [[f64; 2]; 4] = [[-0.09, 0.012], [-0.07, 0.035], [-0.03, 0.055], [0.0, 0.062]];
    for s in [0.60, 0.76] {
        let at = facing_forward(s, 0.61, 0.10);
        left.put(turned_skin(&BOWL), at);
        left.put(turned_solid(&[[-0.02, 0.0], [-0.02, 0.03], [-0.004, 0.026], [0.006, 0.0]]), at);
        left.put(annulus(0.058, 0.066, -0.006, 0.004), at);
    }
}

fn mirror(left: &mut Assembly, detail: Detail) {
    // (distance from the glass, half width, half height): the cap behind a mirror, along x.
    const CAP: [[f64; 3]; 4] =
        [[0.0, 0.088, 0.062], [0.04, 0.090, 0.064], [0.09, 0.066, 0.046], [0.115, 0.030, 0.020]];
    let [x, y, z] = greenhouse(0.72, BELT.at(0.72) + 0.085, 0.0);
    let section = |[x, half_width, half_height]: [f64; 3]| {
        let (w, h) = (half_width, half_height);
        let corner = 0.55;
        [
            [w, -h * corner],
            [w, h * corner],
            [w * corner, h],
            [-w * corner, h],
            [-w, h * corner],
            [-w, -h * corner],
            [-w * corner, -h],
            [w * corner, -h],
        ]
        .map(|[y, z]| [x, y, z])
        .to_vec()
    };
    left.put(solid(CAP.map(section).to_vec()).finer(2.0, 2.0), Placement::at(x, y + 0.13, z));
    if detail >= Detail::Parts {
        left.put(block([0.05, 0.11, 0.022], 0.006), Placement::at(x + 0.03, y + 0.03, z - 0.055));
        left.put(block([0.004, 0.155, 0.105], 0.0), Placement::at(x - 0.001, y + 0.13, z));
    }
}

fn door_handle(left: &mut Assembly, x: f64) {
    let [x, y, z] = body(plan_of(x), 0.80, 0.0);
    left.put(block([0.20, 0.018, 0.028], 0.006), Placement::at(x, y + 0.030, z));
    for end in [-0.085, 0.085] {
        left.put(block([0.022, 0.045, 0.022], 0.004), Placement::at(x + end, y + 0.006, z));
    }
}

/// An arm from the scuttle and the blade it carries, parked at the foot of the windscreen.
fn wiper(middle: &mut Assembly, pivot: f64) {
    let mut bar = |from: Point, to: Point, width: f64, height: f64| {
        let (along, length) = Placement::between(from, to);
        let centred = Placement::at(0.0, 0.0, length / 2.0).within(&along);
        middle.put(block([height, width, length], 0.2 * width.min(height)), centred);
    };
    bar(canopy(1.03, pivot, -0.02), canopy(0.93, pivot - 0.40, -0.03), 0.016, 0.012);
    bar(canopy(0.985, pivot - 0.06, -0.014), canopy(0.90, pivot - 0.74, -0.014), 0.012, 0.022);
    let [x, y, z] = canopy(1.03, pivot, 0.0);
    middle.put(cylinder(0.014, -0.02, 0.03), Placement::at(x, y, z));
}

fn middle(detail: Detail) -> Assembly {
    let mut middle = Assembly::default();
    let mut put = |sheet, x, y, z| middle.put(sheet, Placement::at(x, y, z));
    let nose = body(0.0, 0.47, 0.0)[0];
    let tail = body(3.0, 0.50, 0.0)[0];
    put(block(PLATE, 0.0), nose + 0.006, 0.0, 0.47);
    put(block(PLATE, 0.0), tail - 0.006, 0.0, 0.50);
    if detail >= Detail::Parts {
        slats(&mut middle, detail);
    }
    if detail == Detail::Full {
        wiper(&mut middle, 0.70);
        wiper(&mut middle, -0.04);
        let badge = body(0.0, 0.595, -0.004);
        middle.put(
            cylinder(0.035, -0.01, 0.012),
            Placement::FORWARD.moved(badge[0], badge[1], badge[2]),
        );
        let [x, y, z] = canopy(-0.60, 0.0, 0.0);
        middle.put(
            tapered_block([0.16, 0.03, 0.05], [0.03, 0.006], 0.0),
            Placement::at(x, y, z + 0.02),
        );
        let [x, y, z] = canopy(-0.70, 0.0, 0.02);
        middle.put(block([0.03, 0.30, 0.02], 0.005), Placement::at(x - 0.10, y, z - 0.02));
    }
    middle
}

/// The bars of the grille and of the intake below the bumper.
fn slats(middle: &mut Assembly, detail: Detail) {
    for k in 0..GRILLE_SLATS {
        let share = k as f64 / GRILLE_SLATS as f64;
        let slat = strip(detail, [-0.49, 0.49], HEADLAMP_FOOT, [share + 0.04, share + 0.13], 0.006);
        middle.put(slat, Placement::HERE);
    }
    for k in 0..INTAKE_SLATS {
        let z = 0.275 + 0.13 * k as f64 / INTAKE_SLATS as f64;
        middle.put(band(detail, [-0.515, 0.515], z, move |_| z + 0.014), Placement::HERE);
    }
    let frame = strip(detail, [-0.49, 0.49], HEADLAMP_FOOT, [0.9, 1.0], 0.0);
    middle.put(frame, Placement::HERE);
    let upright = Rc::new(block([0.02, 0.012, 0.13], 0.0));
    for k in -3..=3 {
        let [x, y, z] = body(f64::from(k) * 0.14, 0.335, 0.03);
        middle.put(Rc::clone(&upright), Placement::at(x, y, z));
    }
}
