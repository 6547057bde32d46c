//! What must not change a distance, and what may change it by a tolerance.

use bumper::geometry::distance::RELATIVE_ERROR;
use bumper::geometry::{Point, Pose};
use bumper::tree::nearest::{Clearance, Tolerance};
use bumper::tree::{TreeImage, TreeKind};
use proptest::prelude::*;

use super::{Random, images, mapped, mesh, smallest};

fn config() -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(40) }
}

/// Of this many metres, of what the meshes and poses here reach.
const ERROR: f64 = 64.0 * RELATIVE_ERROR;

proptest! {
    #![proptest_config(config())]

    #[test]
    fn distance_is_the_same_from_both_sides(seed in any::<u64>(), away in 0.0..4.0) {
        let mut random = Random::new(seed);
        let (a, b) = (mesh(&random.soup(14)), random.soup(10));
        let pose = random.pose(away);
        let placed = mesh(&mapped(&b, |p| pose.apply(p)));
        let b = mesh(&b);
        let mut clearance = Clearance::default();
        let mut ask = |meshes, pose| {
            smallest(&mut clearance, &images(meshes, TreeKind::Wide), pose).nearest
        };
        let there = ask([&a, &b], &pose);
        let at_rest = ask([&a, &placed], &Pose::IDENTITY);
        prop_assert_eq!(there, at_rest);
        let back = ask([&placed, &a], &Pose::IDENTITY);
        prop_assert!((back.distance_m - there.distance_m).abs() <= ERROR);
    }

    #[test]
    fn distance_is_the_same_wherever_both_are_moved(seed in any::<u64>(), away in 0.0..4.0) {
        let mut random = Random::new(seed);
        let (a, b) = (random.soup(14), random.soup(10));
        let (pose, motion) = (random.pose(away), random.pose(2.0));
        let soups = [a, mapped(&b, |p| pose.apply(p))];
        let moved = soups.each_ref().map(|soup| mesh(&mapped(soup, |p| motion.apply(p))));
        let still = soups.each_ref().map(|soup| mesh(soup));
        let mut clearance = Clearance::default();
        let mut ask = |meshes| {
            smallest(&mut clearance, &images(meshes, TreeKind::Wide), &Pose::IDENTITY).nearest
        };
        let here = ask(still.each_ref());
        let there = ask(moved.each_ref());
        prop_assert!((here.distance_m - there.distance_m).abs() <= ERROR, "{here:?} {there:?}");
    }

    #[test]
    fn witness_points_are_as_far_apart_as_is_reported(seed in any::<u64>(), away in 0.0..4.0) {
        let mut random = Random::new(seed);
        let meshes = [mesh(&random.soup(9)), mesh(&random.soup(12))];
        let images = images(meshes.each_ref(), TreeKind::Wide);
        let near = smallest(&mut Clearance::default(), &images, &random.pose(away)).nearest;
        let [p, q] = near.points;
        let length = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
        prop_assert!((length - near.distance_m).abs() <= 1e-13, "{near:?}");
    }

    #[test]
    fn tolerance_is_kept(seed in any::<u64>(), away in 0.0..4.0, parts in [0..3_u32, 0..3_u32]) {
        let mut random = Random::new(seed);
        let meshes = [mesh(&random.soup(30)), mesh(&random.soup(30))];
        let pose = random.pose(away);
        let tolerance =
            Tolerance::new([0.0, 0.01, 0.5][parts[0] as usize], [0.0, 0.1, 0.9][parts[1] as usize])
                .unwrap();
        for kind in TreeKind::ALL {
            let images = images(meshes.each_ref(), kind);
            let [a, b] = images.each_ref().map(TreeImage::view);
            let mut clearance = Clearance::default();
            let exact = smallest(&mut clearance, &images, &pose).nearest.distance_m;
            let found = clearance.smallest(&a, &b, &pose, tolerance).unwrap();
            let reported = found.nearest.distance_m;
            prop_assert!(exact <= reported && reported <= exact + tolerance.at(reported) + ERROR);
            prop_assert!(found.lower_bound_m <= exact);
            prop_assert!(found.lower_bound_m >= reported - tolerance.at(reported) - ERROR);
        }
    }

    #[test]
    fn translation_away_from_a_plane_between_adds_to_the_distance(
        seed in any::<u64>(), by in 0.0..100.0,
    ) {
        let mut random = Random::new(seed);
        let above = |p: Point| [p[0], p[1], p[2].abs() + 2.5];
        let below = |p: Point| [p[0], p[1], -p[2].abs()];
        let (a, b) = (mapped(&random.soup(12), below), mapped(&random.soup(12), above));
        let images = images([&mesh(&a), &mesh(&b)], TreeKind::Wide);
        let mut clearance = Clearance::default();
        let mut at = |z: f64| {
            let pose = Pose { translation: [0.0, 0.0, z], ..Pose::IDENTITY };
            smallest(&mut clearance, &images, &pose).nearest.distance_m
        };
        let (before, after) = (at(0.0), at(by));
        prop_assert!(before > 0.0 && after >= before - ERROR && after <= before + by + 1e-12);
    }
}
