//! What a scene asks for and cannot have: an error that names the key, before anything is computed.

use super::*;

/// Two boxes that are described as everything but crush needs them, and with a part each.
const SCENE: &str = "version = 1
scenarios.poses = 'p.csv'
motion.duration_s = 1.0
[fixed]
mesh = 'box.obj'
mass_kg = 1000.0
inertia_kg_m2 = [200.0, 200.0, 200.0]
parts = [{ name = 'side', triangles = [[0, 1]] }]
[moving]
mesh = 'box.obj'
mass_kg = 600.0
inertia_kg_m2 = [90.0, 90.0, 90.0]
velocity_m_s = [-10.0, 0.0, 0.0]
parts = [{ name = 'top', triangles = [[2, 3]] }]
[effects]
containment = true
";
const MASS: &str = "mass_kg = 600.0";
const INERTIA: &str = "inertia_kg_m2 = [90.0, 90.0, 90.0]";
const VELOCITY: &str = "velocity_m_s = [-10.0, 0.0, 0.0]";
const DURATION: &str = "motion.duration_s = 1.0";
const PART: &str = "triangles = [[2, 3]]";
const LAST: &str = "containment = true";

fn place() -> Place {
    let place = Place::new();
    place.write("box.obj", &cube(0.5));
    // A lid is missing.
    let open = cube(0.5);
    place.write("open.obj", open.trim_end().rsplit_once("\nf").unwrap().0);
    place.write("p.csv", &moved_to(&[[3.0, 0.0, 0.0]]));
    place
}

/// The scene with one thing in it replaced.
fn refuses(place: &Place, part: &str, replacement: &str, arguments: &[&str], words: &[&str]) {
    assert!(SCENE.contains(part), "{part}");
    let scene = place.write("bad.toml", &SCENE.replacen(part, replacement, 1));
    let out = place.text("out");
    let run = ["run", &scene, "--workers", "1", "--no-cache", "--out", &out];
    let output = place.run(&[&run[..], arguments].concat());
    refused(&output, 2, words);
    assert!(!place.path("out/scenarios.csv").exists(), "nothing is computed");
}

#[test]
fn the_scene_that_the_others_are_made_of_is_accepted() {
    let place = place();
    let scene = place.write("good.toml", SCENE);
    let run = Run::of(&place, &scene, &[]);
    assert_eq!(run.cells("motion"), ["impact"]);
}

#[test]
fn values_that_cannot_be_are_refused_with_their_line_and_key() {
    let place = place();
    let lines = [
        (MASS, "mass_kg = 0.0", "bad.toml:11: `moving.mass_kg`: mass is 0 kg"),
        (MASS, "mass_kg = -5", "bad.toml:11: `moving.mass_kg`: mass is -5 kg"),
        (MASS, "mass_kg = nan", "bad.toml:11: `moving.mass_kg`: mass is NaN kg"),
        (MASS, "", "bad.toml:12: `moving.inertia_kg_m2`: comes with `moving.mass_kg`"),
        (INERTIA, "", "bad.toml:11: `moving.mass_kg`: comes with `moving.inertia_kg_m2`"),
        (
            INERTIA,
            "inertia_kg_m2 = [1.0, 1.0, 2.1]",
            "bad.toml:12: `moving.inertia_kg_m2`: the principal",
        ),
        (INERTIA, "inertia_kg_m2 = [1.0, 1.0, -1.0]", "all have to be positive"),
        (INERTIA, "inertia_kg_m2 = [1.0, 1.0, inf]", "no finite number"),
        (
            INERTIA,
            "inertia_kg_m2 = [[1.0, 0.5, 0.0], [0.4, 1.0, 0.0], [0.0, 0.0, 1.0]]",
            "not symmetric",
        ),
        (
            INERTIA,
            "inertia_kg_m2 = [1.0, 1.0]",
            "bad.toml:12: `moving.inertia_kg_m2`: three moments",
        ),
        (
            VELOCITY,
            "velocity_m_s = [nan, 0.0, 0.0]",
            "bad.toml:13: `moving.velocity_m_s`: velocity_m_s is NaN",
        ),
        (
            VELOCITY,
            "acceleration_m_s2 = [0.0, inf, 0.0]",
            "bad.toml:13: `moving.acceleration_m_s2`",
        ),
        (VELOCITY, "spin_rad_s = [0.0, 0.0, nan]", "bad.toml:13: `moving.spin_rad_s`"),
        (VELOCITY, "cg_m = [0.0, 0.0, nan]", "bad.toml:13: `moving.cg_m`"),
        (VELOCITY, "velocity_m_s = [1.0, 0.0]", "bad.toml:13: `moving.velocity_m_s`"),
        (VELOCITY, "axes = 'car'", "bad.toml:13: `moving.axes`: unknown variant"),
        (VELOCITY, "velocity = [1.0, 0.0, 0.0]", "did you mean `velocity_m_s`?"),
        (
            VELOCITY,
            "stiffness = { a_n_m = -1.0, b_n_m2 = 1.0 }",
            "bad.toml:13: `moving.stiffness.a_n_m`",
        ),
        (
            VELOCITY,
            "stiffness = { a_n_m = 1.0, b_n_m2 = 0.0 }",
            "bad.toml:13: `moving.stiffness.b_n_m2`",
        ),
        (DURATION, "motion.tolerance_m = 0.1", "bad.toml:3: `motion.duration_s`: is missing"),
        (DURATION, "motion.duration_s = -1.0", "bad.toml:3: `motion.duration_s`: duration_s is -1"),
        (DURATION, "motion.duration_s = 0", "bad.toml:3: `motion.duration_s`: duration_s is 0"),
        (
            DURATION,
            "motion = { duration_s = 1.0, tolerance_m = 0.0 }",
            "bad.toml:3: `motion.tolerance_m`",
        ),
        (
            DURATION,
            "motion = { duration_s = 1.0, tolerance_m = nan }",
            "bad.toml:3: `motion.tolerance_m`",
        ),
        (
            DURATION,
            "motion = { duration_s = 1.0, resolution_s = -1.0 }",
            "bad.toml:3: `motion.resolution_s`",
        ),
        (DURATION, "motion = { duration_s = 1.0, resolution_s = 1e-9 }", "below a ten-thousandth"),
        (PART, "triangles = [[3, 2]]", "bad.toml:14: `moving.parts.triangles`: [3, 2] is no range"),
        (PART, "triangles = []", "bad.toml:14: `moving.parts.triangles`: there is no range"),
        (PART, "triangles = [[0, 2], [2, 4]]", "bad.toml:14: `moving.parts.triangles`: [2, 4] has"),
        (PART, "triangles = [[-1, 2]]", "bad.toml:14: `moving.parts"),
        (
            PART,
            "triangles = [[2, 3]], motion.turn = { point_m = [0, 0, 0], axis = [0, 0, 2], rate_rad_s = 1 }",
            "bad.toml:14: `moving.parts.motion`: turn.axis has length 2",
        ),
        (
            "{ name = 'top', triangles = [[2, 3]] }",
            "{ name = 'top', triangles = [[2, 3]] }, { name = 'top', triangles = [[4, 5]] }",
            "bad.toml:14: `moving.parts.name`: 'top' names two parts",
        ),
        (
            "{ name = 'top', triangles = [[2, 3]] }",
            "{ name = 'top', triangles = [[2, 3]], motion.velocity_m_s = [1, 0, 0] }, \
             { name = 'other', triangles = [[3, 4]], motion.velocity_m_s = [2, 0, 0] }",
            "bad.toml:14: `moving.parts.triangles`: has triangles of another part that moves",
        ),
        (LAST, "clearence = true", "bad.toml:16: `effects`: unknown field `clearence`"),
        (LAST, "clearence = true", "did you mean `clearance`?"),
        (LAST, "clearance = 3", "bad.toml:16: `effects.clearance`"),
        (LAST, "clearance.margin = 3", "unknown field `margin`"),
        (LAST, "clearance.margin_m = -1.0", "bad.toml:16: `effects.clearance.margin_m`: is -1"),
        (LAST, "clearance.margin_m = nan", "bad.toml:16: `effects.clearance.margin_m`: is NaN"),
        (LAST, "clearance.tolerance_m = -1.0", "bad.toml:16: `effects.clearance.tolerance_m`"),
        (
            LAST,
            "clearance.tolerance_relative = 1.0",
            "bad.toml:16: `effects.clearance.tolerance_relative`",
        ),
        (
            LAST,
            "penetration.direction = [1.0, 1.0, 0.0]",
            "bad.toml:16: `effects.penetration.direction`: the direction has length 1.4",
        ),
        (
            LAST,
            "penetration.direction = [nan, 1.0, 0.0]",
            "bad.toml:16: `effects.penetration.direction`",
        ),
        (
            LAST,
            "penetration.directions = 0",
            "bad.toml:16: `effects.penetration.directions`: 0 is not",
        ),
        (
            LAST,
            "response.restitution = 1.5",
            "bad.toml:16: `effects.response.restitution`: restitution is 1.5",
        ),
        (
            LAST,
            "response.friction = -1.0",
            "bad.toml:16: `effects.response.friction`: friction is -1",
        ),
        (LAST, "crush = {}", "bad.toml:16: `effects.crush`"),
        (LAST, "crush.width_m = 0.0", "bad.toml:16: `effects.crush.width_m`: is 0"),
        (LAST, "max_contacts = 0", "bad.toml:16: `effects.max_contacts`: 0 is not"),
        (LAST, "overlap = true\nsegments = true", "bad.toml:17: `effects.segments`"),
        (LAST, "overlap = true\ncontacts = true", "bad.toml:17: `effects.contacts`"),
        (LAST, "overlap = true\nmax_contacts = 9", "bad.toml:17: `effects.max_contacts`"),
        (LAST, "contacts = false", "bad.toml:16: `effects.contacts`"),
        (
            LAST,
            "ignore = [['side', 'bottom']]",
            "bad.toml:16: `effects.ignore`: there is no part 'bottom' in `moving.parts`",
        ),
        (
            LAST,
            "ignore = [['top', 'top']]",
            "bad.toml:16: `effects.ignore`: there is no part 'top' in `fixed.parts`",
        ),
        (LAST, "ignore = ['top']", "bad.toml:16: `effects.ignore`"),
    ];
    for (part, replacement, words) in lines {
        refuses(&place, part, replacement, &[], &[words]);
    }
}

/// Some of it comes up only when the meshes are there.
#[test]
fn what_an_effect_lacks_is_refused_with_its_key() {
    let place = place();
    let open = "mesh = 'open.obj'\nmass_kg = 600.0";
    let cases = [
        (DURATION, "", "`motion.duration_s`: is missing", ""),
        (VELOCITY, "", "`motion`: nothing moves", ""),
        (LAST, "crush.width_m = 1.0", "`fixed.stiffness`: is missing: `effects.crush`", ""),
        (
            "mass_kg = 1000.0\ninertia_kg_m2 = [200.0, 200.0, 200.0]",
            "",
            "`fixed.mass_kg`: is missing",
            "response = true",
        ),
        (
            "mass_kg = 1000.0\ninertia_kg_m2 = [200.0, 200.0, 200.0]",
            "",
            "`fixed.mass_kg`: is missing",
            "crush.width_m = 1.0",
        ),
        (
            PART,
            "triangles = [[2, 12]]",
            "`moving.parts`: one has triangle 12, and the mesh 12",
            "ignore = [['side', 'top']]",
        ),
        (
            PART,
            "triangles = [[2, 12]], motion.velocity_m_s = [0, 1, 0]",
            "`moving.parts`: one has triangle 12",
            "",
        ),
        (
            "mesh = 'box.obj'\nmass_kg = 600.0",
            open,
            "`effects.volume`: the moving mesh has no closed part",
            "volume = true",
        ),
        (
            LAST,
            "ignore = [['side', 'top']]",
            "`effects.ignore`: is about contacts, and `motion`",
            "",
        ),
        (
            LAST,
            "containment = true\nignore = [['side', 'top']]",
            "`effects.ignore`: is about contacts, and `effects.containment` looks at the whole",
            "",
        ),
        (VELOCITY, "velocity_m_s = [1e80, 0.0, 0.0]", "`moving.velocity_m_s`: within 1 s", ""),
    ];
    for (part, replacement, words, more) in cases {
        // A velocity alone, of bodies that are not all described, needs an end.
        let scene = if part == DURATION {
            SCENE.replace(MASS, "").replace(INERTIA, "")
        } else {
            SCENE.to_owned()
        };
        let scene = scene.replacen(part, replacement, 1) + more;
        let run = ["run", &place.write("bad.toml", &scene), "--workers", "1", "--no-cache"];
        refused(&place.run(&run), 2, &[words]);
    }
    let both_open = SCENE.replace("box.obj", "open.obj");
    let run = ["run", &place.write("bad.toml", &both_open), "--workers", "1", "--no-cache"];
    refused(&place.run(&run), 2, &["`effects.containment`: neither mesh has a closed part"]);
}

#[test]
fn arguments_that_do_not_go_with_effects_are_usage_errors() {
    let place = place();
    refuses(&place, LAST, LAST, &["--accuracy", "boxes(3)"], &["`effects`: accuracy boxes(3)"]);
    refuses(&place, LAST, LAST, &["--stats"], &["--stats", "`effects`"]);
    refuses(&place, LAST, "overlap = true", &["--contacts"], &["--contacts", "`effects.overlap`"]);
    refuses(&place, LAST, "overlap = true", &["--stats"], &["--stats", "`effects`"]);
    refuses(
        &place,
        DURATION,
        "accuracy = 'boxes(3)'\nmotion.duration_s = 1.0",
        &[],
        &["accuracy boxes(3)"],
    );
}

#[test]
fn a_pose_that_is_no_rotation_is_refused_with_its_line() {
    let place = place();
    place.write("p.csv", &format!("{HEADER}1,0,0,0,3,0,0\n1,0,0,0.1,3,0,0\n"));
    let run = ["run", &place.write("scene.toml", SCENE), "--workers", "1"];
    refused(&place.run(&run), 1, &["p.csv:3: the quaternion has length 1.00"]);
}
