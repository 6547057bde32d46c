use serde_json::json;

use super::*;
use crate::report::page;

fn place(files: &[(&str, &str)]) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| fs::write(place.path().join(name), text).unwrap());
    place
}

fn experiment(kind: &str) -> Value {
    json!({
        "schema_version": 1,
        "kind": kind,
        "name": "units",
        "versions": { "bumper": "0.1.0" },
        "machine": { "cpu": "a <b>cpu</b>", "memory_bytes": 16_000_000_000_u64, "none": null },
        "figures": [{
            "name": "units", "title": "Speedup", "x": { "label": "units", "scale": "linear" },
            "y": { "label": "speedup", "scale": "log" },
            "series": [{ "name": "best", "points": [{ "x": 1.0, "y": 1.0, "spread": [0.9, 1.1] }] }]
        }],
        "tables": [{ "title": "Table 2", "columns": ["n", "s"], "rows": [["1", "2"]] }],
        "notes": ["every point is the mean of three samples"],
        "points": [{ "raw": 1 }]
    })
}

fn run() -> Value {
    let worker = json!({
        "scenarios": 2, "batches": 1, "compute_s": 0.5, "geometry_bytes_copied": 0,
        "message_bytes": 10, "died": false, "restarts": 0
    });
    json!({
        "schema_version": 1, "versions": { "bumper": "0.1.0" }, "machine": { "cores": 2 },
        "accuracy": "exact", "scenarios": 3, "scenarios_asked": 3,
        "colliding": 2, "pairs": 1234, "set_aside": [], "transport": "threads",
        "matchmaker": "best", "simd": "avx2", "bytes_published": 5, "bytes_copied": 0,
        "relative_data_transfer": 0.0, "scenarios_per_s": 100.0,
        "time": { "load_s": 0.5, "scenarios_s": 1.0 },
        "compute_us": { "mean": 10.0, "median": 9.0, "p99": 20.0, "max": 30.0 },
        "effects": [
            { "effect": "contacts", "scenarios": 3, "compute_s": 0.1, "mean_us": 9.0, "work": 1,
              "work_unit": "pairs found" },
            { "effect": "clearance", "scenarios": 1, "compute_s": 0.1, "mean_us": 700.0, "work": 1,
              "work_unit": "tests" }
        ],
        "worker_reports": [worker, worker],
        "scene": { "fixed": { "mesh": "a/truck.obj" }, "moving": { "mesh": "builtin:car" } },
        "fixed": { "triangles": 10, "tree_bytes": 100 },
        "moving": { "triangles": 20, "tree_bytes": 200 }
    })
}

const SCENARIOS: &str = "scenario,colliding,pairs,pairs_fnv1a64,clearance_m,side\n\
    0,1,34,00aa,,front\n1,0,0,0000,0.5,\n2,1,1200,00ab,0.25,front\n";

/// Reads it, and shows it.
fn shown(files: &[(&str, &str)]) -> String {
    let place = place(files);
    page::html(&sections(place.path()).unwrap()).unwrap()
}

fn refused(files: &[(&str, &str)], words: &[&str]) {
    let place = place(files);
    let error = sections(place.path()).unwrap_err().to_string();
    let folder = place.path().display().to_string();
    for word in words.iter().chain([&folder.as_str()]) {
        assert!(error.contains(word), "`{word}` is missing in: {error}");
    }
}

#[test]
fn experiments_and_clusters_bring_their_figures() {
    for kind in ["experiment", "cluster"] {
        let page = shown(&[(&format!("{kind}.json"), &experiment(kind).to_string())]);
        for words in [
            "<h2>",
            ": units</h2>",
            "Table 2",
            "1 (0.9–1.1)",
            "16 GB",
            "<li>every point",
            "&lt;b&gt;cpu",
        ] {
            assert!(page.contains(words), "{words}");
        }
        assert!(!page.contains("<dt>none"), "what is not known is not shown");
    }
}

#[test]
fn a_run_shows_its_scenarios_workers_stages_and_effects() {
    let files = [("summary.json", &*run().to_string()), ("scenarios.csv", SCENARIOS)];
    let place = place(&files);
    let sections = sections(place.path()).unwrap();
    let section = &sections[0];
    assert_eq!(section.heading, "Run: truck against builtin:car");
    let names: Vec<&str> = section.drawings.iter().map(Drawing::name).collect();
    assert_eq!(names, ["compute_times", "pairs_of_scenarios", "workers", "stages", "effects"]);
    let numbers = |name: &str| {
        let found = section.drawings.iter().find(|drawing| drawing.name() == name);
        found.unwrap().numbers().rows
    };
    let counts = [["none", "1"], ["1 to 9", "0"], ["10 to 99", "1"], ["100 to 999", "0"]];
    let counts: Vec<_> = counts.into_iter().chain([["1,000 to 9,999", "1"]]).collect();
    assert_eq!(numbers("pairs_of_scenarios"), counts);
    assert_eq!(numbers("workers"), [["0", "50", "50"], ["1", "50", "50"]]);
    assert_eq!(numbers("stages"), [["load", "0.5"], ["scenarios", "1"]]);
    assert_eq!(numbers("effects"), [["contacts", "9"], ["clearance", "700"]]);
    assert_eq!(numbers("compute_times"), [["9", "50"], ["20", "99"], ["30", "100"]]);
    let table = |title: &str| {
        let found = section.tables.iter().find(|table| table.title == title);
        found.unwrap_or_else(|| panic!("no {title}")).rows.clone()
    };
    let columns = table("What scenarios say");
    assert!(
        columns.contains(&["clearance_m", "2", "0.25", "0.25", "0.5"].map(str::to_owned).into())
    );
    assert_eq!(table("What scenarios say in words"), [["side", "front", "2"]]);
    page::html(&sections).unwrap();
}

#[test]
fn a_run_of_nothing_is_shown_too() {
    let mut run = run();
    for count in ["scenarios", "colliding", "pairs"] {
        run[count] = 0.into();
    }
    for empty in ["effects", "worker_reports"] {
        run[empty] = json!([]);
    }
    run["set_aside"] = json!([0, 1]);
    run["answered_before"] = 1.into();
    run["compute_us"] = json!({ "mean": 0.0, "median": 0.0, "p99": 0.0, "max": 0.0 });
    let page =
        shown(&[("summary.json", &run.to_string()), ("scenarios.csv", "scenario,colliding\n")]);
    for note in ["not finished: 0 of 3", "2 scenarios have no answer", "1 scenarios are an earlier"]
    {
        assert!(page.contains(note), "{page}");
    }
}

#[test]
fn what_is_not_ours_is_refused_by_file() {
    refused(&[], &["holds no output", "summary.json", "cluster.json"]);
    refused(&[("other.json", "{}")], &["holds no output"]);
    let whole = experiment("experiment").to_string();
    for length in [0, 1, whole.len() / 2, whole.len() - 1] {
        refused(&[("experiment.json", &whole[..length])], &["experiment.json", "only a part"]);
    }
    refused(&[("accuracy.json", "[]")], &["accuracy.json", "not what bumper writes"]);
    let mut later = experiment("experiment");
    later["schema_version"] = 2.into();
    refused(&[("experiment.json", &later.to_string())], &["schema_version 2", "knows 1"]);
    let other = experiment("cluster").to_string();
    refused(&[("experiment.json", &other)], &["experiment.json", "`cluster`"]);
    let missing = Path::new("/nonexistent/results");
    assert!(sections(missing).unwrap_err().to_string().contains("/nonexistent/results: cannot be"));
}

#[test]
fn figures_that_cannot_be_drawn_are_refused_by_file() {
    let mut bad = experiment("experiment");
    bad["figures"][0]["series"][0]["points"][0]["y"] = (-1.0).into();
    refused(&[("experiment.json", &bad.to_string())], &["experiment.json", "logarithmic"]);
    let mut bad = experiment("experiment");
    bad["figures"][0]["name"] = "../../up".into();
    refused(&[("experiment.json", &bad.to_string())], &["experiment.json", "stem of a file"]);
    let mut bad = experiment("experiment");
    bad["tables"][0]["rows"] = json!([["1"]]);
    refused(&[("experiment.json", &bad.to_string())], &["experiment.json", "Table 2", "row 0"]);
}

#[test]
fn scenarios_that_do_not_belong_to_their_summary_are_refused() {
    let summary = run().to_string();
    let with = |scenarios: &str, words: &[&str]| {
        refused(&[("summary.json", &summary), ("scenarios.csv", scenarios)], words);
    };
    refused(&[("summary.json", &summary)], &["scenarios.csv", "cannot be read"]);
    with("", &["scenarios.csv", "line 1"]);
    with("a,b\n", &["line 1", "scenario,colliding"]);
    with("scenario,colliding\n0,1\n1\n", &["line 3", "1 cells"]);
    with("scenario,colliding\n0,1\n", &["has 1 scenarios", "3"]);
}

#[test]
fn numbers_of_any_size_are_shown() {
    let scenarios = "scenario,colliding,pairs\n0,1,1e300\n1,0,-5\n2,1,18446744073709551615\n";
    let page = shown(&[("summary.json", &run().to_string()), ("scenarios.csv", scenarios)]);
    assert!(page.contains("none") && page.contains("18,446,744,073,709,551,61"), "{page}");
}
