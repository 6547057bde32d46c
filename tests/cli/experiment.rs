//! `bumper experiment`: small models, real workers. What is timed is not asserted, what is answered,
//! kept and drawn is.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::interrupt::{interrupt, start, wait_until};
use super::*;

const SMALL: [&str; 8] =
    ["--models", "heavy-car", "--fixed", TRACKED, "--moving", CAR, "--count", "9"];

/// An experiment of 2 x 2 x 3 samples of few scenarios.
const OWN: &str = "version = 1
samples = 3
matchmakers = [\"best\", \"lowest\"]
vary = { buffer = [1, 4] }
engine = { workers = 2 }
[[models]]
name = \"small\"
fixed = { mesh = \"builtin:tracked?triangles=3000\", depth = 4 }
moving = { mesh = \"builtin:car?triangles=2000\", depth = 3 }
scenarios = { random = { count = 9 } }
";

/// The lines of `points.jsonl` that have a sample.
fn samples(out: &Path) -> Vec<Value> {
    let text = fs::read_to_string(out.join("points.jsonl")).unwrap_or_default();
    let whole = &text[..text.rfind('\n').map_or(0, |at| at + 1)];
    let lines = whole.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter_map(|line| line.get("sample").cloned()).collect()
}

/// Which sample of which point.
fn steps(samples: &[Value]) -> Vec<String> {
    let step = |one: &Value| {
        ["models", "at", "matchmaker", "sample"].map(|key| one[key].to_string()).join(" ")
    };
    let mut steps: Vec<String> = samples.iter().map(step).collect();
    steps.sort();
    steps
}

/// Runs one of the paper's on small models, and says what came out of it.
fn measured(place: &Place, name: &str, more: &[&str]) -> Value {
    let out = place.text("out");
    let one = ["experiment", name, "--samples", "1", "--json", "--out", &out];
    let output = place.run(&[&one[..], &SMALL, more].concat());
    succeeded(&output);
    let outcome: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(outcome, json(&Path::new(&out).join("experiment.json")));
    assert_eq!((&outcome["kind"], &outcome["schema_version"]), (&"experiment".into(), &1.into()));
    assert_eq!(outcome["points"].as_array().unwrap()[..], samples(Path::new(&out))[..]);
    for figure in outcome["figures"].as_array().unwrap() {
        let file = format!("{}.svg", figure["name"].as_str().unwrap());
        let svg = fs::read_to_string(Path::new(&out).join(&file)).unwrap();
        assert!(svg.contains("<svg") && svg.contains(figure["y"]["label"].as_str().unwrap()));
    }
    outcome
}

/// Every matchmaker at so many values, with the answers of `bumper run`.
fn is_whole(place: &Place, outcome: &Value, values: usize) {
    let points = outcome["points"].as_array().unwrap();
    let mut steps = steps(points);
    steps.dedup();
    assert_eq!((points.len(), steps.len()), (values * 4, values * 4));
    let run = ["run", "--json", "--workers", "1", "--transport", "threads"];
    let run = place.run(&[&run[..], &SMALL[2..]].concat());
    succeeded(&run);
    let pairs = serde_json::from_str::<Value>(&stdout(&run)).unwrap()["pairs"].clone();
    assert!(pairs.as_u64().unwrap() > 0);
    for point in points.iter().filter(|point| point["scenarios"] == 9) {
        assert_eq!(point["pairs"], pairs, "{point}");
    }
    for point in points {
        assert!(point["parallel"]["relative_data_transfer"].as_f64().unwrap() > 0.0, "{point}");
        let time = |key: &str| point["parallel"][key].as_f64().unwrap();
        let speedup = time("weighted_serial_s") / time("parallel_s");
        assert!((time("speedup") - speedup).abs() <= 1e-9 * speedup, "{point}");
    }
    let figures = outcome["figures"].as_array().unwrap();
    assert_eq!(figures.len(), 2, "speedup and data transfer");
    for (figure, lines) in figures.iter().zip([5, 4]) {
        let series = figure["series"].as_array().unwrap();
        assert_eq!(series.len(), lines, "the matchmakers, and what is best possible");
        assert!(series.iter().all(|one| one["points"].as_array().unwrap().len() == values));
    }
}

#[test]
fn the_serial_experiment_has_no_engine() {
    let place = Place::new();
    let outcome = measured(&place, "serial", &[]);
    let points = outcome["points"].as_array().unwrap();
    let scenarios: Vec<u64> = points.iter().map(|p| p["scenarios"].as_u64().unwrap()).collect();
    assert_eq!(scenarios, [2, 4, 5, 7, 9], "20 to 100 percent");
    assert!(points.iter().all(|point| point.get("parallel").is_none()));
    assert_eq!(outcome["tables"][0]["rows"].as_array().unwrap().len(), 5);
}

#[test]
fn the_amount_of_scenarios_is_varied() {
    let place = Place::new();
    is_whole(&place, &measured(&place, "scenarios", &["--workers", "2"]), 5);
}

#[test]
fn the_depth_is_varied() {
    let place = Place::new();
    is_whole(&place, &measured(&place, "depth", &["--workers", "2"]), 7);
}

#[test]
fn the_buffer_is_varied() {
    let place = Place::new();
    is_whole(&place, &measured(&place, "buffer", &["--workers", "2"]), 7);
}

#[test]
fn the_workers_are_varied_beyond_the_cores() {
    let place = Place::new();
    let outcome = measured(&place, "units", &[]);
    is_whole(&place, &outcome, 6);
    let workers = |point: &Value| point["parallel"]["workers"].as_u64().unwrap();
    let most = outcome["points"].as_array().unwrap().iter().map(workers).max();
    assert_eq!(most, Some(8));
    let cores = outcome["machine"]["cores"].as_u64().unwrap();
    let notes = outcome["notes"].to_string();
    assert_eq!(notes.contains("more workers than"), cores < 8, "{notes}");
}

#[test]
fn geometry_in_place_is_not_said_to_be_transferred() {
    let place = Place::new();
    let own = place.write("own.toml", OWN);
    let out = place.text("out");
    let run = ["experiment", &own, "--transport", "threads", "--samples", "1", "--out", &out];
    let output = place.run(&run);
    succeeded(&output);
    let words = stdout(&output);
    assert!(words.contains("no subtree is sent") && words.contains("best possible"), "{words}");
    for sample in samples(Path::new(&out)) {
        assert_eq!(sample["parallel"]["bytes_sent"], 0);
    }
    assert!(!Path::new(&out).join("own-small-relative-data-transfer.svg").exists());
    assert!(Path::new(&out).join("own-small-speedup.svg").exists());
}

#[test]
fn an_experiment_that_is_killed_again_and_again_has_every_sample_once() {
    let place = Place::new();
    let own = place.write("own.toml", OWN);
    let (out, folder) = (place.path("out"), place.text("out"));
    let resume = ["experiment", &own, "--out", &folder, "--resume"];
    let mut kept = String::new();
    for wanted in [1, 3, 6, 9] {
        let mut child = start(&place, &resume);
        wait_until(&mut child, || samples(&out).len() >= wanted);
        child.kill().unwrap();
        child.wait().unwrap();
        let now = fs::read_to_string(out.join("points.jsonl")).unwrap();
        assert!(now.starts_with(&kept), "what was there stays");
        kept = now[..=now.rfind('\n').unwrap()].to_owned();
        // As if it had been killed in the middle of a line.
        fs::write(out.join("points.jsonl"), format!("{kept}{{\"sample\":{{\"mod")).unwrap();
    }
    let output = place.run(&resume);
    succeeded(&output);
    let all = fs::read_to_string(out.join("points.jsonl")).unwrap();
    assert!(all.starts_with(&kept));
    let mut steps = steps(&samples(&out));
    steps.dedup();
    assert_eq!((samples(&out).len(), steps.len()), (12, 12));
    let again = place.run(&resume);
    succeeded(&again);
    assert_eq!(stdout(&again), stdout(&output), "nothing is left to be measured");
    assert_eq!(fs::read_to_string(out.join("points.jsonl")).unwrap(), all);
}

#[test]
fn ctrl_c_keeps_the_samples_and_says_how_to_go_on() {
    let place = Place::new();
    let own = place.write("own.toml", &OWN.replace("samples = 3", "samples = 1000"));
    let (out, folder) = (place.path("out"), place.text("out"));
    let mut child = start(&place, &["experiment", &own, "--out", &folder]);
    wait_until(&mut child, || samples(&out).len() >= 2);
    let output = interrupt(child);
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    let kept = samples(&out);
    let words = format!("{} of 4000 samples", kept.len());
    assert!(stderr(&output).contains(&words) && stderr(&output).contains("--resume"), "{words}");
    let outcome = json(&out.join("experiment.json"));
    assert_eq!(outcome["points"].as_array().unwrap()[..], kept[..]);
    assert!(outcome["notes"].to_string().contains("not finished"));
    assert!(stdout(&output).contains("not finished"));
}

#[test]
fn samples_of_something_else_are_not_mixed_in() {
    let place = Place::new();
    let (own, folder) = (place.write("own.toml", OWN), place.text("out"));
    let short = ["experiment", own.as_str(), "--out", &folder, "--samples", "1"];
    succeeded(&place.run(&short));
    let whole = fs::read(place.path("out/points.jsonl")).unwrap();
    refused(&place.run(&short), 2, &["out", "--resume"]);
    let resume = |arguments: &[&str]| place.run(&[&short[..], &["--resume"], arguments].concat());
    refused(&resume(&["--samples", "2"]), 2, &["cannot be used multiple times"]);
    refused(&resume(&["--workers", "1"]), 2, &["`models.0.workers` was 2 and is 1"]);
    refused(&resume(&["--transport", "socket"]), 2, &["transport` was \"pipe\" and is \"socket\""]);
    refused(&resume(&["--count", "5"]), 2, &["count` was 9 and is 5"]);
    refused(&resume(&["--fixed", CAR]), 2, &["fixed.mesh` was", "car?triangles=2000"]);
    let other = ["experiment", "depth", "--out", &folder, "--resume"];
    refused(
        &place.run(&other),
        2,
        &["of another experiment", "`name` was \"own\" and is \"depth\""],
    );
    let lines = fs::read_to_string(place.path("out/points.jsonl")).unwrap();
    for (there, words) in [
        ("\"bumper\":\"0.0.9\"", "`versions.bumper` was \"0.0.9\""),
        ("\"tree_image\":0", "`versions.tree_image` was 0"),
        ("\"cores\":9999", "`cores` was 9999"),
    ] {
        let key = &there[..there.find(':').unwrap()];
        let at = lines.find(key).unwrap();
        let end = at + lines[at..].find([',', '}']).unwrap();
        let altered = format!("{}{there}{}", &lines[..at], &lines[end..]);
        fs::write(place.path("out/points.jsonl"), &altered).unwrap();
        refused(&resume(&[]), 2, &["of another experiment", words]);
        assert_eq!(fs::read_to_string(place.path("out/points.jsonl")).unwrap(), altered);
    }
    fs::write(place.path("out/points.jsonl"), whole).unwrap();
    succeeded(&resume(&[]));
}

#[test]
fn files_that_have_changed_since_are_not_mixed_in() {
    let place = Place::new();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    place.write("mesh.obj", obj);
    let own = OWN
        .replace("builtin:tracked?triangles=3000", "mesh.obj")
        .replace("random = { count = 9 }", "poses = \"poses.csv\"");
    let own = place.write("own.toml", &own);
    let poses = format!("{HEADER}1,0,0,0,0.5,0,0\n1,0,0,0,0,0.5,0\n");
    place.write("poses.csv", &poses);
    let (out, folder) = (place.path("out"), place.text("out"));
    let resume = ["experiment", &own, "--out", &folder, "--resume"];
    succeeded(&place.run(&resume));
    let text = fs::read_to_string(out.join("points.jsonl")).unwrap();
    let last = text.trim_end().rfind('\n').unwrap() + 1;
    fs::write(out.join("points.jsonl"), &text[..last]).unwrap();
    place.write("mesh.obj", &obj.replace("v 1 0 0", "v 2 0 0"));
    refused(&place.run(&resume), 2, &["other models", "small"]);
    place.write("mesh.obj", obj);
    place.write("poses.csv", &poses.replace("0.5,0,0", "0.25,0,0"));
    refused(&place.run(&resume), 2, &["other models", "small"]);
    place.write("poses.csv", &poses);
    succeeded(&place.run(&resume));
    assert_eq!(samples(&out).len(), 12);
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_is_written() {
    let place = Place::new();
    let folder = place.text("out");
    let refuse = |arguments: &[&str], words: &[&str]| {
        let output = place.run(&[&["experiment", "--out", &folder], arguments].concat());
        refused(&output, 2, words);
    };
    refuse(&["figure-11"], &["figure-11", "serial, scenarios, depth, buffer, units"]);
    refuse(&["depth", "--models", "truck"], &["truck", "heavy-car, car-car"]);
    refuse(&["depth", "--fixed", CAR], &["one pair of models", "--models heavy-car"]);
    refuse(&["units", "--workers", "2"], &["--workers", "varies"]);
    refuse(&["serial", "--transport", "pipe"], &["without an engine"]);
    let own = place.write("own.toml", &OWN.replace("buffer = [1, 4]", "buffer = [4, 1]"));
    refuse(&[&own], &["own.toml:4", "vary.buffer"]);
    let spaced = place.write("my own.toml", OWN);
    refuse(&[&spaced], &["my own.toml", "letters, digits"]);
    assert!(!Path::new(&folder).exists());
}

#[test]
fn the_commands_of_the_readme_run() {
    let readme = include_str!("../../README.md");
    for command in ["bumper experiment depth", "bumper experiment depth --resume"] {
        assert!(readme.contains(&format!("\n{command}\n")), "{command}");
    }
    let place = Place::new();
    let short = [&SMALL[..], &["--samples", "1", "--workers", "1"]].concat();
    for more in [&[][..], &["--resume"]] {
        let mut command = place.bumper(&[&["experiment", "depth"], &short[..], more].concat());
        succeeded(&command.current_dir(place.0.path()).output().unwrap());
    }
    assert!(place.path("experiment-depth/experiment.json").exists());
}
