//! The commander's cupola with its machine gun and shield.

use super::hull::ROOF;
use crate::mesh::builtin::{
    assembly::Assembly,
    budget::Detail,
    loft::{block, prism},
    placement::Placement,
    revolution::{annulus, cylinder, turned_solid},
};

/// Middle of the cupola (x, y), and height of the gun's bore (m).
const CUPOLA: [f64; 2] = [0.02, 0.0];
const BORE: f64 = 2.22;
const PERISCOPES: usize = 6;

pub(super) fn weapon(detail: Detail) -> Assembly {
    let mut weapon = Assembly::default();
    let cupola = Placement::at(CUPOLA[0], CUPOLA[1], ROOF);
    let ring = if detail == Detail::Outline {
        cylinder(0.40, -0.02, 0.19)
    } else {
        turned_solid(&[
            [-0.02, 0.0],
            [-0.02, 0.43],
            [0.05, 0.43],
            [0.07, 0.40],
            [0.17, 0.36],
            [0.19, 0.33],
            [0.19, 0.0],
        ])
    };
    weapon.put(ring, cupola);
    let bore = BORE - ROOF;
    let barrel = Placement::FORWARD.moved(CUPOLA[0], CUPOLA[1], BORE);
    weapon.put(cylinder(0.024, 0.55, 1.72), barrel);
    weapon.put(
        block([0.46, 0.10, 0.15], 0.012),
        Placement::at(0.34, 0.0, bore - 0.02).within(&cupola),
    );
    if detail == Detail::Outline {
        return weapon;
    }
    let mut put = |sheet, x, y, z| weapon.put(sheet, Placement::at(x, y, z).within(&cupola));
    put(
        turned_solid(&[[0.0, 0.0], [0.0, 0.29], [0.03, 0.28], [0.055, 0.20], [0.06, 0.0]]),
        -0.02,
        0.0,
        0.19,
    );
    put(block([0.16, 0.12, 0.30], 0.015), 0.38, 0.0, 0.17);
    put(block([0.28, 0.17, 0.19], 0.012), 0.36, 0.16, bore - 0.03);
    for side in [-1.0, 1.0] {
        let plate =
            prism(&[[-0.28, -0.20], [0.28, -0.30], [0.28, 0.22], [-0.20, 0.30]], -0.008, 0.008);
        let turn = Placement::turned(2, -0.06 * side);
        let at = Placement::UPRIGHT.within(&Placement::turned(2, 0.25)).within(&turn);
        weapon.put(plate, at.moved(0.62 + CUPOLA[0], 0.34 * side, ROOF + bore));
    }
    if detail == Detail::Full {
        small_parts(&mut weapon, bore);
    }
    weapon
}

fn small_parts(weapon: &mut Assembly, bore: f64) {
    let cupola = Placement::at(CUPOLA[0], CUPOLA[1], ROOF);
    let barrel = Placement::FORWARD.moved(CUPOLA[0], CUPOLA[1], BORE);
    weapon.put(annulus(0.028, 0.036, 0.56, 0.95), barrel);
    for k in 0..8 {
        let z = 0.58 + 0.045 * f64::from(k);
        weapon.put(annulus(0.035, 0.040, z, z + 0.012), barrel);
    }
    weapon.put(turned_solid(&[[1.66, 0.0], [1.66, 0.034], [1.80, 0.042], [1.80, 0.0]]), barrel);
    for k in 0..PERISCOPES {
        let angle = Placement::turned(2, (k as f64 + 0.5) / PERISCOPES as f64);
        let at = Placement::at(0.36, 0.0, 0.14).within(&angle).within(&cupola);
        weapon.put(block([0.10, 0.16, 0.10], 0.012), at);
        weapon.put(block([0.02, 0.13, 0.06], 0.0), Placement::at(0.05, 0.0, 0.01).within(&at));
    }
    for k in 0..24 {
        let angle = Placement::turned(2, f64::from(k) / 24.0);
        let at = Placement::at(0.415, 0.0, 0.045).within(&angle).within(&cupola);
        weapon.put(cylinder(0.010, 0.0, 0.018), at);
    }
    for side in [-0.03, 0.03] {
        weapon.put(cylinder(0.012, 0.0, 0.11), Placement::FORWARD.moved(0.02, side, BORE - 0.01));
    }
    let mut put = |sheet, x, y, z| weapon.put(sheet, Placement::at(x, y, z).within(&cupola));
    put(block([0.02, 0.10, 0.02], 0.0), 0.0, 0.0, bore - 0.01);
    put(block([0.05, 0.02, 0.04], 0.004), 0.50, 0.0, bore + 0.07);
    put(block([0.12, 0.05, 0.04], 0.008), -0.31, 0.10, 0.21);
    put(block([0.12, 0.05, 0.04], 0.008), -0.31, -0.10, 0.21);
    weapon.put(
        cylinder(0.022, -0.17, 0.17),
        Placement::AXLE.moved(CUPOLA[0] - 0.36, 0.0, ROOF + 0.21),
    );
}
