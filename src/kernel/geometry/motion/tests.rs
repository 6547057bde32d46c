use nalgebra::Vector3;
use proptest::prelude::*;

use super::*;
use crate::geometry::Pose;

const AT: Point = [0.3, -0.2, 0.9];

fn turn() -> TurnValues {
    TurnValues {
        point_m: [1.0, 2.0, 0.0],
        axis: [0.0, 0.6, 0.8],
        rate_rad_s: 3.0,
        acceleration_rad_s2: -2.0,
    }
}

#[test]
fn what_is_no_number_is_refused_by_the_name_of_its_key() {
    let infinite = [0.0, f64::INFINITY, 0.0];
    let name = |error: MotionError| error.to_string().split(' ').next().unwrap().to_owned();
    let motion = |values| name(Motion::new(values).unwrap_err());
    let none = MotionValues::default();
    assert_eq!(motion(MotionValues { velocity_m_s: infinite, ..none }), "velocity_m_s");
    assert_eq!(motion(MotionValues { acceleration_m_s2: infinite, ..none }), "acceleration_m_s2");
    assert_eq!(motion(MotionValues { spin_rad_s: infinite, ..none }), "spin_rad_s");
    let spin_acceleration_rad_s2 = [f64::NAN; 3];
    let values = MotionValues { spin_acceleration_rad_s2, ..none };
    assert_eq!(motion(values), "spin_acceleration_rad_s2");
    assert_eq!(motion(MotionValues { cg_m: infinite, ..none }), "cg_m");

    let part = |values| name(PartMotion::new(values).unwrap_err());
    let none = PartMotionValues::default();
    assert_eq!(part(PartMotionValues { velocity_m_s: infinite, ..none }), "velocity_m_s");
    let turning = |turn| PartMotionValues { turn: Some(turn), ..none };
    assert_eq!(part(turning(TurnValues { rate_rad_s: f64::NAN, ..turn() })), "turn.rate_rad_s");
    assert_eq!(part(turning(TurnValues { axis: [0.0, 1.0, 1.0], ..turn() })), "turn.axis");
    assert_eq!(part(turning(TurnValues { axis: [0.0; 3], ..turn() })), "turn.axis");
}

#[test]
fn a_motion_without_duration_is_refused() {
    for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Horizon::new(seconds).unwrap_err();
        assert!(error.to_string().starts_with("duration_s"), "{error}");
    }
}

#[test]
fn a_motion_that_cannot_be_followed_is_refused() {
    let rounding = |values, seconds| {
        let motion = Motion::new(values).unwrap();
        let trajectory = Trajectory::new(Pose::IDENTITY, &motion, None);
        trajectory.rounding(1.0, Horizon::new(seconds).unwrap())
    };
    let none = MotionValues::default();
    let fast = MotionValues { velocity_m_s: [1e300, 0.0, 0.0], ..none };
    let spinning = MotionValues { spin_rad_s: [0.0, 0.0, 1e12], ..none };
    for values in [fast, spinning] {
        assert_eq!(rounding(values, 1.0), Err(MotionError::OutOfRange { duration_s: 1.0 }));
    }
    let ordinary = MotionValues { velocity_m_s: [1e3, 0.0, 0.0], ..none };
    assert!(rounding(ordinary, 1.0).unwrap().position_m < 1e-9);
}

#[test]
fn values_survive_serialization_and_bad_ones_do_not_come_back() {
    let values = MotionValues { spin_rad_s: [0.1, 0.2, 1.0 / 3.0], ..MotionValues::default() };
    let text = serde_json::to_string(&Motion::new(values).unwrap()).unwrap();
    assert_eq!(*serde_json::from_str::<Motion>(&text).unwrap().values(), values);
    let values = PartMotionValues { turn: Some(turn()), ..PartMotionValues::default() };
    let text = serde_json::to_string(&PartMotion::new(values).unwrap()).unwrap();
    assert_eq!(*serde_json::from_str::<PartMotion>(&text).unwrap().values(), values);
    let bad = r#"{"turn": {"point_m": [0, 0, 0], "axis": [2, 0, 0]}}"#;
    assert!(serde_json::from_str::<PartMotion>(bad).is_err());
    assert!(serde_json::from_str::<Horizon>("0").is_err());
}

#[test]
fn the_pose_at_time_0_is_exactly_the_start() {
    let start = Pose::from_quaternion([0.36, -0.48, 0.64, 0.48], [0.1, -7.3, 1e6]);
    let values = MotionValues { spin_rad_s: [1.0, 2.0, 3.0], cg_m: [0.7; 3], ..Default::default() };
    let trajectory = Trajectory::new(start, &Motion::new(values).unwrap(), None);
    assert_eq!(trajectory.pose(0.0), start);
    assert_eq!(Trajectory::at_rest(start).pose(17.3), start);
}

#[test]
fn a_quarter_turn_about_the_centre_of_gravity_while_it_falls() {
    let values = MotionValues {
        velocity_m_s: [2.0, 0.0, 0.0],
        acceleration_m_s2: [0.0, 0.0, -10.0],
        spin_rad_s: [0.0, 0.0, std::f64::consts::FRAC_PI_2],
        spin_acceleration_rad_s2: [0.0; 3],
        cg_m: [1.0, 0.0, 0.0],
    };
    let trajectory = Trajectory::new(Pose::IDENTITY, &Motion::new(values).unwrap(), None);
    let [x, y, z] = trajectory.pose(1.0).apply([2.0, 0.0, 0.0]);
    let expected = [3.0, 1.0, -5.0];
    assert!([x, y, z].iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{x} {y} {z}");
}

#[test]
fn a_wheel_of_a_moving_car_turns_about_its_own_axis() {
    let wheel = TurnValues {
        point_m: [1.0, 0.0, 0.3],
        axis: [0.0, 1.0, 0.0],
        rate_rad_s: 2.0 * std::f64::consts::PI,
        acceleration_rad_s2: 0.0,
    };
    let part = PartMotion::new(PartMotionValues { turn: Some(wheel), ..Default::default() });
    let car = MotionValues { velocity_m_s: [10.0, 0.0, 0.0], ..Default::default() };
    let car = Motion::new(car).unwrap();
    let trajectory = Trajectory::new(Pose::IDENTITY, &car, Some(&part.unwrap()));
    let top = trajectory.pose(0.25).apply([1.0, 0.0, 0.6]);
    let expected = [1.0 + 2.5 + 0.3, 0.0, 0.3];
    assert!(top.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{top:?}");
}

#[test]
fn the_earliest_crossing_is_the_smallest_positive_root_and_not_above_it() {
    let cases = [
        ((4.0, 2.0, 0.0), 2.0),
        ((4.0, 0.0, 2.0), 2.0),
        ((3.0, 4.0, -2.0), 1.0),
        ((1.0, -1.0, 4.0), 1.0),
        ((5.0, 4.0, -2.0), f64::INFINITY),
        ((1.0, -1.0, 0.0), f64::INFINITY),
        ((1.0, 0.0, 0.0), f64::INFINITY),
        ((1.0, -1.0, -1.0), f64::INFINITY),
        ((0.0, -1.0, -1.0), 0.0),
        ((-1.0, 0.0, 1.0), 0.0),
        ((f64::NAN, 1.0, 1.0), 0.0),
    ];
    for ((gap, speed, acceleration), expected) in cases {
        let found = earliest_crossing(gap, speed, acceleration);
        let is_right = found == expected || found <= expected && found > expected * (1.0 - 1e-12);
        assert!(is_right, "{found}, not {expected}");
    }
}

fn vector(most: f64) -> impl Strategy<Value = Point> {
    prop::array::uniform3(-most..most)
}

fn trajectories() -> impl Strategy<Value = Trajectory> {
    let motion =
        (vector(5.0), vector(9.0), vector(4.0), vector(6.0), any::<[bool; 2]>(), vector(1.0))
            .prop_map(
                |(velocity_m_s, acceleration_m_s2, spin, change, [spins, straight], cg_m)| {
                    let spin_rad_s = spin.map(|c| if spins { c } else { 0.0 });
                    let spin_acceleration_rad_s2 =
                        if straight { spin_rad_s.map(|c| -0.5 * c) } else { change };
                    let values = MotionValues {
                        velocity_m_s,
                        acceleration_m_s2,
                        spin_rad_s,
                        spin_acceleration_rad_s2,
                        cg_m,
                    };
                    Motion::new(values).unwrap()
                },
            );
    let part = (vector(2.0), vector(3.0), vector(1.0), -9.0..9.0_f64, -5.0..5.0_f64).prop_map(
        |(velocity_m_s, acceleration_m_s2, point_m, rate_rad_s, acceleration_rad_s2)| {
            let turn =
                TurnValues { point_m, axis: [0.48, -0.6, 0.64], rate_rad_s, acceleration_rad_s2 };
            let turn = Some(turn);
            PartMotion::new(PartMotionValues { turn, velocity_m_s, acceleration_m_s2 }).unwrap()
        },
    );
    let start = (vector(3.0), any::<bool>()).prop_map(|(translation, rigid)| {
        let mut pose = Pose::from_quaternion([0.36, -0.48, 0.64, 0.48], translation);
        if !rigid {
            pose.rotation[1] += 0.3;
        }
        pose
    });
    let part = prop::option::of(part);
    (start, motion, part)
        .prop_map(|(start, motion, part)| Trajectory::new(start, &motion, part.as_ref()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Of points on the ball around one, at many times of the span.
    #[test]
    fn no_point_gets_further_or_is_faster_than_its_bounds(
        trajectory in trajectories(),
        from in 0.0..1.5_f64,
        duration in 0.01..1.5_f64,
        direction in vector(1.0),
        offset in vector(0.5),
    ) {
        let span = trajectory.span(from, from + duration);
        let (center, n) = (Vector3::from(AT), Vector3::from(direction).normalize());
        let radius = Vector3::from(offset).norm();
        let carried = span.carry(&center, radius);
        let point = (center + Vector3::from(offset)).into();
        let at = |t: f64| Vector3::from(trajectory.pose(t).apply(point));
        let velocity = |t: f64| (at(t + 1e-5) - at(t - 1e-5)) / 2e-5;
        prop_assert!((velocity(from) - carried.velocity).norm() <= carried.spread + 1e-6);
        let (speed, along) = (span.speed(&center, radius), span.speed_along(&n, &center, radius));
        for step in 0..=40 {
            let t = duration * f64::from(step) / 40.0;
            let travel = (at(from + t) - at(from)).dot(&n);
            for growth in carried.growth(&n) {
                let bound = growth.speed * t + 0.5 * growth.acceleration * t * t;
                prop_assert!(travel <= bound + 1e-12, "{travel} beyond {bound} after {t}");
            }
            let v = velocity(from + t);
            prop_assert!(v.norm() <= speed + 1e-6 && v.dot(&n) <= along + 1e-6, "{v} {t}");
        }
    }
}
