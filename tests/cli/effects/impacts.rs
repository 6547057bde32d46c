//! Impacts whose outcome momentum and restitution alone tell, and what they crush.

use super::*;

const M1: f64 = 1000.0;
const M2: f64 = 600.0;
const RESTITUTION: f64 = 0.2;
const SPEED: f64 = 10.0;

/// A cube of 1 m that stands, and a body with a tip towards it, so that there is one point where both
/// can meet, on the line of both centres.
fn central(place: &Place, more: &str) -> String {
    place.write("fixed.obj", &cube(0.5));
    let axes = "v 0.5 0 0\nv -0.5 0 0\nv 0 0.5 0\nv 0 -0.5 0\nv 0 0 0.5\nv 0 0 -0.5\n";
    let faces = "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    place.write("moving.obj", &format!("{axes}{faces}"));
    // The second one looks the other way, and drives backwards.
    place.write("p.csv", &format!("{HEADER}1,0,0,0,3,0,0\n0,0,0,1,-3,0,0\n1,0,0,0,3,4,0\n"));
    let text = format!(
        "version = 1\nscenarios.poses = 'p.csv'\nmotion.duration_s = 1.0\n{more}\n\
         [fixed]\nmesh = 'fixed.obj'\nmass_kg = {M1}\ninertia_kg_m2 = [200.0, 200.0, 200.0]\n\
         stiffness = {{ a_n_m = 4e4, b_n_m2 = 3e5 }}\n\
         [moving]\nmesh = 'moving.obj'\nmass_kg = {M2}\ninertia_kg_m2 = [90.0, 90.0, 90.0]\n\
         velocity_m_s = [{}, 0.0, 0.0]\nstiffness = {{ a_n_m = 5e4, b_n_m2 = 6e5 }}\n",
        -SPEED
    );
    place.write("scene.toml", &text)
}

#[test]
fn a_central_impact_is_that_of_the_textbook() {
    let place = Place::new();
    for kind in ["wide", "obb", "aabb"] {
        let more =
            format!("[tree]\nkind = '{kind}'\n[effects.response]\nrestitution = {RESTITUTION}");
        let run = Run::of(&place, &central(&place, &more), &[]);
        assert_eq!(run.cells("motion"), ["impact", "impact", "apart"]);
        assert_eq!(run.cells("impact"), ["full", "full", ""]);
        // Velocities before: 0 and `along`.
        for (scenario, along) in [(0, -SPEED), (1, SPEED)] {
            let fixed = -along * -(1.0 + RESTITUTION) / (1.0 + M1 / M2);
            let moving = -along * (1.0 + RESTITUTION) / (1.0 + M2 / M1);
            let delta = |body: &str| {
                ["x", "y", "z"].map(|k| run.number(&format!("{body}_delta_v_{k}_m_s"), scenario))
            };
            for (found, expected) in [(delta("fixed"), fixed), (delta("moving"), moving)] {
                near(found[0], expected, 1e-9 * SPEED);
                near(found[1], 0.0, 1e-9 * SPEED);
                near(found[2], 0.0, 1e-9 * SPEED);
            }
            near(run.number("impulse_x_n_s", scenario), M1 * fixed, 1e-9 * M1 * SPEED);
            near(run.number("closing_speed_m_s", scenario), SPEED, 1e-9);
            let reduced = M1 * M2 / (M1 + M2);
            let loss = 0.5 * reduced * SPEED * SPEED * (1.0 - RESTITUTION * RESTITUTION);
            near(run.number("energy_loss_j", scenario), loss, 1e-9 * loss);
            for axis in ["x", "y", "z"] {
                near(run.number(&format!("moving_delta_spin_{axis}_rad_s"), scenario), 0.0, 1e-8);
            }
            assert_eq!(run.cells("energy_rises")[scenario], "0");
        }
        // It is struck at its tip: from behind where it drives backwards, from ahead of the other.
        let pdof = |body: &str, scenario| run.number(&format!("{body}_pdof_deg"), scenario);
        near(pdof("fixed", 0), 0.0, 1e-6);
        near(pdof("moving", 0).abs(), 180.0, 1e-6);
        near(pdof("fixed", 1).abs(), 180.0, 1e-6);
        near(pdof("moving", 1).abs(), 180.0, 1e-6);
    }
}

#[test]
fn masses_and_a_velocity_call_for_a_response_by_themselves() {
    let place = Place::new();
    let asked = Run::of(&place, &central(&place, "effects.response = true"), &[]);
    let described = Run::of(&place, &central(&place, ""), &[]);
    assert_eq!(described.csv, asked.csv);
    assert_eq!(described.effects(), [("contacts", 3), ("motion", 3), ("response", 2)]);
}

/// As far as one may be off in a file of poses.
#[test]
fn a_quaternion_of_six_digits_is_good_enough_for_an_impact() {
    let place = Place::new();
    let scene = central(&place, "effects.response = true");
    place.write("p.csv", &format!("{HEADER}0.999996,0,0,0,3,0,0\n1.000004,0,0,0,3,0,0\n"));
    let run = Run::of(&place, &scene, &[]);
    assert_eq!(run.cells("impact"), ["full"; 2]);
}

/// The impact is at the start where both overlap, whether or not there is a motion to find another.
#[test]
fn what_overlaps_collides_without_a_motion() {
    let place = Place::new();
    let scene = central(&place, "effects.response = { restitution = 0.0 }");
    place.write("p.csv", &moved_to(&[[0.9, 0.0, 0.0], [3.0, 0.0, 0.0]]));
    let with = Run::of(&place, &scene, &[]);
    let text = fs::read_to_string(&scene).unwrap().replace("motion.duration_s = 1.0\n", "");
    let without = Run::of(&place, &place.write("still.toml", &text), &[]);
    assert_eq!(without.effects(), [("contacts", 2), ("response", 1)]);
    assert_eq!(with.cells("motion"), ["in_contact", "impact"]);
    for run in [&with, &without] {
        // The tip goes through the face: a square of contact in it, in its middle.
        let normal = ["contact_normal_x", "contact_normal_y", "contact_normal_z"];
        assert_eq!(run.vector(normal, 0).map(f64::round), [1.0, 0.0, 0.0]);
        let point = run.vector(["contact_x_m", "contact_y_m", "contact_z_m"], 0);
        point
            .iter()
            .zip([0.5, 0.0, 0.0])
            .for_each(|(found, expected)| near(*found, expected, 1e-12));
        near(run.number("moving_delta_v_x_m_s", 0), SPEED / (1.0 + M2 / M1), 1e-9 * SPEED);
    }
    assert_eq!(without.cells("impact")[1], "", "nothing says that they meet");
}

#[test]
fn both_crushed_vehicles_take_the_energy_that_is_lost() {
    let place = Place::new();
    let run = Run::of(&place, &central(&place, "effects.crush = { width_m = 1.2 }"), &[]);
    for scenario in [0, 1] {
        let of = |name: &str| run.number(name, scenario);
        let (fixed, moving) = (of("fixed_crush_energy_j"), of("moving_crush_energy_j"));
        near(fixed + moving, of("energy_loss_j"), 1e-9 * of("energy_loss_j"));
        near(of("fixed_ees_m_s"), (2.0 * fixed / M1).sqrt(), 1e-9);
        near(of("moving_ees_m_s"), (2.0 * moving / M2).sqrt(), 1e-9);
        // G + A C + B C^2 / 2 over the width, with G = A^2 / 2 B.
        for (depth, a, b, energy) in
            [(of("fixed_crush_m"), 4e4, 3e5, fixed), (of("moving_crush_m"), 5e4, 6e5, moving)]
        {
            let per_width = a * a / (2.0 * b) + a * depth + 0.5 * b * depth * depth;
            near(1.2 * per_width, energy, 1e-9 * energy);
        }
        // The same force on both.
        near(4e4 + 3e5 * of("fixed_crush_m"), 5e4 + 6e5 * of("moving_crush_m"), 1e-4);
    }
    assert_eq!(run.cells("fixed_crush_m")[2], "", "they pass each other");
}

/// Two cubes of 1 m, one at rest.
fn cubes(place: &Place, poses: &[[f64; 3]], more: &str) -> String {
    place.write("cube.obj", &cube(0.5));
    place.write("p.csv", &moved_to(poses));
    let body = "mesh = 'cube.obj'\nmass_kg = 500.0\ninertia_kg_m2 = [90.0, 90.0, 90.0]\n\
                stiffness = { a_n_m = 1e4, b_n_m2 = 1e5 }";
    let text = format!(
        "version = 1\nscenarios.poses = 'p.csv'\n{more}\n[fixed]\n{body}\n[moving]\n{body}\n"
    );
    place.write("scene.toml", &text)
}

/// Whichever of the triangles that meet flat is found first.
#[test]
fn faces_that_meet_flat_push_in_the_middle_of_what_meets() {
    let place = Place::new();
    for kind in ["wide", "obb", "aabb"] {
        let more = format!("tree.kind = '{kind}'\nmotion.duration_s = 1.0");
        // Straight on; and half a face beside, so that the middle of what meets is at y = 0.25.
        let scene = cubes(&place, &[[3.0, 0.0, 0.0], [3.0, 0.5, 0.0]], &more);
        let scene = place.write(
            "s.toml",
            &(fs::read_to_string(scene).unwrap() + "velocity_m_s = [-10.0, 0.0, 0.0]\n"),
        );
        let run = Run::of(&place, &scene, &[]);
        for axis in ["x", "y", "z"] {
            near(run.number(&format!("moving_delta_spin_{axis}_rad_s"), 0), 0.0, 1e-9);
        }
        for (scenario, y) in [(0, 0.0), (1, 0.25)] {
            let at = run.vector(["contact_x_m", "contact_y_m", "contact_z_m"], scenario);
            near(at[0], 0.5, 1e-3);
            near(at[1], y, 1e-9);
            near(at[2], 0.0, 1e-9);
        }
        assert!(run.number("moving_delta_spin_z_rad_s", 1).abs() > 0.1);
    }
}

#[test]
fn bodies_that_overlap_and_drive_apart_have_no_impact() {
    let place = Place::new();
    let poses = [[0.95, 0.03, 0.02], [-0.95, 0.03, 0.02]];
    let scene = cubes(&place, &poses, "");
    let text = fs::read_to_string(scene).unwrap() + "velocity_m_s = [10.0, 0.0, 0.0]\n";
    let run = Run::of(&place, &place.write("s.toml", &text), &[]);
    assert_eq!(run.cells("impact")[0], "parting");
    assert!(run.number("closing_speed_m_s", 0) < 0.0);
    assert_ne!(run.cells("impact")[1], "parting");
    assert!(run.number("closing_speed_m_s", 1) > 5.0);
}

/// The crash of the first scenario makes both shorter, so that what would touch after it does not.
#[test]
fn a_crash_deforms_what_comes_after_it() {
    let place = Place::new();
    let poses = [[2.0, 0.0, 0.0], [0.98, 0.0, 0.0], [0.98, 0.0, 0.0]];
    let crush = "motion.duration_s = 1.0\n[effects.crush]\nwidth_m = 1.5\n";
    let scene = |more: &str| {
        let text = fs::read_to_string(cubes(&place, &poses, &format!("{crush}{more}"))).unwrap();
        place.write("s.toml", &(text + "velocity_m_s = [-10.0, 0.0, 0.0]\n"))
    };
    let whole = Run::of(&place, &scene(""), &[]);
    assert_eq!(whole.cells("colliding"), ["0", "1", "1"]);
    for workers in ["1", "2"] {
        let out = place.text("deformed");
        let scene = scene("deform_after = 0\n");
        let output = place.run(&["run", &scene, "--out", &out, "--workers", workers]);
        assert!(output.status.success(), "{}", stderr(&output));
        let rows = fs::read_to_string(place.path("deformed/scenarios.csv")).unwrap();
        let colliding: Vec<_> = rows.lines().skip(1).map(|row| row.split(',').nth(1)).collect();
        assert_eq!(colliding, [Some("0"); 3]);
        let depths =
            [0, 1].map(|side: usize| whole.number(["fixed_crush_m", "moving_crush_m"][side], 0));
        for (name, depth) in [("fixed", depths[0]), ("moving", depths[1])] {
            let path = place.text(&format!("deformed/{name}_deformed.ply"));
            let source: bumper::mesh::MeshSource = path.parse().unwrap();
            let mesh = source.load().unwrap();
            let along = mesh.vertices().iter().map(|v| v[0]);
            let (low, high) = along.fold((1.0_f64, -1.0_f64), |(a, b), x| (a.min(x), b.max(x)));
            near(high - low, 1.0 - depth, 1e-9);
        }
    }
    let out = place.text("beyond");
    let output = place.run(&["run", &scene("deform_after = 3\n"), "--out", &out]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("effects.crush.deform_after"), "{}", stderr(&output));
}
