//! `bumper cluster`: tiny meshes, simulated on clusters of a few nodes. What is recorded differs from run
//! to run; what a recording is simulated to does not.

use std::fs;

use serde_json::Value;

use super::{CAR, Place, TRACKED, json, refused, stderr, stdout, succeeded};

const CLUSTERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/config/clusters");
const README: &str = include_str!("../../README.md");

/// Two fast nodes and a slow one, with a scene beside it.
fn small(place: &Place, more: &str) -> String {
    place.write(
        "scene.toml",
        &format!(
            "version = 1\nfixed = {{ mesh = \"{TRACKED}\" }}\nmoving = {{ mesh = \"{CAR}\" }}\n\
             scenarios = {{ random = {{ count = 40 }} }}\n"
        ),
    );
    let text = format!(
        "version = 1\nname = \"small\"\nscene = \"scene.toml\"\n\
         nodes = [{{ count = 2, cores = 2 }}, {{ count = 1, cores = 1, speed = 0.5 }}]\n\
         link = {{ gigabits_per_s = 1.0, latency_us = 50.0 }}\n\
         [run]\nscenarios = 80\ndepths = [5, 3]\nbuffer = {{ scenarios = 4 }}\n\
         matchmakers = [\"best\", \"random\", \"lowest\", \"best-load\"]\nsamples = 2\n{more}"
    );
    place.write("small.toml", &text)
}

#[test]
fn a_cluster_is_simulated_from_a_recording_of_the_scene() {
    let place = Place::new();
    let sweeps = "[sweep]\nscenarios = [40, 80]\ndepths = [2, 5]\nbuffer = [1, 4]\n\
                  nodes = [[1, 0], [2, 0], [2, 1]]\n";
    let config = small(&place, sweeps);
    let (out, recording) = (place.path("out"), place.path("recording.json"));
    let options = ["--out", out.to_str().unwrap(), "--recording", recording.to_str().unwrap()];
    let output = place.run(&[&["cluster", &config][..], &options].concat());
    succeeded(&output);
    let words = stdout(&output);
    assert!(words.contains("by processing units") && words.contains("best: "), "{words}");

    let report = json(&out.join("cluster.json"));
    assert_eq!((&report["kind"], &report["schema_version"]), (&"cluster".into(), &1.into()));
    let points = report["points"].as_array().unwrap();
    assert_eq!(points.len(), 4 * (1 + 2 + 2 + 2 + 3), "matchmakers, values");
    for point in points {
        let samples = point["samples"].as_array().unwrap();
        assert_eq!(samples.len(), if point["matchmaker"] == "random" { 2 } else { 1 });
        for sample in samples {
            let value = |key: &str| sample[key].as_f64().unwrap();
            assert!(value("speedup") <= value("speedup_bound") + 1e-6, "{sample}");
            // Messages have headers, and vertices that subtrees share are in each of them.
            let most = 1.3 * point["workers"].as_f64().unwrap();
            assert!((0.0..=most).contains(&value("relative_data_transfer")), "{sample}");
        }
    }
    assert_eq!(report["saturation"].as_array().unwrap().len(), 4, "one a matchmaker");
    for figure in report["figures"].as_array().unwrap() {
        let svg = fs::read_to_string(out.join(format!("{}.svg", figure["name"].as_str().unwrap())));
        assert!(svg.unwrap().contains("<svg"), "{figure}");
    }
    assert_eq!(report["figures"].as_array().unwrap().len(), 4 * 2 + 1);

    // The same recording comes to the same.
    let again = place.run(&[&["cluster", &config, "--json"][..], &options].concat());
    succeeded(&again);
    assert!(!stderr(&again).contains("made anew"), "{}", stderr(&again));
    let again: Value = serde_json::from_str(&stdout(&again)).unwrap();
    assert_eq!(again["points"], report["points"]);
}

#[test]
fn a_recording_of_something_else_is_made_anew() {
    let place = Place::new();
    let (config, kept) = (small(&place, ""), place.text("kept.json"));
    succeeded(&place.run(&["cluster", &config, "--recording", &kept]));
    let first = fs::read_to_string(&kept).unwrap();
    // A depth that it does not have.
    let deeper = fs::read_to_string(&config).unwrap().replace("[5, 3]", "[6, 3]");
    let output =
        place.run(&["cluster", &place.write("deeper.toml", &deeper), "--recording", &kept]);
    succeeded(&output);
    assert!(stderr(&output).contains("made anew"), "{}", stderr(&output));
    assert_ne!(fs::read_to_string(&kept).unwrap(), first);
}

#[test]
fn damaged_recordings_are_refused() {
    let place = Place::new();
    let (config, kept) = (small(&place, ""), place.text("kept.json"));
    succeeded(&place.run(&["cluster", &config, "--recording", &kept]));
    let good: Value = json(&place.path("kept.json"));
    let damaged = |damage: &dyn Fn(&mut Value)| {
        let mut value = good.clone();
        damage(&mut value);
        place.write("kept.json", &value.to_string());
        let output = place.run(&["cluster", &config, "--recording", &kept]);
        refused(&output, 2, &["kept.json", "recording"]);
    };
    damaged(&|value| value["serial_ns"] = Value::Array(Vec::new()));
    damaged(&|value| value["cuts"][0]["scenarios"]["below_ns"][0] = (-1).into());
    damaged(&|value| value["cuts"][0]["scenarios"]["roots"][0]["numbers"][0] = 1_000_000.into());
    damaged(&|value| value["cuts"][0]["scenarios"]["roots"][0]["counts"][0] = 1_000_000.into());
    damaged(&|value| drop(value["cuts"][0]["subtrees"][1]["bytes"].as_array_mut().unwrap().pop()));
    damaged(&|value| value["cuts"][0]["subtrees"][0]["bytes"][0] = 0.into());
    damaged(&|value| value["surprise"] = 1.into());
}

#[test]
fn shared_memory_in_a_node_and_compression_send_less() {
    let place = Place::new();
    let variants = "copies = [\"process\", \"node\"]\ncompression = [\"none\", \"lz4\"]\n";
    let config = small(&place, variants);
    let output = place.run(&["cluster", &config, "--json"]);
    succeeded(&output);
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let sent = |copies: &str, compression: &str| {
        let is_it = |point: &&Value| {
            point["matchmaker"] == "best"
                && point["copies"] == copies
                && point["compression"] == compression
        };
        let point = report["points"].as_array().unwrap().iter().find(is_it).unwrap();
        point["samples"][0]["bytes_sent"].as_f64().unwrap()
    };
    assert!(sent("node", "none") < sent("process", "none"));
    assert!(sent("node", "lz4") < sent("node", "none"));
    assert!(sent("process", "lz4") < sent("process", "none"));
}

/// As slowed workers of the engine do: time for scenarios, and for nothing else.
#[test]
fn slowed_scenarios_take_longer_and_cost_the_master_nothing() {
    let place = Place::new();
    let (config, kept) =
        (small(&place, "[scale]\nanalysis = \"unscaled\"\n"), place.text("kept.json"));
    let plain = fs::read_to_string(&config).unwrap();
    let slowed = place.write("slowed.toml", &(plain + "slowdown = 50.0\n"));
    let sample = |config: &str| {
        let output = place.run(&["cluster", config, "--recording", &kept, "--json"]);
        succeeded(&output);
        let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
        let sample = &report["points"][0]["samples"][0];
        let number = |value: &Value| value.as_f64().unwrap();
        let time = number(&sample["time_s"]);
        let used = &sample["utilisation"];
        let analysis = number(&used["master_analysis"]) * time;
        // The first is what a serial run takes.
        (number(&sample["over_first"]) * time, analysis)
    };
    let (plain, slowed) = (sample(&config), sample(&slowed));
    assert!((slowed.0 / plain.0 - 50.0).abs() < 0.01, "{plain:?} {slowed:?}");
    assert!((slowed.1 / plain.1 - 1.0).abs() < 0.01, "{plain:?} {slowed:?}");
}

/// A configuration of ours with a scene of few scenarios and tiny meshes, fewer of them, and one value in
/// each sweep.
fn in_short(place: &Place, name: &str, tree: &str) -> String {
    small(place, "");
    let scene = fs::read_to_string(place.path("scene.toml")).unwrap();
    let scene =
        place.write("short_scene.toml", &format!("{scene}tree = {{ kind = \"{tree}\" }}\n"));
    let text = fs::read_to_string(format!("{CLUSTERS}/{name}")).unwrap();
    let line = |line: &str| match line.split_once(" = ") {
        Some(("scene", _)) => String::new(),
        Some(("name", name)) => format!("name = {name}\nscene = \"{scene}\""),
        Some(("scenarios", list)) if list.starts_with('[') => "scenarios = [40]".to_owned(),
        Some(("scenarios", _)) => "scenarios = 40".to_owned(),
        Some(("depths", list)) if list.contains("14") => "depths = [5]".to_owned(),
        Some(("depths", _)) => "depths = [5, 3]".to_owned(),
        _ => line.to_owned(),
    };
    place.write(name, &text.lines().map(|text| line(text) + "\n").collect::<String>())
}

/// What a command of the README prints, with a file of its own and more arguments.
fn shortened(place: &Place, command: &str, config: &str, more: &[&str]) -> String {
    assert!(README.contains(&format!("\n{command}\n")), "{command}");
    let words = command.split_whitespace().skip(1);
    let words = words.map(|word| match word {
        word if word.ends_with(".toml") => config.to_owned(),
        "results" => place.text("results"),
        word => word.to_owned(),
    });
    let words: Vec<_> = words.collect();
    let words: Vec<&str> = words.iter().map(String::as_str).chain(more.iter().copied()).collect();
    let output = place.run(&words);
    succeeded(&output);
    stdout(&output)
}

#[test]
fn the_papers_cluster_is_simulated_in_all_four_sweeps() {
    let place = Place::new();
    let command = "bumper cluster config/clusters/paper.toml --out results";
    let config = in_short(&place, "paper.toml", "obb");
    let words = shortened(&place, command, &config, &[]);
    for sweep in ["by amount of scenarios", "by depth", "by size of", "by processing units"] {
        assert!(words.contains(sweep), "{words}");
    }
    assert!(place.path("results/paper-units-speedup.svg").exists());
    let report = json(&place.path("results/cluster.json"));
    let last = report["points"].as_array().unwrap().last().unwrap();
    assert_eq!((&last["workers"], last["x"].as_f64().unwrap().round()), (&28.into(), 25.0));
    let boxes = place
        .write("boxes.toml", &fs::read_to_string(&config).unwrap().replace("short_scene", "scene"));
    refused(&place.run(&["cluster", &boxes]), 2, &["scale.analysis", "obb", "wide"]);
}

#[test]
fn the_simulation_is_held_against_the_engine() {
    let place = Place::new();
    let command = "bumper cluster config/clusters/this_machine.toml --validate";
    let config = in_short(&place, "this_machine.toml", "wide");
    let words = shortened(&place, command, &config, &["--json"]);
    let report: Value = serde_json::from_str(&words).unwrap();
    let rows = report["validation"].as_array().unwrap();
    let transports: Vec<_> = rows.iter().map(|row| row["transport"].as_str().unwrap()).collect();
    assert_eq!(transports, ["pipe", "iceoryx2"]);
    for row in rows {
        for key in ["simulated_s", "best_s", "median_s"] {
            assert!(row[key].as_f64().unwrap() > 0.0, "{row}");
        }
    }
    let elsewhere = small(&place, "");
    refused(&place.run(&["cluster", &elsewhere, "--validate"]), 2, &["--validate", "one node"]);
}

#[test]
fn a_configuration_that_makes_no_sense_is_refused_with_its_line_and_key() {
    let place = Place::new();
    let good = fs::read_to_string(small(&place, "")).unwrap();
    let wrong = |from: &str, to: &str, words: &[&str]| {
        assert!(good.contains(from), "{from}");
        let config = place.write("wrong.toml", &good.replacen(from, to, 1));
        refused(&place.run(&["cluster", &config]), 2, &[&["wrong.toml"], words].concat());
    };
    wrong("version = 1", "version = 7", &["version", "7"]);
    wrong("\"small\"", "\"../small\"", &["name", "stem"]);
    wrong("count = 2", "count = 0", &["nodes.count"]);
    wrong("cores = 2", "cores = 200000", &["nodes.cores"]);
    wrong("speed = 0.5", "speed = -0.5", &["nodes.speed"]);
    wrong("gigabits_per_s = 1.0", "gigabits_per_s = 0.0", &["link.gigabits_per_s"]);
    wrong("latency_us", "latency", &["latency", "did you mean `latency_us`"]);
    wrong("scenarios = 80", "scenarios = 0", &["run.scenarios"]);
    wrong("[5, 3]", "[5, 99]", &["run.depths", "99"]);
    wrong("scenarios = 4", "scenarios = 0", &["run.buffer.scenarios"]);
    wrong("\"random\", ", "\"best\", ", &["run.matchmakers", "twice"]);
    wrong("samples = 2", "samples = 0", &["run.samples"]);
    wrong("samples = 2", "samples = 2\n[sweep]\nnodes = [[3, 0]]", &["sweep.nodes"]);
    wrong("samples = 2", "samples = 2\n[scale]\nserial_s = [2.0, 1.0]", &["scale.serial_s"]);
    wrong(
        "samples = 2",
        "copies = [\"node\"]\n[memory]\nbegin_on_master = true",
        &["run.copies", "begin_on_master"],
    );
    refused(&place.run(&["cluster", &place.text("nowhere.toml")]), 1, &["nowhere.toml"]);
}
