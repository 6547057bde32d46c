//! `bumper accuracy`, and runs at a level. What is timed is not asserted, what is answered is.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{CAR, Place, TRACKED, json, refused, stdout, succeeded};

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/config/accuracy");

fn row<'a>(report: &'a Value, level: &str) -> &'a Value {
    let rows = report["levels"].as_array().unwrap();
    rows.iter().find(|row| row["level"] == level).unwrap_or_else(|| panic!("no {level}: {report}"))
}

#[test]
fn every_level_is_held_against_exact() {
    let place = Place::new();
    let out = place.text("out");
    let small = ["accuracy", "--fixed", TRACKED, "--moving", CAR, "--count", "6"];
    let output = place.run(&[&small[..], &["--json", "--out", &out]].concat());
    succeeded(&output);
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(report, json(&Path::new(&out).join("accuracy.json")));
    assert_eq!(report["schema_version"], 1);
    assert_eq!(report["scenarios"], 6);
    let rows = report["levels"].as_array().unwrap();
    assert_eq!(rows.len(), 7 + 4, "depths and tests");
    for row in rows {
        let time = |key: &str| row["time_us"][key].as_f64().unwrap();
        assert!(0.0 < time("median") && time("median") <= time("p99"), "{row}");
        assert!(row["box_tests"].as_f64().unwrap() > 0.0, "{row}");
        let level = row["level"].as_str().unwrap();
        if level.starts_with("boxes") {
            assert_eq!((&row["missing"], &row["false_misses"]), (&0.into(), &0.into()), "{row}");
        }
    }
    let exact = row(&report, "exact");
    assert_eq!((&exact["wrong_pairs"], &exact["over_exact"]), (&0.0.into(), &1.0.into()));
    assert!(exact["signs"]["filter"].as_f64().unwrap() > 0.0);
    assert!(row(&report, "boxes")["extra"].as_u64() < row(&report, "boxes(4)")["extra"].as_u64());
    let worst = |level| row(&report, level)["contact_error_m"]["worst"].as_f64().unwrap();
    assert!(worst("exact") <= 1e-9 && worst("f64") < 1e-6, "metres");
    assert!(worst("f64") < worst("f32") && worst("f32") < 1.0, "metres");
    for row in rows {
        let plain = ["f32", "f64"].contains(&row["level"].as_str().unwrap());
        assert_eq!(row["without_contact"].is_u64(), plain, "{row}");
    }
    for (figure, words) in [("accuracy.svg", "no error"), ("depth.svg", "boxes(depth)")] {
        let svg = fs::read_to_string(Path::new(&out).join(figure)).unwrap();
        assert!(svg.contains("<svg") && svg.contains(words), "{figure}");
    }
    let output = place.run(&[&small[..], &["--levels", "f32,boxes(3)", "--out", &out]].concat());
    succeeded(&output);
    let table = stdout(&output);
    assert!(
        ["boxes(3)", "f32", "exact", "expansions"].iter().all(|w| table.contains(w)),
        "{table}"
    );
    assert_eq!(json(&Path::new(&out).join("accuracy.json"))["levels"].as_array().unwrap().len(), 3);
}

#[test]
fn the_command_of_the_readme_draws_its_figure() {
    let command = "bumper accuracy config/accuracy/nearly.toml --out results";
    assert!(include_str!("../../README.md").contains(&format!("\n{command}\n")));
    let place = Place::new();
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let mut command =
        place.bumper(&[&words[..3], &[&place.text("results"), "--count", "2"]].concat());
    succeeded(&command.current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap());
    assert!(place.path("results").join("accuracy.svg").exists());
}

#[test]
fn the_scenes_show_what_they_are_for() {
    let place = Place::new();
    let compare = |scene: &str, more: &[&str]| -> Value {
        let scene = format!("{SCENES}/{scene}.toml");
        let output = place.run(&[&["accuracy", &scene, "--json"], more].concat());
        succeeded(&output);
        serde_json::from_str(&stdout(&output)).unwrap()
    };
    let small = ["--fixed", TRACKED, "--moving", CAR, "--count", "3", "--levels", "f64"];
    for scene in ["ordinary", "far"] {
        let report = compare(scene, &small);
        assert_eq!(report["colliding"], 3, "{scene}");
        assert_eq!(row(&report, "f64")["wrong_pairs"], 0.0, "{scene}");
    }
    let touching = compare("touching", &["--levels", "f64", "--count", "3"]);
    assert!(touching["pairs"].as_u64() > Some(1_000));
    let signs = &row(&touching, "exact")["signs"];
    assert!(signs["structure"].as_f64() > signs["filter"].as_f64(), "{signs}");
    assert_eq!(signs["expansions"], 0.0, "a grid needs none");
    let nearly = compare("nearly", &["--levels", "f64", "--count", "4"]);
    assert_eq!(nearly["colliding"], 4);
    assert!(row(&nearly, "f64")["wrong_pairs"].as_f64() > Some(0.0));
    assert_eq!(row(&nearly, "exact")["wrong_pairs"], 0.0);
    let slivers = compare("sliver", &["--levels", "f32", "--count", "3"]);
    assert!(row(&slivers, "f32")["wrong_pairs"].as_f64() > Some(0.0));
}

#[test]
fn a_run_at_a_level_says_which() {
    let place = Place::new();
    let run = |name: &str, more: &[&str]| {
        let out = place.text(name);
        succeeded(&place.run_small(&[&["--out", &out], more].concat()));
        json(&Path::new(&out).join("summary.json"))
    };
    let exact = run("exact", &[]);
    assert_eq!(exact["accuracy"], "exact");
    let boxes = run("boxes", &["--accuracy", "boxes", "--contacts"]);
    assert_eq!(boxes["accuracy"], "boxes");
    assert!(boxes["pairs"].as_u64() > exact["pairs"].as_u64());
    let shared = run("shared", &["--accuracy", "boxes(4)"]);
    let sent = run("sent", &["--accuracy", "boxes(4)", "--transport", "pipe"]);
    assert_eq!(shared["scene"]["fixed"]["depth"], 12, "what the scene says");
    assert_eq!((&shared["pairs"], &shared["colliding"]), (&sent["pairs"], &sent["colliding"]));
    assert!(shared["colliding"].as_u64() >= exact["colliding"].as_u64());
}

#[test]
fn what_makes_no_sense_at_a_level_is_refused() {
    let place = Place::new();
    let out = place.text("out");
    let refuse = |arguments: &[&str], words: &[&str]| {
        refused(&place.run_small(arguments), 2, words);
        assert!(!Path::new(&out).exists());
    };
    refuse(&["--accuracy", "f16"], &["f16", "boxes(D)"]);
    refuse(&["--accuracy", "boxes(25)"], &["boxes(25)", "0 to 24"]);
    refuse(&["--accuracy", "boxes(4)", "--out", &out, "--contacts"], &["--contacts", "boxes(4)"]);
    refuse(&["--accuracy", "f32", "--stats"], &["--stats", "f32"]);
    let output = place.run(&["accuracy", "--accuracy", "f32"]);
    refused(&output, 2, &["--levels f32"]);
}
