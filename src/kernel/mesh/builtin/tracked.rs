//! A tracked armoured personnel carrier of about 4.9 m x 2.7 m x 2.5 m, after the M113.

mod belt;
mod fittings;
mod hull;
mod running_gear;
mod shoe;
mod weapon;

use super::{assembly::Assembly, budget::Detail, placement::Placement};

/// Sideways from the middle of the vehicle to the middle of a track (m).
const TRACK: f64 = 1.08;

pub(super) fn tracked(detail: Detail) -> Assembly {
    let mut left = running_gear::running_gear(detail);
    left.include(&shoe::track(detail), Placement::HERE);
    let mut vehicle = Assembly::default();
    vehicle.include_on_both_sides(&left);
    vehicle.include(&hull::hull(detail), Placement::HERE);
    vehicle.include(&weapon::weapon(detail), Placement::HERE);
    vehicle.include(&fittings::fittings(detail), Placement::HERE);
    vehicle
}
