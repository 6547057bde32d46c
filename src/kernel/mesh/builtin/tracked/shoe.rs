//! The left track: its shoes along the belt.

use super::{
    TRACK,
    belt::{Station, stations},
    running_gear::belt_circles,
};
use crate::mesh::builtin::{
    assembly::Assembly,
    budget::Detail,
    loft::{block, loft, prism, tapered_block},
    placement::Placement,
    revolution::cylinder,
    sheet::{Ends, Sheet},
    turn::turn,
};

const SHOES: usize = 63;
/// Distance between pins, and width of a shoe (m).
const PITCH: f64 = 0.153;
const WIDTH: f64 = 0.381;
/// Inner face of a shoe and ground face of its pad, outward from the line of pins (m).
const INNER_FACE: f64 = -0.022;
const PAD_FACE: f64 = 0.055;
/// Corners of the band that stands for the shoes in an outline.
const BAND_CORNERS: usize = 16;

pub(super) fn track(detail: Detail) -> Assembly {
    let mut track = Assembly::default();
    if detail == Detail::Outline {
        track.put(band(), Placement::HERE);
        return track;
    }
    let shoe = shoe(detail);
    for Station { point, along, outward } in stations(&belt_circles(), SHOES) {
        let at = Placement::facing(
            [along[0], 0.0, along[1]],
            [outward[0], 0.0, outward[1]],
            [point[0], TRACK, point[1]],
        );
        track.include(&shoe, at);
    }
    track
}

/// x along the track, z outward, origin in the middle between the pins.
fn shoe(detail: Detail) -> Assembly {
    let mut shoe = Assembly::default();
    let mut put = |sheet, x, y, z| shoe.put(sheet, Placement::at(x, y, z));
    let horn = |chamfer| tapered_block([0.045, 0.022, 0.085], [0.095, 0.042], chamfer);
    if detail == Detail::Parts {
        put(block([0.145, WIDTH, 0.044], 0.0), 0.0, 0.0, 0.0);
        put(block([0.09, 0.30, 0.034], 0.0), 0.0, 0.0, PAD_FACE - 0.017);
        put(horn(0.0), 0.0, 0.0, INNER_FACE - 0.042);
        return shoe;
    }
    put(block([0.118, WIDTH, 0.044], 0.008).finer(1.3, 1.3), 0.0, 0.0, 0.0);
    put(
        tapered_block([0.100, 0.30, 0.036], [0.084, 0.28], 0.006).finer(1.3, 1.3),
        0.0,
        0.0,
        PAD_FACE - 0.018,
    );
    put(horn(0.005), 0.0, 0.0, INNER_FACE - 0.042);
    for x in [-0.054, 0.054] {
        put(block([0.014, WIDTH - 0.01, 0.020], 0.003), x, 0.0, 0.028);
    }
    for y in [-0.115, 0.115] {
        put(block([0.10, 0.05, 0.012], 0.003), 0.0, y, INNER_FACE - 0.003);
    }
    hinge(&mut shoe);
    shoe
}

/// The pin towards the next shoe, its nuts, and the interleaved lugs around it and the pin before.
fn hinge(shoe: &mut Assembly) {
    let pin = |x: f64| Placement::AXLE.moved(x, 0.0, 0.0);
    let half = WIDTH / 2.0;
    shoe.put(cylinder(0.013, -half - 0.012, half + 0.012), pin(PITCH / 2.0));
    for end in [-half - 0.014, half] {
        let hexagon: [[f64; 2]; 6] =
            std::array::from_fn(|k| turn(k as f64 / 6.0).map(|c| c * 0.021));
        shoe.put(prism(&hexagon, end, end + 0.014), pin(PITCH / 2.0));
    }
    for (x, [from, to]) in [
        (PITCH / 2.0, [-half, -0.115]),
        (PITCH / 2.0, [-0.035, 0.035]),
        (PITCH / 2.0, [0.115, half]),
        (-PITCH / 2.0, [-0.110, -0.040]),
        (-PITCH / 2.0, [0.040, 0.110]),
    ] {
        shoe.put(cylinder(0.0235, from, to), pin(x));
    }
}

fn band() -> Sheet {
    let sections = stations(&belt_circles(), BAND_CORNERS).into_iter().map(|station| {
        let half = WIDTH / 2.0;
        [[-half, INNER_FACE], [-half, PAD_FACE], [half, PAD_FACE], [half, INNER_FACE]]
            .map(|[y, out]| {
                let [x, z] = [0, 1].map(|k| station.point[k] + out * station.outward[k]);
                [x, TRACK + y, z]
            })
            .to_vec()
    });
    loft(sections.collect(), Ends::RING)
}
