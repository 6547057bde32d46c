//! Impacts that a line of algebra tells.

use super::*;

#[test]
fn cubes_that_approach_with_acceleration_touch_at_the_root_of_the_quadratic() {
    // 2 t + 1.5 t^2 = 1.
    let moving = Traveller::new(&cube(), at([-2.0, 0.1, 0.2]), along_x(2.0, 3.0));
    let found = impact(Traveller::at_rest(&cube()), moving, 10.0);
    let expected = (10_f64.sqrt() - 2.0) / 3.0;
    assert_time(found.time_s, expected, 10_f64.sqrt());
    assert!((found.normal[0] + 1.0).abs() < 1e-6, "{found:?}");
    assert!((found.points[0][0] + 0.5).abs() < 1e-5, "{found:?}");
    assert_eq!(found.trees, [0, 0]);
}

#[test]
fn both_bodies_may_move() {
    let fixed = Traveller::new(&cube(), at([0.0; 3]), along_x(-20.0, 1.0));
    let moving = Traveller::new(&cube(), at([-11.0, 0.3, 0.3]), along_x(30.0, 1.0));
    let found = impact(fixed, moving, 1.0);
    assert_time(found.time_s, 10.0 / 50.0, 50.0);
}

#[test]
fn a_body_that_brakes_in_time_does_not_touch() {
    // Stops after 1 m, then goes back.
    let braking =
        |gap: f64| Traveller::new(&cube(), at([-1.0 - gap, 0.0, 0.0]), along_x(2.0, -2.0));
    assert_apart(Traveller::at_rest(&cube()), braking(1.0 + 1e-3), 10.0);
    let found = impact(Traveller::at_rest(&cube()), braking(1.0 - 1e-3), 10.0);
    let expected = 1.0 - 1e-3_f64.sqrt();
    assert_time(found.time_s, expected, 2.0 * 1e-3_f64.sqrt());
}

#[test]
fn a_body_that_turns_round_far_away_comes_back() {
    // -3 t + t^2 = 1.
    let moving = Traveller::new(&cube(), at([-2.0, 0.0, 0.0]), along_x(-3.0, 2.0));
    let found = impact(Traveller::at_rest(&cube()), moving, 10.0);
    assert_time(found.time_s, (3.0 + 13_f64.sqrt()) / 2.0, 13_f64.sqrt());
}

#[test]
fn balls_touch_when_their_centres_are_two_radii_apart_to_within_their_facets() {
    let velocity = [4.0, 3.0, 0.0];
    let values = MotionValues { velocity_m_s: velocity, ..MotionValues::default() };
    let moving = Traveller::new(&ball(1.0, 16), at([-4.0, -3.0, 0.0]), motion(values));
    let found = impact(Traveller::at_rest(&ball(1.0, 16)), moving, 2.0);
    // A facet is at most this far inside its sphere.
    let sagitta = 1.0 - (std::f64::consts::PI / 16.0).cos().powi(2);
    let expected = (5.0 - 2.0) / 5.0;
    assert!(found.time_s >= expected - TOLERANCE, "{found:?}");
    assert!(found.time_s <= expected + 2.0 * sagitta / 5.0, "{found:?}");
}

#[test]
fn a_spinning_bar_hits_a_post_at_the_angle_where_it_stands() {
    // The bar's leading face is a plane through the axis.
    let bar = block([0.0, -0.1, 0.0], [2.0, 0.0, 0.2]);
    let (angle, gap) = (2.0_f64, 1.5_f64);
    let post = [gap * angle.cos(), gap * angle.sin(), 0.0];
    let post = vec![[post, [post[0], post[1], 1.0], post]];
    // 3 t + 0.5 t^2 = 2.
    let values = MotionValues {
        spin_rad_s: [0.0, 0.0, 3.0],
        spin_acceleration_rad_s2: [0.0, 0.0, 1.0],
        ..MotionValues::default()
    };
    let found =
        impact(Traveller::at_rest(&post), Traveller::new(&bar, at([0.0; 3]), motion(values)), 4.0);
    assert_time(found.time_s, 13_f64.sqrt() - 3.0, 13_f64.sqrt() * gap);
}

#[test]
fn a_bullet_goes_through_no_sheet_unseen() {
    let sheet = block([0.0, -1.0, -1.0], [1e-4, 1.0, 1.0]);
    for speed in [1e2, 1e4, 1e6] {
        let bullet = moved(&block([-0.01; 3], [0.0, 0.01, 0.01]), [-10.0, 0.3, 0.2]);
        let bullet = Traveller::new(&bullet, at([0.0; 3]), along_x(speed, 0.0));
        let found = impact(Traveller::at_rest(&sheet), bullet, 1.0);
        assert_time(found.time_s, 10.0 / speed, speed);
    }
}

#[test]
fn a_point_that_flies_through_one_triangle_is_seen() {
    let dust = vec![[[-3.0, 0.2, 0.2]; 3]];
    let triangle = vec![[[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
    let flying = Traveller::new(&dust, at([0.0; 3]), along_x(1e5, 0.0));
    let found = impact(Traveller::at_rest(&triangle), flying, 1.0);
    assert_time(found.time_s, 3e-5, 1e5);
}

#[test]
fn contact_at_the_start_is_at_time_0_and_at_the_end_is_contact() {
    let overlapping = Traveller::new(&cube(), at([0.4, 0.3, 0.2]), along_x(1.0, 0.0));
    let found = impact(Traveller::at_rest(&cube()), overlapping, 1.0);
    assert_eq!((found.time_s, found.distance_m), (0.0, 0.0));
    assert!((found.normal.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);

    let reaching = Traveller::new(&cube(), at([-2.0, 0.0, 0.0]), along_x(1.0, 0.0));
    let found = impact(Traveller::at_rest(&cube()), reaching, 1.0);
    assert_time(found.time_s, 1.0, 1.0);
}

#[test]
fn bodies_at_rest_stay_as_they_are() {
    let apart = |by| Traveller::new(&cube(), at([1.0 + by, 0.0, 0.0]), Motion::default());
    assert_apart(Traveller::at_rest(&cube()), apart(1e-5), 1e6);
    assert_eq!(impact(Traveller::at_rest(&cube()), apart(0.0), 1e6).time_s, 0.0);
}

#[test]
fn bodies_that_move_alike_never_meet_however_near() {
    let values = MotionValues {
        velocity_m_s: [30.0, 1.0, 0.0],
        spin_rad_s: [0.1, 2.0, 0.3],
        ..MotionValues::default()
    };
    // Both turn about the first one's middle.
    let together = |triangles: &[Triangle]| Traveller::new(triangles, at([0.0; 3]), motion(values));
    assert_apart(together(&cube()), together(&moved(&cube(), [0.0, 1.01, 0.0])), 0.3);
}
