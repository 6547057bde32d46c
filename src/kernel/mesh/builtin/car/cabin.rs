//! Inside: floor, seats, dashboard, steering wheel, pedals.

use std::rc::Rc;

use crate::mesh::builtin::{
    assembly::Assembly,
    budget::Detail,
    loft::{block, tapered_block},
    placement::Placement,
    revolution::{cylinder, torus, turned_solid},
};

/// Middle of a front seat, sideways (m); the driver sits on the left.
const SEAT: f64 = 0.36;
/// Lean of a backrest and of the steering column, fractions of a turn.
const RECLINE: f64 = -0.055;
const COLUMN: f64 = -0.18;

pub(super) fn cabin(detail: Detail) -> Assembly {
    let mut cabin = Assembly::default();
    if detail == Detail::Outline {
        return cabin;
    }
    let mut seat = Assembly::default();
    front_seat(&mut seat, detail);
    cabin.include(&seat, Placement::at(-0.10, SEAT, 0.30));
    cabin.include(&seat, Placement::at(-0.10, -SEAT, 0.30));
    rear_bench(&mut cabin);
    dashboard(&mut cabin, detail);
    steering(&mut cabin);
    cabin
}

/// Origin on the floor below the middle of the cushion.
fn front_seat(seat: &mut Assembly, detail: Detail) {
    let lean = Placement::turned(1, RECLINE);
    let back = |z: f64, x: f64| Placement::at(x, 0.0, z).within(&lean.moved(-0.24, 0.0, 0.22));
    seat.put(tapered_block([0.50, 0.50, 0.16], [0.48, 0.46], 0.04), Placement::at(0.0, 0.0, 0.18));
    seat.put(tapered_block([0.13, 0.48, 0.58], [0.09, 0.36], 0.03), back(0.28, 0.0));
    seat.put(block([0.09, 0.26, 0.17], 0.03), back(0.70, 0.0));
    if detail < Detail::Full {
        return;
    }
    for side in [-0.21, 0.21] {
        seat.put(block([0.44, 0.07, 0.09], 0.02), Placement::at(0.01, side, 0.26));
        seat.put(block([0.10, 0.06, 0.40], 0.018), back(0.26, 0.05).moved(0.0, side, 0.0));
        seat.put(block([0.50, 0.025, 0.03], 0.005), Placement::at(0.0, side, 0.06));
        seat.put(block([0.05, 0.02, 0.08], 0.0), Placement::at(0.18, side, 0.03));
    }
    for side in [-0.06, 0.06] {
        seat.put(
            cylinder(0.007, 0.55, 0.66),
            Placement::at(0.0, side, 0.0).within(&back(0.0, 0.0)),
        );
    }
}

fn rear_bench(cabin: &mut Assembly) {
    let lean = Placement::turned(1, RECLINE * 1.3).moved(-1.10, 0.0, 0.50);
    cabin.put(
        tapered_block([0.50, 1.24, 0.18], [0.48, 1.20], 0.05),
        Placement::at(-0.88, 0.0, 0.45),
    );
    cabin.put(
        tapered_block([0.14, 1.24, 0.58], [0.10, 1.10], 0.03),
        Placement::at(0.0, 0.0, 0.29).within(&lean),
    );
    for side in [-0.36, 0.0, 0.36] {
        cabin.put(block([0.07, 0.22, 0.12], 0.02), Placement::at(0.0, side, 0.63).within(&lean));
    }
    cabin.put(block([0.45, 1.10, 0.02], 0.004), Placement::at(-1.42, 0.0, 0.955));
}

fn dashboard(cabin: &mut Assembly, detail: Detail) {
    cabin
        .put(tapered_block([0.42, 1.36, 0.24], [0.30, 1.30], 0.05), Placement::at(0.80, 0.0, 0.77));
    cabin
        .put(tapered_block([0.80, 0.24, 0.26], [0.74, 0.18], 0.03), Placement::at(0.25, 0.0, 0.37));
    if detail < Detail::Full {
        return;
    }
    cabin.put(
        tapered_block([0.16, 0.34, 0.09], [0.10, 0.26], 0.02),
        Placement::at(0.66, SEAT, 0.90),
    );
    cabin.put(block([0.02, 0.24, 0.15], 0.005), Placement::at(0.60, 0.0, 0.80));
    let vent = Rc::new(block([0.02, 0.11, 0.055], 0.006));
    for side in [-0.58, -0.16, 0.16, 0.58] {
        cabin.put(Rc::clone(&vent), Placement::at(0.61, side, 0.86));
    }
    for y in [SEAT - 0.02, SEAT + 0.12, SEAT - 0.15] {
        cabin.put(block([0.02, 0.055, 0.07], 0.004), Placement::at(0.86, y, 0.36));
        cabin.put(block([0.02, 0.012, 0.22], 0.0), Placement::at(0.87, y, 0.48));
    }
    cabin.put(cylinder(0.009, 0.0, 0.12), Placement::at(0.28, 0.0, 0.48));
    cabin.put(
        turned_solid(&[[0.0, 0.0], [0.008, 0.022], [0.03, 0.026], [0.045, 0.0]]),
        Placement::at(0.28, 0.0, 0.59),
    );
    cabin.put(block([0.20, 0.03, 0.035], 0.008), Placement::at(-0.02, 0.03, 0.54));
}

fn steering(cabin: &mut Assembly) {
    let column = Placement::turned(1, COLUMN).moved(0.42, SEAT, 0.80);
    let mut put = |sheet, at: Placement| cabin.put(sheet, at.within(&column));
    put(torus(0.18, 0.015).finer(1.5, 1.5), Placement::HERE);
    put(turned_solid(&[[-0.04, 0.0], [-0.04, 0.06], [0.0, 0.065], [0.012, 0.0]]), Placement::HERE);
    put(cylinder(0.025, -0.35, -0.03), Placement::HERE);
    for angle in [0.0, 0.25, 0.75] {
        let arm = Placement::at(0.11, 0.0, -0.012).within(&Placement::turned(2, angle));
        put(block([0.13, 0.035, 0.014], 0.004), arm);
    }
}
