//! Parts that move on their bodies.

use super::*;

fn post(x: f64, y: f64) -> Vec<Triangle> {
    vec![[[x, y, -1.0], [x, y, 1.0], [x, y, 0.0]]]
}

#[test]
fn a_door_that_opens_hits_the_post_and_the_body_does_not() {
    let body = block([0.0, -1.0, 0.0], [3.0, 0.0, 0.5]);
    let leaf = block([1.0, 0.0, 0.0], [2.0, 0.05, 0.5]);
    // The outer face of the leaf, of y = 0.05, is turned about its hinge until it has the post: the
    // direction to the post is asin(0.05 / r) ahead of the face.
    let hinge = TurnValues {
        point_m: [1.0, 0.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        rate_rad_s: 0.5,
        acceleration_rad_s2: 0.0,
    };
    let (far, angle) = (0.7_f64, 1.0_f64);
    let [x, y] = [1.0 + far * angle.cos(), far * angle.sin()];
    let car = along_x(0.0, 0.0);
    let moving = [
        Traveller::new(&body, Pose::IDENTITY, car),
        Traveller::part(&leaf, Pose::IDENTITY, car, turning(hinge)),
    ];
    let fixed = [Traveller::at_rest(&post(10.0, 10.0)), Traveller::at_rest(&post(x, y))];
    let Outcome::Impact(found) = first_impact(&fixed, &moving, 3.0) else { panic!("no impact") };
    assert_eq!(found.trees, [1, 1]);
    let expected = (angle - (0.05 / far).asin()) / 0.5;
    assert_time(found.time_s, expected, 0.5 * far * 0.99);
}

#[test]
fn a_spike_on_a_wheel_reaches_a_stone_that_the_car_passes() {
    // Rolls at 2 m/s, so that the spike is lowest, 0.3 m + 0.1 m below the axle, after half a turn.
    let turn = TurnValues {
        point_m: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        rate_rad_s: 2.0 / 0.3,
        acceleration_rad_s2: 0.0,
    };
    let spike = vec![[[-0.01, 0.0, 0.3], [0.01, 0.0, 0.3], [0.0, 0.0, 0.4]]];
    let half_turn = std::f64::consts::PI * 0.3 / 2.0;
    let stone_at = |depth: f64| {
        let x = 2.0 * half_turn;
        Traveller::at_rest(&block([x - 0.2, -0.2, -1.0], [x + 0.2, 0.2, -depth]))
    };
    let wheel = || Traveller::part(&spike, Pose::IDENTITY, along_x(2.0, 0.0), turning(turn));
    assert_apart(stone_at(0.4 + 1e-4), wheel(), 2.0 * half_turn);
    let found = impact(stone_at(0.4 - 1e-4), wheel(), 2.0 * half_turn);
    // -0.4 cos(angle from lowest) = -(0.4 - 1e-4).
    let before = ((0.4 - 1e-4) / 0.4_f64).acos() / (2.0 / 0.3);
    assert_time(found.time_s, half_turn - before, 2.0 / 0.3 * 0.4 * 0.02);
    // And not if it does not turn.
    let still = Traveller::new(&spike, Pose::IDENTITY, along_x(2.0, 0.0));
    assert_apart(stone_at(0.4 - 1e-4), still, 2.0 * half_turn);
}

#[test]
fn a_sliding_part_accelerates_out_of_its_body() {
    let values = PartMotionValues {
        velocity_m_s: [0.0, 0.5, 0.0],
        acceleration_m_s2: [0.0, 4.0, 0.0],
        ..PartMotionValues::default()
    };
    let slide = PartMotion::new(values).unwrap();
    // The body's own axes are turned by a quarter: its y is the world's -x.
    let half = 0.5_f64.sqrt();
    let start = Pose::from_quaternion([half, 0.0, 0.0, half], [-1.0, 0.0, 0.0]);
    let drawer = Traveller::part(&cube(), start, Motion::default(), slide);
    let wall = Traveller::at_rest(&block([-4.0, -2.0, -2.0], [-3.0, 2.0, 2.0]));
    // 0.5 t + 2 t^2 = 1.5.
    let found = impact(wall, drawer, 3.0);
    assert_time(found.time_s, 0.75, 3.5);
}

#[test]
fn parts_of_one_side_may_overlap() {
    let moving = [
        Traveller::new(&cube(), at([5.0, 0.0, 0.0]), Motion::default()),
        Traveller::new(&cube(), at([5.2, 0.1, 0.1]), Motion::default()),
    ];
    let fixed = [Traveller::at_rest(&cube())];
    assert_eq!(first_impact(&fixed, &moving, 1.0), Outcome::Apart);
    assert_eq!(first_impact(&fixed, &[], 1.0), Outcome::Apart);
}
