//! Random motions against all pairs of triangles at many times, and what the search says of itself.

use bumper::geometry::distance::triangle_distance;
use bumper::tree::advance::AdvanceError;
use proptest::prelude::*;

use super::*;

fn least_distance(a: &[Triangle], b: &[Triangle]) -> f64 {
    let pairs = a.iter().flat_map(|s| b.iter().map(move |t| triangle_distance(s, t).distance));
    pairs.fold(f64::INFINITY, f64::min)
}

fn soup() -> impl Strategy<Value = Vec<Triangle>> {
    let triangle = (prop::array::uniform3(-1.0..1.0_f64), prop::array::uniform9(-0.3..0.3_f64));
    let triangle = triangle
        .prop_map(|(middle, by)| [0, 3, 6].map(|at| [0, 1, 2].map(|k| middle[k] + by[at + k])));
    prop::collection::vec(triangle, 1..12)
}

fn motions() -> impl Strategy<Value = Motion> {
    let vector = |most: f64| prop::array::uniform3(-most..most);
    (vector(3.0), vector(4.0), vector(4.0), vector(3.0), vector(0.5)).prop_map(
        |(velocity_m_s, acceleration_m_s2, spin_rad_s, spin_acceleration_rad_s2, cg_m)| {
            motion(MotionValues {
                velocity_m_s,
                acceleration_m_s2,
                spin_rad_s,
                spin_acceleration_rad_s2,
                cg_m,
            })
        },
    )
}

fn wheels() -> impl Strategy<Value = PartMotion> {
    (prop::array::uniform3(-0.5..0.5_f64), -9.0..9.0_f64).prop_map(|(point_m, rate_rad_s)| {
        let axis = [0.6, 0.0, -0.8];
        turning(TurnValues { point_m, axis, rate_rad_s, acceleration_rad_s2: 1.0 })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn nothing_touches_before_the_impact_and_something_is_as_near_as_it_says_then(
        meshes in [soup(), soup()],
        motions in [motions(), motions()],
        wheel in prop::option::of(wheels()),
        offset in prop::array::uniform3(-4.0..4.0_f64),
    ) {
        let [first, second] = meshes;
        let fixed = Traveller::new(&first, at([0.0; 3]), motions[0]);
        // Roughly towards the other, so that about half of them meet.
        let values = *motions[1].values();
        let velocity_m_s = [0, 1, 2].map(|k| 0.5 * values.velocity_m_s[k] - 1.5 * offset[k]);
        let coming = motion(MotionValues { velocity_m_s, ..values });
        let moving = match wheel {
            Some(wheel) => Traveller::part(&second, at(offset), coming, wheel),
            None => Traveller::new(&second, at(offset), coming),
        };
        let outcome = first_impact(
            std::slice::from_ref(&fixed),
            std::slice::from_ref(&moving),
            1.0,
        );
        let until = match outcome {
            Outcome::Apart => 1.0,
            Outcome::Impact(impact) => impact.time_s,
            Outcome::Undecided { .. } => panic!("{outcome:?}"),
        };
        const SAMPLES: u32 = 60;
        let times = (0..SAMPLES).map(|sample| until * f64::from(sample) / f64::from(SAMPLES));
        // Of those that touch at the start, there is none before.
        for time in times.filter(|&time| time < until) {
            let distance = least_distance(&fixed.at(time), &moving.at(time));
            prop_assert!(distance > 0.0, "they touch at {time}, before {until}");
        }
        let distance = least_distance(&fixed.at(until), &moving.at(until));
        match outcome {
            Outcome::Impact(impact) => {
                prop_assert!(distance <= impact.distance_m && impact.distance_m <= TOLERANCE);
                let [a, b] = impact.pair.map(|id| id as usize);
                let pair = [fixed.at(until)[a], moving.at(until)[b]];
                let of_pair = triangle_distance(&pair[0], &pair[1]).distance;
                prop_assert!((of_pair - impact.distance_m).abs() < 1e-12);
                let [p, q] = impact.points;
                let apart = [0, 1, 2].map(|k| q[k] - p[k]).iter().map(|c| c * c).sum::<f64>().sqrt();
                prop_assert!((apart - impact.distance_m).abs() < 1e-12);
            }
            _ => prop_assert!(distance > 0.0),
        }
    }
}

fn with_cubes<T>(start: Point, speed: Motion, query: impl FnOnce([&[Moving<'_>]; 2]) -> T) -> T {
    let fixed = [Traveller::at_rest(&cube())];
    let moving = [Traveller::new(&cube(), at(start), speed)];
    search([&fixed, &moving], [TreeKind::Wide; 2], query)
}

fn tolerance(metres: f64) -> Tolerance {
    Tolerance::new(metres).unwrap()
}

#[test]
fn what_passes_at_a_distance_costs_one_bound() {
    with_cubes([-50.0, 2.0, 0.0], along_x(100.0, 0.0), |[fixed, moving]| {
        let mut advancement = Advancement::new(tolerance(TOLERANCE));
        let horizon = Horizon::new(1.0).unwrap();
        let outcome = advancement.first_impact(fixed, moving, horizon).unwrap();
        assert_eq!(outcome, Outcome::Apart);
        let work = advancement.work();
        assert_eq!((work.swept_apart, work.bounds, work.distances), (1, 1, 0));
    });
}

#[test]
fn a_search_that_has_to_end_says_only_what_it_knows() {
    with_cubes([-10.0, 0.3, 0.3], along_x(1.0, 0.0), |[fixed, moving]| {
        let horizon = Horizon::new(20.0).unwrap();
        let mut ended = 0;
        for most in 1..400 {
            let mut advancement = Advancement::with_most(tolerance(TOLERANCE), most);
            match advancement.first_impact(fixed, moving, horizon).unwrap() {
                Outcome::Undecided { earliest_s } => {
                    assert!((0.0..=9.0).contains(&earliest_s), "{earliest_s}");
                    ended += 1;
                }
                Outcome::Impact(impact) => assert_time(impact.time_s, 9.0, 1.0),
                Outcome::Apart => panic!("they touch"),
            }
        }
        assert!(ended > 0 && ended < 399, "{ended}");
    });
}

#[test]
fn what_is_no_tolerance_is_refused() {
    for metres in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
        assert!(matches!(Tolerance::new(metres), Err(AdvanceError::Tolerance(_))));
    }
}

#[test]
fn a_motion_out_of_range_names_its_side_and_tree() {
    with_cubes([-10.0, 0.0, 0.0], along_x(1e80, 0.0), |[fixed, moving]| {
        let mut advancement = Advancement::new(tolerance(TOLERANCE));
        let error = advancement.first_impact(fixed, moving, Horizon::new(1.0).unwrap());
        let text = error.unwrap_err().to_string();
        assert!(text.starts_with("tree 0 of the moving side: within 1 s"), "{text}");
    });
}

#[test]
fn the_finest_tolerance_and_extreme_sizes_come_to_an_end() {
    let horizon = Horizon::new(1.0).unwrap();
    for scale in [1e-60, 1e-4, 1.0, 1e9, 1e60] {
        let gap = 1e-3 * scale;
        with_cubes([-1.0 - gap, 0.0, 0.0], along_x(2.0 * gap, 0.0), |[fixed, moving]| {
            let mut advancement = Advancement::new(tolerance(f64::MIN_POSITIVE));
            match advancement.first_impact(fixed, moving, horizon).unwrap() {
                Outcome::Impact(impact) => {
                    let time = if scale < 1e-9 { 0.0 } else { 0.5 };
                    assert!((impact.time_s - time).abs() < 1e-3, "{scale:e}: {impact:?}");
                }
                other => panic!("{scale:e}: {other:?}"),
            }
            assert!(advancement.work().bounds < 100_000, "{scale:e}");
        });
    }
}

#[test]
fn far_from_the_origin_the_time_is_the_same() {
    let start = Traveller::new(&cube(), at([1e6 - 2.0, 1e6, 0.0]), along_x(2.0, 0.0));
    let fixed = Traveller::new(&cube(), at([1e6, 1e6, 0.0]), Motion::default());
    let found = impact(fixed, start, 1.0);
    assert!((found.time_s - 0.5).abs() < 1e-5, "{found:?}");
}
