//! All times in contact.

use bumper::tree::advance::{AdvanceError, Intervals, Resolution};

use super::*;

fn intervals(
    fixed: &[Traveller],
    moving: &[Traveller],
    seconds: f64,
    resolution: f64,
) -> Intervals {
    let resolution = Resolution::new(resolution).unwrap();
    search([fixed, moving], [TreeKind::Wide; 2], |[fixed, moving]| {
        let mut advancement = Advancement::new(Tolerance::new(TOLERANCE).unwrap());
        let horizon = Horizon::new(seconds).unwrap();
        advancement.contact_intervals(fixed, moving, horizon, resolution).unwrap()
    })
}

fn plate(x: f64) -> Traveller {
    Traveller::at_rest(&block([x, -3.0, -3.0], [x + 0.01, 3.0, 3.0]))
}

fn assert_intervals(found: &Intervals, end: f64, expected: &[[f64; 2]]) {
    assert_eq!(found.known_until_s, end);
    assert_eq!(found.enter_leave_s.len(), expected.len(), "{found:?}");
    for (found, expected) in found.enter_leave_s.as_flattened().iter().zip(expected.as_flattened())
    {
        assert!((found - expected).abs() < 3e-6, "{found}, not {expected}");
    }
}

#[test]
fn a_cube_that_passes_two_plates_is_in_contact_twice() {
    let moving = [Traveller::new(&cube(), at([-1.0, 0.0, 0.0]), along_x(1.0, 0.0))];
    let found = intervals(&[plate(0.0), plate(5.0)], &moving, 10.0, 0.1);
    assert_intervals(&found, 10.0, &[[0.5, 1.51], [5.5, 6.51]]);
}

#[test]
fn contact_at_both_ends_of_the_time_is_listed() {
    // Comes back at 2 s, at the speed it went with.
    let moving = [Traveller::new(&cube(), at([0.3, 0.0, 0.0]), along_x(2.0, -2.0))];
    let found = intervals(&[plate(0.0)], &moving, 2.0, 0.05);
    // It leaves at 0.21 m further: 2 t - t^2 = 0.21.
    let leave = 1.0 - 0.79_f64.sqrt();
    assert_intervals(&found, 2.0, &[[0.0, leave], [2.0 - leave, 2.0]]);
}

#[test]
fn bodies_that_touch_and_stay_are_in_contact_for_all_time() {
    let moving = [Traveller::new(&cube(), at([1.0, 0.0, 0.0]), Motion::default())];
    let found = intervals(&[Traveller::at_rest(&cube())], &moving, 3.0, 0.5);
    assert_intervals(&found, 3.0, &[[0.0, 3.0]]);
}

#[test]
fn bodies_that_never_touch_have_no_interval() {
    let moving = [Traveller::new(&cube(), at([5.0, 0.0, 0.0]), along_x(1.0, 0.0))];
    let found = intervals(&[Traveller::at_rest(&cube())], &moving, 3.0, 0.5);
    assert_intervals(&found, 3.0, &[]);
}

#[test]
fn every_turn_of_a_spinning_bar_is_an_interval() {
    let bar = block([0.0, -0.05, 0.0], [2.0, 0.0, 0.2]);
    let post = vec![[[1.5, 0.5, 0.0], [1.5, 0.5, 1.0], [1.5, 0.5, 0.5]]];
    let values =
        MotionValues { spin_rad_s: [0.0, 0.0, std::f64::consts::TAU], ..MotionValues::default() };
    let moving = [Traveller::new(&bar, at([0.0; 3]), motion(values))];
    let found = intervals(&[Traveller::at_rest(&post)], &moving, 3.0, 0.002);
    let (far, angle) = (1.5_f64.hypot(0.5), 0.5_f64.atan2(1.5));
    let [enter, leave] = [angle, angle + (0.05 / far).asin()].map(|a| a / std::f64::consts::TAU);
    let expected = [0.0, 1.0, 2.0].map(|turns| [enter + turns, leave + turns]);
    assert_intervals(&found, 3.0, &expected);
}

#[test]
fn what_is_no_resolution_is_refused() {
    for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Resolution::new(seconds), Err(AdvanceError::Resolution(_))));
    }
    let moving = [Traveller::at_rest(&cube())];
    let refused = search([&moving, &moving], [TreeKind::Wide; 2], |[fixed, moving]| {
        let mut advancement = Advancement::new(Tolerance::new(TOLERANCE).unwrap());
        let [horizon, resolution] = [1.0, 1e-7];
        let resolution = Resolution::new(resolution).unwrap();
        let horizon = Horizon::new(horizon).unwrap();
        advancement.contact_intervals(fixed, moving, horizon, resolution)
    });
    assert_eq!(refused, Err(AdvanceError::TooFine(1.0)));
}
