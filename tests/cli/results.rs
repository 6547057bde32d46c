//! What a run answers, and where.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

use serde_json::Value;

use super::*;

#[test]
fn json_is_one_object_and_the_same_as_the_file() {
    let place = Place::new();
    let output = place.run_small(&["--json", "--workers", "2", "--out", &place.text("out")]);
    succeeded(&output);
    let printed: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(printed, json(&place.path("out/summary.json")));
    for (key, expected) in [("scenarios", 60), ("workers", 2), ("schema_version", 1)] {
        assert_eq!(printed[key], expected, "{key}");
    }
    assert_eq!(printed["interrupted"], false);
    assert_eq!(printed["bytes_copied"], 0, "geometry is used in place");
    let trees = ["fixed", "moving"].map(|mesh| printed[mesh]["tree_bytes"].as_u64().unwrap());
    assert_eq!(printed["bytes_published"], trees[0] + trees[1], "and put there once");
    assert_eq!(printed["transport"], "iceoryx2");
    assert_eq!(printed["versions"]["bumper"], env!("CARGO_PKG_VERSION"));
    for key in ["colliding", "pairs"] {
        assert!(printed[key].as_u64().unwrap() > 0, "{key}");
    }
    for key in [
        "load_s",
        "build_s",
        "publish_s",
        "start_workers_s",
        "scenarios_s",
        "pre_analysis_s",
        "wall_s",
    ] {
        assert!(printed["time"][key].as_f64().unwrap() >= 0.0, "{key}");
    }
    assert_eq!(printed["worker_reports"].as_array().unwrap().len(), 2);
    assert_eq!(printed["scene"]["fixed"]["mesh"], TRACKED);
    assert!(printed["machine"]["cores"].as_u64().unwrap() >= 1);
}

#[test]
fn the_number_of_workers_does_not_change_a_byte_of_the_results() {
    let place = Place::new();
    let rows: Vec<String> = ["1", "2", "3"]
        .iter()
        .map(|workers| {
            let out = place.text(workers);
            succeeded(&place.run_small(&["--workers", workers, "--out", &out]));
            fs::read_to_string(place.path(workers).join("scenarios.csv")).unwrap()
        })
        .collect();
    assert!(rows.iter().all(|text| *text == rows[0]));
    let mut lines = rows[0].lines();
    assert_eq!(lines.next(), Some("scenario,colliding,pairs,pairs_fnv1a64"));
    for (number, line) in lines.enumerate() {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[0], number.to_string());
        assert_eq!(fields[1], if fields[2] == "0" { "0" } else { "1" });
        assert!(fields[3].len() == 16 && u64::from_str_radix(fields[3], 16).is_ok(), "{line}");
    }
    assert_eq!(rows[0].lines().count(), 61);
}

#[test]
fn contacts_are_the_pairs_that_the_rows_count() {
    let place = Place::new();
    let out = place.text("out");
    succeeded(&place.run_small(&["--out", &out, "--contacts"]));
    agree(&place.path("out"));
    // A run without contacts leaves none of the earlier ones beside its own results.
    succeeded(&place.run_small(&["--out", &out]));
    assert!(!place.path("out/contacts.parquet").exists());
}

#[test]
fn poses_can_be_cut_to_the_first_rows() {
    let place = Place::new();
    let poses = place.write("p.csv", &format!("{HEADER}{}", "1,0,0,0,0,0,0\n".repeat(5)));
    let run = ["run", "--fixed", CAR, "--moving", CAR, "--poses", &poses, "--json", "--count"];
    let output = place.run(&[&run[..], &["3"]].concat());
    succeeded(&output);
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!((&summary["scenarios"], &summary["colliding"]), (&3.into(), &3.into()));
    refused(&place.run(&[&run[..], &["6"]].concat()), 1, &["p.csv", "6 poses are asked for"]);
}

const README: &str = include_str!("../../README.md");

#[test]
fn the_readme_names_the_compiler_that_is_needed() {
    assert!(README.contains(concat!("Rust ", env!("CARGO_PKG_RUST_VERSION"), " or newer")));
}

/// The commands of the README's worked example, word for word.
#[test]
fn the_users_own_two_files_run_as_in_the_readme() {
    let place = Place::new();
    let mesh = |x: f64| {
        let right = x + 1.0;
        format!("v {x} 0 0\nv {x} 1 0\nv {x} 0 1\nv {right} 0 0\nf 1 2 3\nf 1 2 4\n")
    };
    place.write("truck.obj", &mesh(0.0));
    place.write("car.obj", &mesh(5.0));
    place.write("poses.csv", &format!("{HEADER}1,0,0,0,-5,0,0\n1,0,0,0,0,0,0\n"));
    let readme = |command: &str| {
        assert!(README.contains(&format!("\n{command}\n")), "{command}");
        let words: Vec<&str> = command.split_whitespace().skip(1).collect();
        let output = place.bumper(&words).current_dir(place.0.path()).output().unwrap();
        succeeded(&output);
        stdout(&output)
    };
    let info = readme("bumper mesh info truck.obj car.obj");
    assert!(info.contains("truck.obj") && info.contains("car.obj"));
    let summary = readme(
        "bumper run --fixed truck.obj --moving car.obj --poses poses.csv --out results --contacts",
    );
    assert!(
        summary.starts_with("scenarios     2\ncolliding     1\npairs         4\n"),
        "{summary}"
    );
    let rows = scenarios(&place.path("results/scenarios.csv"));
    assert_eq!(rows.iter().map(|row| row.1).collect::<Vec<_>>(), [4, 0]);
    agree(&place.path("results"));
}

#[test]
fn what_is_sent_can_be_compressed_and_come_from_other_workers() {
    let command = "bumper run --transport pipe --compress lz4 --subtrees-from workers";
    assert!(README.contains(&format!("\n{command}\n")), "{command}");
    let place = Place::new();
    let plain = place.run_small(&["--transport", "pipe", "--json"]);
    succeeded(&plain);
    let options: Vec<&str> = command.split(' ').skip(2).collect();
    let out = place.text("out");
    let output = place.run_small(&[&options[..], &["--out", &out]].concat());
    succeeded(&output);
    let text = stdout(&output);
    assert!(text.contains("\ncompressed    ") && text.contains("\nfrom workers  "), "{text}");
    let plain: Value = serde_json::from_str(&stdout(&plain)).unwrap();
    let packed = json(&place.path("out/summary.json"));
    assert_eq!(packed["pairs"], plain["pairs"]);
    let transfer = &packed["transfer"];
    assert_eq!(
        (&transfer["compress"], &transfer["subtrees_from"]),
        (&"lz4".into(), &"workers".into())
    );
    let bytes = |summary: &Value, name: &str| summary["transfer"][name].as_u64().unwrap();
    assert!(bytes(&packed, "bytes_packed") < bytes(&packed, "bytes_plain"));
    assert_eq!(bytes(&packed, "bytes_plain"), bytes(&plain, "bytes_plain"));
    assert_eq!((bytes(&plain, "bytes_from_workers"), bytes(&packed, "not_fetched")), (0, 0));
    let each = packed["worker_reports"].as_array().unwrap().iter();
    let each: u64 = each.map(|worker| worker["bytes_from_workers"].as_u64().unwrap()).sum();
    assert_eq!(each, bytes(&packed, "bytes_from_workers"));
}

#[test]
fn the_second_run_takes_its_trees_from_the_cache() {
    let place = Place::new();
    let cache = |arguments: &[&str]| -> [Value; 2] {
        let output = place.run_small(&[&["--json"], arguments].concat());
        succeeded(&output);
        let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
        ["fixed", "moving"].map(|mesh| summary[mesh]["cache"].clone())
    };
    assert_eq!(cache(&["--no-cache"]), ["off", "off"]);
    assert_eq!(cache(&[]), ["built", "built"]);
    assert_eq!(cache(&[]), ["hit", "hit"]);
    assert!(place.path("cache/bumper").is_dir());
    let elsewhere = place.text("elsewhere");
    assert_eq!(cache(&["--cache-dir", &elsewhere]), ["built", "built"]);
}

#[test]
fn mesh_info_prints_a_report_for_each_mesh() {
    let place = Place::new();
    let output = place.run(&["mesh", "info", CAR, TRACKED, "--json"]);
    succeeded(&output);
    let reports: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(reports.as_array().unwrap().len(), 2);
    assert_eq!(reports[0]["source"], CAR);
    let output = place.run(&["mesh", "info", CAR]);
    succeeded(&output);
    assert!(stdout(&output).contains(CAR));
}

#[test]
fn mesh_info_reports_on_the_meshes_that_can_be_read() {
    let place = Place::new();
    let output = place.run(&["mesh", "info", "gone.ply", CAR, "lost.stl"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).starts_with(&format!("{CAR} (built in)\n")));
    let errors = stderr(&output);
    let lines: Vec<&str> = errors.lines().collect();
    assert!(lines.len() == 2, "{errors}");
    assert!(lines[0].starts_with("error: gone.ply: ") && lines[1].starts_with("error: lost.stl: "));
}

#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let place = Place::new();
    let mut command = place.bumper(&["mesh", "info", CAR, "--json"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
}

#[test]
fn warnings_are_on_stderr_and_a_damaged_cache_is_rebuilt() {
    let place = Place::new();
    succeeded(&place.run_small(&[]));
    for entry in fs::read_dir(place.path("cache/bumper")).unwrap() {
        fs::write(entry.unwrap().path(), "damaged").unwrap();
    }
    let output = place.run_small(&["--json"]);
    succeeded(&output);
    let warnings = BufReader::new(&output.stderr[..]).lines().map(Result::unwrap);
    assert_eq!(warnings.filter(|line| line.contains("WARN")).count(), 2, "{}", stderr(&output));
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(summary["fixed"]["cache"], "rebuilt");
}
