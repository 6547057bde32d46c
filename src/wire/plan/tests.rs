use proptest::option;
use proptest::prelude::*;

use super::*;
use crate::effects::clearance::ClearanceOptions;
use crate::effects::crush::{CrushOptions, Stiffness};
use crate::effects::motion::{Axes, BodyMotion, MotionOptions, PartTree};
use crate::effects::penetration::{Direction, Effort, PenetrationOptions};
use crate::effects::response::{Inertia, ResponseBody, ResponseOptions};
use crate::effects::{Ranges, Step};
use crate::geometry::Point;
use crate::geometry::motion::{
    Horizon, Motion, MotionValues, PartMotion, PartMotionValues, TurnValues,
};
use crate::tree::{advance, nearest};

fn message() -> PlanMessage {
    let ranges = |first, last| Ranges::new(vec![[first, last]]).unwrap();
    let plan = Plan { ignore: vec![[ranges(0, 3), ranges(7, 9)]], steps: vec![Step::Segments] };
    PlanMessage { plan, parts: vec![] }
}

#[test]
fn a_plan_is_read_as_it_was_written() {
    assert_eq!(PlanMessage::parse(&message().to_bytes()), Ok(message()));
}

fn any_finite() -> impl Strategy<Value = f64> {
    use prop::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO
}

fn positive() -> impl Strategy<Value = f64> {
    any_finite().prop_map(f64::abs).prop_filter("above 0", |x| *x > 0.0)
}

fn any_point() -> impl Strategy<Value = Point> {
    prop::array::uniform3(any_finite())
}

/// Of unit length but for rounding.
fn unit() -> impl Strategy<Value = Point> {
    let point = prop::array::uniform3(-1.0..1.0_f64);
    point.prop_filter_map("too short", |p| {
        let length = p.map(|c| c * c).iter().sum::<f64>().sqrt();
        (length > 0.01).then(|| p.map(|c| c / length))
    })
}

fn any_ranges() -> impl Strategy<Value = Ranges> {
    prop::collection::btree_set(any::<u32>(), 2..12).prop_map(|ends| {
        let ends: Vec<u32> = ends.into_iter().collect();
        let ranges = ends.as_chunks::<2>().0.to_vec();
        Ranges::new(ranges).unwrap()
    })
}

fn any_motion() -> impl Strategy<Value = BodyMotion> {
    let axes = prop_oneof![Just(Axes::Body), Just(Axes::World)];
    (prop::array::uniform5(any_point()), axes).prop_map(|(points, axes)| {
        let [velocity_m_s, acceleration_m_s2, spin_rad_s, spin_acceleration_rad_s2, cg_m] = points;
        let values = MotionValues {
            velocity_m_s,
            acceleration_m_s2,
            spin_rad_s,
            spin_acceleration_rad_s2,
            cg_m,
        };
        BodyMotion { motion: Motion::new(values).unwrap(), axes }
    })
}

fn any_part() -> impl Strategy<Value = PartTree> {
    let turn = (any_point(), unit(), any_finite(), any_finite()).prop_map(
        |(point_m, axis, rate_rad_s, acceleration_rad_s2)| TurnValues {
            point_m,
            axis,
            rate_rad_s,
            acceleration_rad_s2,
        },
    );
    (any_ranges(), option::of(turn), any_point(), any_point()).prop_map(
        |(triangles, turn, velocity_m_s, acceleration_m_s2)| {
            let values = PartMotionValues { turn, velocity_m_s, acceleration_m_s2 };
            PartTree { triangles, motion: PartMotion::new(values).unwrap() }
        },
    )
}

/// Of masses at the ends of three rods along axes that are turned about one of them.
fn any_inertia() -> impl Strategy<Value = Inertia> {
    let moment = 1e-3..1e6_f64;
    (1e-3..1e6_f64, prop::array::uniform3(moment), 0.0..7.0_f64).prop_map(|(mass, rods, angle)| {
        let [a, b, c] = rods;
        let [x, y, z] = [b + c, a + c, a + b];
        let (sin, cos) = angle.sin_cos();
        let across = (x - y) * sin * cos;
        let turned = [
            [x * cos * cos + y * sin * sin, across, 0.0],
            [across, x * sin * sin + y * cos * cos, 0.0],
            [0.0, 0.0, z],
        ];
        Inertia::new(mass, turned).unwrap()
    })
}

fn any_body() -> impl Strategy<Value = ResponseBody> {
    (any_inertia(), any_motion()).prop_map(|(inertia, motion)| ResponseBody { inertia, motion })
}

fn any_clearance() -> impl Strategy<Value = Step> {
    (any_finite(), 0.0..1.0_f64, option::of(any_finite())).prop_map(|(metres, relative, margin)| {
        let tolerance = nearest::Tolerance::new(metres.abs(), relative).unwrap();
        Step::Clearance(ClearanceOptions { tolerance, margin_m: margin.map(f64::abs) })
    })
}

fn any_penetration() -> impl Strategy<Value = Step> {
    let effort = any::<u32>().prop_map(|directions| Effort { directions });
    (option::of(unit()), option::of(effort)).prop_map(|(direction, least)| {
        let direction = direction.map(|unit| Direction::new(unit).unwrap());
        Step::Penetration(PenetrationOptions { direction, least })
    })
}

fn any_motion_step() -> impl Strategy<Value = Step> {
    let parts = || prop::collection::vec(any_part(), 0..3);
    let bodies = prop::array::uniform2(any_motion());
    let times = (positive(), positive(), option::of(positive()));
    (times, bodies, [parts(), parts()]).prop_map(|((seconds, metres, fine), bodies, parts)| {
        Step::Motion(Box::new(MotionOptions {
            horizon: Horizon::new(seconds).unwrap(),
            tolerance: advance::Tolerance::new(metres).unwrap(),
            resolution: fine.map(|seconds| advance::Resolution::new(seconds).unwrap()),
            bodies,
            locate: fine.is_some(),
            parts,
        }))
    })
}

fn any_response() -> impl Strategy<Value = Step> {
    (0.0..=1.0_f64, positive(), prop::array::uniform2(any_body())).prop_map(
        |(restitution, friction, bodies)| {
            Step::Response(Box::new(ResponseOptions { restitution, friction, bodies }))
        },
    )
}

fn any_crush() -> impl Strategy<Value = Step> {
    let stiffness = (positive(), positive()).prop_map(|(a, b)| Stiffness::new(a, b).unwrap());
    let bodies = prop::array::uniform2(any_body());
    let zone = (positive(), prop::option::of(positive()), positive());
    (prop::array::uniform2(stiffness), zone, bodies).prop_map(
        |(stiffness, (width_m, height_m, taper_m), bodies)| {
            let options = CrushOptions { stiffness, width_m, height_m, taper_m, bodies };
            Step::Crush(Box::new(options))
        },
    )
}

fn any_plan() -> impl Strategy<Value = PlanMessage> {
    let simple = prop_oneof![Just(Step::Segments), Just(Step::Containment), Just(Step::Volume)];
    let step = prop_oneof![
        simple,
        any_clearance(),
        any_penetration(),
        any_motion_step(),
        any_response(),
        any_crush()
    ];
    let ignore = prop::collection::vec([any_ranges(), any_ranges()], 0..3);
    let steps = prop::collection::vec(step, 0..8);
    (ignore, steps, any::<u32>()).prop_map(|(ignore, steps, first)| {
        let plan = Plan { ignore, steps };
        let parts = (0..plan.part_count() as u32).map(|at| first.wrapping_add(at)).collect();
        PlanMessage { plan, parts }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Their texts tell apart what is equal but not the same: 0 and -0.
    #[test]
    fn any_plan_is_read_bit_for_bit_as_it_was_written(message in any_plan()) {
        let bytes = message.to_bytes();
        let read = PlanMessage::parse(&bytes).unwrap();
        prop_assert_eq!(format!("{:?}", &read), format!("{:?}", &message));
        prop_assert_eq!(read.to_bytes(), bytes);
    }

    #[test]
    fn a_plan_with_other_trees_than_it_needs_is_refused(mut message in any_plan()) {
        message.parts.push(7);
        prop_assert!(matches!(PlanMessage::parse(&message.to_bytes()), Err(WireError::Plan(_))));
    }

    #[test]
    fn damaged_plans_are_read_or_refused(at in 0_usize..500, byte: u8, length in 0_usize..500) {
        let mut bytes = message().to_bytes();
        let count = bytes.len();
        bytes[at % count] = byte;
        let _ = PlanMessage::parse(&bytes[..length.min(count)]);
    }
}
