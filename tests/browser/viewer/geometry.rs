//! That what is drawn is where it is.

use bumper::effects::contacts::pairs_fnv1a64;
use bumper::effects::motion::BodyMotion;
use bumper::geometry::motion::{Motion, MotionValues, Trajectory};
use bumper::geometry::{Point, Pose};
use bumper::mesh::MeshSource;

use super::*;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// Within what a page may move a vertex by.
fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-4, "{found} is not {expected}");
    }
}

#[test]
fn triangles_are_where_the_mesh_has_them() {
    let place = Place::new();
    let Some(mut browser) = place.open(&[&SMALL[..], &["--count", "1"]].concat()) else { return };
    for (side, mesh) in [(0, SMALL[1]), (1, SMALL[3])] {
        let mesh = mesh.parse::<MeshSource>().unwrap().load().unwrap();
        let all = format!(
            "(() => {{ const body = bumper.bodies[{side}]; const [x, y, z] = body.model.center; \
             return [...body.model.ids].flatMap((id, rank) => \
             [id, ...body.corners(rank).flatMap((p) => [p.x + x, p.y + y, p.z + z])]); }})()"
        );
        let all = numbers(&browser.evaluate(&all));
        assert_eq!(all.len(), 10 * mesh.faces().len());
        let mut seen = vec![false; mesh.faces().len()];
        for triangle in all.chunks(10) {
            let id = triangle[0] as u32;
            near(&triangle[1..], mesh.triangle(id).as_flattened());
            assert!(!std::mem::replace(&mut seen[id as usize], true), "{id} is there twice");
        }
    }
}

#[test]
fn pairs_are_those_of_the_run_and_belong_to_subtrees_of_their_worker() {
    for transport in ["threads", "pipe"] {
        let place = Place::new();
        let small = [&SMALL[..], &["--count", "10", "--transport", transport]].concat();
        let Some(mut browser) = place.open(&small) else { return };
        place.run(&[&["run", "--out", "run"], &small[..]].concat());
        let rows = fs::read_to_string(place.path("run/scenarios.csv")).unwrap();
        for (at, row) in rows.lines().skip(1).enumerate() {
            let pairs = format!(
                "(() => {{ const {{ scenarios, bodies }} = bumper.model; \
                 return [...scenarios.contacts({at})].map((rank, i) => bodies[i % 2].ids[rank]); }})()"
            );
            let numbers = numbers(&browser.evaluate(&pairs));
            let pair = |pair: &[f64]| [pair[0] as u32, pair[1] as u32];
            let mut pairs: Vec<[u32; 2]> = numbers.chunks(2).map(pair).collect();
            pairs.sort_unstable();
            let hash = format!("{:016x}", pairs_fnv1a64(&pairs));
            assert_eq!(row.split(',').nth(3), Some(&*hash), "scenario {at}");
        }
        let without_holder = "(() => { const { scenarios, bodies } = bumper.model; let without = 0; \
             for (let at = 0; at < scenarios.count; at++) scenarios.contacts(at).forEach((rank, i) => { \
             const { rootStarts, isHeld } = bodies[i % 2]; \
             const root = rootStarts.findLastIndex((start) => start <= rank); \
             without += !isHeld(root, scenarios.workers[at]); }); return without; })()";
        assert_eq!(browser.evaluate(without_holder), 0, "{transport}");
    }
}

/// The page's own arithmetic, beside that which decides when they touch.
#[test]
fn bodies_go_where_their_trajectories_go() {
    for axes in ["body", "world"] {
        let (place, scene) = Place::with_everything();
        let text = EVERYTHING.replace("cg_m =", &format!("axes = \"{axes}\"\ncg_m ="));
        fs::write(place.path("scene.toml"), text).unwrap();
        let Some(mut browser) = place.open(&[&scene]) else { return };
        let motion = Motion::new(MotionValues {
            velocity_m_s: [-1.0, 0.1, 0.0],
            spin_rad_s: [0.1, 0.2, 0.9],
            cg_m: [0.01, 0.02, 0.0],
            ..MotionValues::default()
        });
        let axes = serde_json::from_value(axes.into()).unwrap();
        let motion = BodyMotion { motion: motion.unwrap(), axes };
        let start = Pose::checked([0.8, 0.0, 0.0, 0.6], [0.5, 0.1, 0.05]).unwrap();
        let trajectory = Trajectory::new(start, &motion.in_world(&start), None);
        for time_s in [0.0, 0.25, 1.0] {
            browser.evaluate(&format!("bumper.choose(2); bumper.timeline.set({time_s})"));
            let place = "(() => { const [fixed, moving] = bumper.bodies; \
                 const back = moving.model.center.map((x) => -x); \
                 const p = moving.object.position.clone(); \
                 return [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]].flatMap((q) => p.set(...q) \
                 .add({ x: back[0], y: back[1], z: back[2] }).applyMatrix4(moving.object.matrix) \
                 .toArray().map((x, k) => x + fixed.model.center[k])); })()";
            let found = numbers(&browser.evaluate(place));
            let pose = trajectory.pose(time_s);
            let corners: [Point; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]
                .map(|p| pose.apply(p));
            near(&found, corners.as_flattened());
        }
    }
}

#[test]
fn at_the_time_of_impact_the_first_triangles_meet() {
    let (place, scene) = Place::with_everything();
    let Some(mut browser) = place.open(&[&scene]) else { return };
    browser.evaluate("bumper.choose(1)");
    browser.press("i");
    let seconds = browser.evaluate("bumper.timeline.seconds").as_f64().unwrap();
    let said =
        browser.evaluate("bumper.model.scenarios.value(1, 'impact_time_s')").as_f64().unwrap();
    assert!(seconds > 0.0 && seconds == said, "{seconds}");
    assert_eq!(browser.evaluate("document.querySelectorAll('#marks .moment').length"), 1);
    // The bounds of both placed triangles meet, to within what counts as contact.
    let gap = "(() => { const [a, b] = bumper.impactRanks.map((rank, side) => \
         bumper.bodies[side].placedCorners(rank)); \
         const gap = (k) => Math.max(Math.min(...a.map(k)) - Math.max(...b.map(k)), \
         Math.min(...b.map(k)) - Math.max(...a.map(k))); \
         return Math.max(gap((p) => p.x), gap((p) => p.y), gap((p) => p.z)); })()";
    let gap = browser.evaluate(gap).as_f64().unwrap();
    assert!(gap < 3e-4, "{gap} m apart");
    browser.evaluate("bumper.choose(3)");
    assert_eq!(browser.evaluate("document.getElementById('impact').disabled"), true);
}

/// The wheels of a car that turn, at places between the start and the end.
#[test]
fn parts_turn_in_their_body() {
    let scene = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/config/effects/wheel.toml"));
    let place = Place::new();
    let Some(mut browser) = place.open(&[scene.to_str().unwrap(), "--workers", "1"]) else {
        return;
    };
    let asked = bumper::scene::Scene::read(scene).unwrap().effects;
    let body = &asked.bodies[1];
    let poses = bumper::scene::read_poses(&scene.with_file_name("wheel.csv"), None).unwrap();
    let mesh = "builtin:car?triangles=4000".parse::<MeshSource>().unwrap().load().unwrap();
    let (at, time_s) = (1, 0.37);
    browser.evaluate(&format!("bumper.choose({at}); bumper.timeline.set({time_s})"));
    for (triangles, part) in &body.parts {
        let id = triangles.iter().next().unwrap();
        let corners = format!(
            "bumper.bodies[1].placedCorners(bumper.rankOf(1, {id})).flatMap((p) => \
             p.toArray().map((x, k) => x + bumper.model.bodies[0].center[k]))"
        );
        let found = numbers(&browser.evaluate(&corners));
        let motion = body.motion.in_world(&poses[at]);
        let pose = Trajectory::new(poses[at], &motion, Some(part)).pose(time_s);
        near(&found, mesh.triangle(id).map(|p| pose.apply(p)).as_flattened());
    }
}

#[test]
fn vehicles_are_deformed_after_the_crash_that_deforms_them() {
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/config/effects");
    let text = fs::read_to_string(Path::new(config).join("crash.toml")).unwrap();
    let text = text
        .replace("triangles=10000", "triangles=1000")
        .replace("crash.csv", &format!("{config}/crash.csv"))
        .replace("{ width_m = 1.5 }", "{ width_m = 1.5, deform_after = 0 }");
    let place = Place::new();
    fs::write(place.path("crash.toml"), text).unwrap();
    let Some(mut browser) = place.open(&["crash.toml", "--workers", "2"]) else { return };
    place.run(&["run", "crash.toml", "--workers", "2", "--out", "run"]);
    let before = "builtin:car?triangles=1000".parse::<MeshSource>().unwrap().load().unwrap();
    let after = MeshSource::File(place.path("run/fixed_deformed.ply")).load().unwrap();
    let id = (0..before.faces().len() as u32)
        .find(|&id| (before.triangle(id)[0][0] - after.triangle(id)[0][0]).abs() > 0.01)
        .expect("the crash has moved something");
    for (scenario, mesh) in [(0, &before), (1, &after), (0, &before)] {
        let corners = format!(
            "(bumper.choose({scenario}), bumper.bodies[0].corners(bumper.rankOf(0, {id})).flatMap((p) => \
             p.toArray().map((x, k) => x + bumper.model.bodies[0].center[k])))"
        );
        near(&numbers(&browser.evaluate(&corners)), mesh.triangle(id).as_flattened());
    }
}
