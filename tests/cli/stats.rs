//! `--stats`: the paper's cost equation for each kind of tree.

use std::num::NonZeroU32;

use bumper::mesh::MeshSource;
use bumper::scene::read_poses;
use bumper::tree::descent::Descent;
use bumper::tree::{BuildOptions, Counts, TreeKind, build};
use serde_json::Value;

use super::*;

/// Poses from touching to apart.
fn poses(rows: u32) -> String {
    let row = |n: u32| {
        let (angle, shift) = (0.1 * f64::from(n), 0.05 * f64::from(n % 60));
        let (w, z) = (angle.cos(), angle.sin());
        format!("{w:.17},0,0,{z:.17},{shift},0.3,0\n")
    };
    HEADER.to_owned() + &(0..rows).map(row).collect::<String>()
}

/// What this process counts, one scenario after the other.
fn recount(kind: TreeKind, poses: &Path) -> Counts {
    let tree = |mesh: &str| {
        build(&mesh.parse::<MeshSource>().unwrap().load().unwrap(), BuildOptions { kind })
    };
    let (fixed, moving) = (tree(TRACKED), tree(CAR));
    let (mut descent, mut sum) = (Descent::default(), Counts::default());
    for pose in read_poses(poses, None).unwrap() {
        let views = [fixed.view(), moving.view()];
        sum += descent.counted_pairs(&views[0], &views[1], &pose, &mut Vec::new()).unwrap();
    }
    sum
}

#[test]
fn every_tree_kind_is_run_and_its_tests_are_those_of_a_serial_recount() {
    let place = Place::new();
    let csv = place.write("p.csv", &poses(60));
    let run = ["run", "--fixed", TRACKED, "--moving", CAR, "--poses", &csv, "--workers", "2"];
    let output =
        place.run(&[&run[..], &["--stats", "--json", "--out", &place.text("out")]].concat());
    succeeded(&output);
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(summary, json(&place.path("out/summary.json")));
    let rows = summary["tree_costs"].as_array().unwrap();
    let kinds: Vec<&str> = rows.iter().map(|row| row["tree"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["wide", "obb", "aabb"], "that of the scene first");
    for (kind, row) in [TreeKind::Wide, TreeKind::Obb, TreeKind::Aabb].into_iter().zip(rows) {
        let Counts { boxes, triangles, exact } = recount(kind, &place.path("p.csv"));
        for (key, count) in [("n_b", boxes), ("n_p", triangles), ("exact", exact)] {
            assert_eq!(row[key], count, "{kind} {key}");
        }
        assert_eq!(row["scenarios"], 60);
        assert!(row["descent_s"].as_f64().unwrap() > 0.0 && boxes > 0 && triangles > 0);
        let costs = ["c_b_ns", "c_p_ns"].map(|key| row["fit"][key].as_f64().unwrap());
        assert!(costs.iter().all(|cost| *cost >= 0.0) && costs[0] + costs[1] > 0.0, "{row}");
        assert!(row["fit"]["mean_relative_error"].as_f64().unwrap().is_finite());
    }

    // The same run without: the same answers, and nothing of this.
    let output = place.run(&[&run[..], &["--json", "--out", &place.text("plain")]].concat());
    succeeded(&output);
    assert!(!stdout(&output).contains("tree_costs"));
    let rows = |name| fs::read_to_string(place.path(name).join("scenarios.csv")).unwrap();
    assert_eq!(rows("out"), rows("plain"));
}

#[test]
fn the_equation_is_printed_for_three_kinds_only_if_it_is_asked_for() {
    let place = Place::new();
    let with = place.run_small(&["--stats"]);
    let without = place.run_small(&[]);
    succeeded(&with);
    succeeded(&without);
    let table = stdout(&with);
    let table = table.split_once("T = N_b C_b + N_p C_p").unwrap().1;
    for kind in TreeKind::ALL {
        assert!(table.contains(&format!("\n{kind} ")), "{table}");
    }
    assert!(!stdout(&without).contains("C_b"));
}

#[test]
fn one_pose_over_and_over_tells_no_costs() {
    let place = Place::new();
    let poses = place.write("p.csv", &format!("{HEADER}{}", "1,0,0,0,0.5,0,0\n".repeat(5)));
    let run = ["run", "--fixed", TRACKED, "--moving", CAR, "--poses", &poses, "--workers", "1"];
    // The times differ, but N_p / N_b does not.
    let output = place.run(&[&run[..], &["--stats", "--json"]].concat());
    succeeded(&output);
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert!(summary["tree_costs"][0]["n_b"].as_u64().unwrap() > 0);
    assert_eq!(summary["tree_costs"][0]["fit"], Value::Null);
    succeeded(&place.run(&[&run[..], &["--stats"]].concat()));
}

/// The scene's own kind is done when its contacts appear; the others take seconds.
#[test]
fn ctrl_c_during_the_comparison_keeps_the_run_whole() {
    let place = Place::new();
    // Many, of which few touch.
    let rows: String = (0..20_000).map(|n| format!("1,0,0,0,{},0.3,0\n", n % 60)).collect();
    let poses = place.write("long.csv", &format!("{HEADER}{rows}"));
    let out = place.text("out");
    let run = ["run", "--fixed", TRACKED, "--moving", CAR, "--poses", &poses, "--workers", "2"];
    let mut child =
        interrupt::start(&place, &[&run[..], &["--stats", "--contacts", "--out", &out]].concat());
    interrupt::wait_until(&mut child, || place.path("out/contacts.parquet").exists());
    let output = interrupt::interrupt(child);
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    assert!(stderr(&output).contains("all scenarios were answered"), "{}", stderr(&output));
    let summary = json(&place.path("out/summary.json"));
    assert_eq!((&summary["interrupted"], &summary["scenarios"]), (&false.into(), &20_000.into()));
    let rows = summary["tree_costs"].as_array().unwrap();
    assert!(rows.len() < 3 && rows[0]["tree"] == "wide", "{rows:?}");
    assert_eq!(rows[0]["scenarios"], 20_000);
    agree(&place.path("out"));
    assert_eq!(interrupt::shared_memory_of(&place.path("runtime")), [""; 0]);
}

#[test]
fn counts_do_not_depend_on_the_number_of_workers() {
    let place = Place::new();
    let counts = |workers: NonZeroU32| {
        let output = place.run_small(&["--stats", "--json", "--workers", &workers.to_string()]);
        succeeded(&output);
        let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
        let row = |row: &Value| ["n_b", "n_p", "exact"].map(|key| row[key].as_u64().unwrap());
        summary["tree_costs"].as_array().unwrap().iter().map(row).collect::<Vec<_>>()
    };
    assert_eq!(counts(NonZeroU32::MIN), counts(NonZeroU32::new(3).unwrap()));
}
