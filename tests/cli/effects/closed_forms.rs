//! Boxes, of which everything is known: how near, how deep, how much, and when.

use super::*;

const KINDS: [&str; 3] = ["wide", "obb", "aabb"];

/// A cube of half edges 0.5 and another mesh, both in files, in the given poses.
fn scene(place: &Place, moving: &str, poses: &str, more: &str) -> String {
    place.write("fixed.obj", &cube(0.5));
    place.write("moving.obj", moving);
    place.write("p.csv", poses);
    let text = format!(
        "version = 1\nfixed.mesh = 'fixed.obj'\nmoving.mesh = 'moving.obj'\n\
         scenarios.poses = 'p.csv'\n{more}\n"
    );
    place.write("scene.toml", &text)
}

fn each_kind(more: &str) -> impl Iterator<Item = String> {
    KINDS.into_iter().map(move |kind| format!("tree.kind = '{kind}'\n{more}"))
}

#[test]
fn clearance_is_the_gap() {
    let place = Place::new();
    // At a face, at an edge, at a corner, and an edge turned to a face.
    let half = std::f64::consts::FRAC_PI_8;
    let turned = format!("{},0,0,{},3,0.1,0.2\n", half.cos(), half.sin());
    let poses = moved_to(&[[3.0, 0.2, 0.3], [3.0, 2.5, 0.0], [-2.0, 3.0, -4.0]]) + &turned;
    let expected = [2.0, 2.5, 14_f64.sqrt(), 2.5 - 0.5_f64.sqrt()];
    for more in each_kind("effects.clearance.margin_m = 2.25") {
        let run = Run::of(&place, &scene(&place, &cube(0.5), &poses, &more), &[]);
        for (scenario, expected) in expected.into_iter().enumerate() {
            near(run.number("clearance_m", scenario), expected, 1e-12);
            let bound = run.number("clearance_lower_bound_m", scenario);
            assert!(bound <= expected && bound > expected - 1e-9, "{bound}");
            let fixed = run
                .vector(["nearest_fixed_x_m", "nearest_fixed_y_m", "nearest_fixed_z_m"], scenario);
            let moving = run.vector(
                ["nearest_moving_x_m", "nearest_moving_y_m", "nearest_moving_z_m"],
                scenario,
            );
            let way: f64 = (0..3).map(|k| (fixed[k] - moving[k]).powi(2)).sum();
            near(way.sqrt(), expected, 1e-12);
        }
        // Both triangles of a face, those of faces around them that share an edge or a corner of it.
        let near: Vec<usize> = (0..4)
            .map(|n| {
                run.table("near_pairs").iter().filter(|row| row["scenario"] == n as f64).count()
            })
            .collect();
        assert!(near[0] >= 4 && near[1] == 0 && near[2] == 0 && near[3] >= 2, "{near:?}");
    }
}

#[test]
fn penetration_is_the_way_to_the_face() {
    let place = Place::new();
    let poses = moved_to(&[[0.8, 0.1, 0.05], [-0.3, 0.2, -0.4], [2.0, 0.0, 0.0]]);
    for more in each_kind("effects.penetration = { direction = [1.0, 0.0, 0.0], least = true }") {
        let run = Run::of(&place, &scene(&place, &cube(0.5), &poses, &more), &[]);
        for (scenario, (along, least)) in [(0.2, 0.2), (1.3, 0.6)].into_iter().enumerate() {
            near(run.number("penetration_depth_m", scenario), along, 1e-10);
            let free = run.number("penetration_free_at_m", scenario);
            assert!(free > along && free < along + 1e-9, "{free}");
            // An upper bound, found by search: of boxes it is the least.
            near(run.number("least_translation_m", scenario), least, 1e-9);
        }
        near(run.number("least_translation_z_m", 1), -0.6, 1e-9);
        assert_eq!(run.cells("penetration_depth_m")[2], "", "they are apart");
        assert!(run.effects().contains(&("penetration", 2)));
    }
}

#[test]
fn volume_is_that_of_the_box_in_common() {
    let place = Place::new();
    let poses = moved_to(&[[0.8, 0.1, 0.05], [-0.3, 0.2, -0.4], [2.0, 0.0, 0.0]]);
    for more in each_kind("effects.volume = true") {
        let run = Run::of(&place, &scene(&place, &cube(0.5), &poses, &more), &[]);
        for (scenario, expected) in [0.2 * 0.9 * 0.95, 0.7 * 0.8 * 0.6].into_iter().enumerate() {
            let error = run.number("overlap_volume_error_m3", scenario);
            assert!(error < 1e-12, "{error}");
            near(run.number("overlap_volume_m3", scenario), expected, error + 1e-15);
        }
        assert_eq!(run.cells("overlap_volume_m3")[2], "", "they are apart");
    }
}

#[test]
fn a_box_in_a_box_is_inside_and_not_apart() {
    let place = Place::new();
    let poses = moved_to(&[[0.3, 0.0, 0.1], [2.0, 0.0, 0.0], [0.45, 0.0, 0.0]]);
    let effects = "[effects]\ncontainment = true\nvolume = true\nclearance = true\n\
                   penetration = { direction = [1.0, 0.0, 0.0] }\n[motion]\nduration_s = 1.0";
    let moving = "moving.velocity_m_s = [1.0, 0.0, 0.0]\n";
    for more in each_kind(&format!("{moving}{effects}")) {
        let run = Run::of(&place, &scene(&place, &cube(0.1), &poses, &more), &[]);
        assert_eq!(run.cells("containment"), ["moving_in_fixed", "none", ""]);
        assert_eq!(run.cells("moving_parts_inside"), ["1", "0", ""]);
        assert_eq!(run.cells("fixed_parts_inside"), ["0", "0", ""]);
        assert_eq!(run.cells("colliding"), ["0", "0", "1"]);
        near(run.number("overlap_volume_m3", 0), 0.008, 1e-14);
        near(run.number("overlap_volume_m3", 2), 0.15 * 0.04, 1e-14);
        near(run.number("penetration_depth_m", 0), 0.3, 1e-10);
        near(run.number("penetration_depth_m", 2), 0.15, 1e-10);
        let clearance = run.numbers("clearance_m");
        assert!(clearance[2].is_none(), "they touch");
        near(clearance[0].unwrap(), 0.1, 1e-12);
        near(clearance[1].unwrap(), 1.4, 1e-12);
        assert_eq!(run.cells("motion"), ["", "apart", "in_contact"]);
    }
    // Of the larger one as the moving one.
    let more = "effects.containment = true";
    let run = Run::of(&place, &scene(&place, &cube(2.0), &moved_to(&[[0.0; 3]]), more), &[]);
    assert_eq!(run.cells("containment"), ["fixed_in_moving"]);
    assert_eq!(run.cells("fixed_parts_inside"), ["1"]);
}

/// A gap of 4 m closed by `2 t + 3 t^2 / 2`; one that is not reached; and one that both close.
#[test]
fn time_of_impact_is_the_root_of_the_quadratic() {
    const TOLERANCE: f64 = 1e-6;
    let place = Place::new();
    let poses = moved_to(&[[5.0, 0.3, 0.2], [5.0, 3.0, 0.0]]);
    let gap: f64 = 4.0;
    let cases = [
        (
            "moving.velocity_m_s = [-2.0, 0.0, 0.0]\nmoving.acceleration_m_s2 = [-3.0, 0.0, 0.0]",
            2.0,
            3.0,
        ),
        (
            "moving.velocity_m_s = [-6.0, 0.0, 0.0]\nmoving.acceleration_m_s2 = [4.0, 0.0, 0.0]",
            6.0,
            -4.0,
        ),
        (
            "moving.velocity_m_s = [-2.0, 0.0, 0.0]\nmoving.acceleration_m_s2 = [4.0, 0.0, 0.0]",
            2.0,
            -4.0,
        ),
        (
            "moving.velocity_m_s = [-1.0, 0.0, 0.0]\nfixed.acceleration_m_s2 = [0.5, 0.0, 0.0]",
            1.0,
            0.5,
        ),
    ];
    for (motion, speed, growth) in cases {
        let discriminant: f64 = speed * speed + 2.0 * growth * gap;
        let root = (discriminant > 0.0).then(|| (discriminant.sqrt() - speed) / growth);
        let at_root = discriminant.max(0.0).sqrt();
        let motion =
            format!("{motion}\nmotion = {{ duration_s = 3.0, tolerance_m = {TOLERANCE} }}");
        for more in each_kind(&motion) {
            let run = Run::of(&place, &scene(&place, &cube(0.5), &poses, &more), &[]);
            assert_eq!(run.cells("motion")[0], if root.is_some() { "impact" } else { "apart" });
            assert_eq!(run.cells("motion")[1], "apart", "it passes by");
            let Some(root) = root else { continue };
            let time = run.number("impact_time_s", 0);
            // Never late, and early by no more than the tolerance takes.
            let early = TOLERANCE / at_root.min(speed);
            assert!(time <= root && time >= root - early, "{time} is not {root}, {motion}");
            assert!(run.number("impact_distance_m", 0) <= TOLERANCE);
            let normal = ["impact_normal_x", "impact_normal_y", "impact_normal_z"];
            let normal = run.vector(normal, 0).into_iter().zip([1.0, 0.0, 0.0]);
            normal.for_each(|(found, expected)| near(found, expected, 1e-6));
        }
    }
}

/// A bar turns about the end of it until its corner meets a wall.
#[test]
fn what_turns_hits_at_the_known_angle() {
    const RATE: f64 = 3.0;
    let place = Place::new();
    place.write("wall.obj", &boxes(&[[[-5.0, 1.0, -1.0], [5.0, 2.0, 1.0]]]));
    // A hub below the bar, which does not turn with it.
    let bar = [[0.0, -0.05, -0.1], [2.0, 0.05, 0.1]];
    place.write("bar.obj", &boxes(&[[[-0.3, -0.3, -0.5], [0.3, 0.3, -0.2]], bar]));
    place.write("p.csv", &moved_to(&[[0.3, 0.0, 0.0]]));
    let part = format!(
        "[[moving.parts]]\nname = 'bar'\ntriangles = [[12, 23]]\n\
         motion.turn = {{ point_m = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], rate_rad_s = {RATE} }}"
    );
    let body = format!("[moving]\nmesh = 'bar.obj'\nspin_rad_s = [0.0, 0.0, {RATE}]\n");
    let still = "[moving]\nmesh = 'bar.obj'\n".to_owned();
    let (reach, ahead) = (2_f64.hypot(0.05), (0.05_f64).atan2(2.0));
    let angle = (1.0 / reach).asin();
    let root = (angle - ahead) / RATE;
    let early = 1e-6 / (RATE * reach * angle.cos());
    for moving in [still + &part, body] {
        for kind in KINDS {
            let text = format!(
                "version = 1\nfixed.mesh = 'wall.obj'\nscenarios.poses = 'p.csv'\n\
                 tree.kind = '{kind}'\nmotion = {{ duration_s = 1.0, tolerance_m = 1e-6 }}\n{moving}\n"
            );
            let run = Run::of(&place, &place.write("scene.toml", &text), &[]);
            let time = run.number("impact_time_s", 0);
            assert!(time <= root && time >= root - 1.1 * early, "{time} is not {root}");
            let triangle = run.number("impact_moving_triangle", 0);
            assert!(
                (12.0..24.0).contains(&triangle),
                "triangle {triangle} of the file is the bar's"
            );
            near(run.number("impact_x_m", 0), 0.3 + reach * angle.cos(), 1e-4);
        }
    }
}

/// Nothing touches, and yet they overlap: who asks for the volume or the way out gets both.
#[test]
fn a_box_in_a_box_has_a_volume_in_common_and_a_way_out_though_nobody_asks_for_containment() {
    let place = Place::new();
    let effects =
        "[effects]\nvolume = true\npenetration = { direction = [1.0, 0.0, 0.0] }\nclearance = true";
    let poses = moved_to(&[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    for more in each_kind(effects) {
        let run = Run::of(&place, &scene(&place, &cube(0.1), &poses, &more), &[]);
        assert_eq!(run.cells("containment"), ["moving_in_fixed", "moving_in_fixed", "none"]);
        for (scenario, depth, gap) in [(0, 0.6, 0.4), (1, 0.5, 0.3)] {
            near(run.number("overlap_volume_m3", scenario), 0.008, 1e-12);
            near(run.number("penetration_depth_m", scenario), depth, 1e-9);
            near(run.number("clearance_m", scenario), gap, 1e-12);
        }
        assert_eq!(run.cells("overlap_volume_m3")[2], "");
    }
}
