//! A four-door saloon of about 4.5 m x 1.8 m x 1.4 m.

mod cabin;
mod chassis;
mod panels;
mod shell;
mod trim;
mod wheel;

use super::{assembly::Assembly, budget::Detail, placement::Placement};

/// x of the axles, distance between the wheels' middles, and height of the axles (m).
const FRONT_AXLE: f64 = 1.36;
const REAR_AXLE: f64 = -1.30;
const TRACK: f64 = 1.55;
const AXLE_HEIGHT: f64 = wheel::RADIUS;

pub(super) fn car(detail: Detail) -> Assembly {
    let mut car = Assembly::default();
    for part in
        [panels::panels(detail), trim::trim(detail), cabin::cabin(detail), chassis::chassis(detail)]
    {
        car.include(&part, Placement::HERE);
    }
    let wheel = wheel::wheel(detail);
    let mut left = Assembly::default();
    for x in [FRONT_AXLE, REAR_AXLE] {
        left.include(&wheel, Placement::AXLE.moved(x, TRACK / 2.0, AXLE_HEIGHT));
    }
    car.include_on_both_sides(&left);
    car
}
