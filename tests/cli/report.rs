//! `bumper report`: outputs of real commands, read back and shown.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::{CAR, Place, TRACKED, refused, stdout, succeeded};

/// What `bumper experiment` and `bumper cluster` have in common.
fn measured(kind: &str, name: &str) -> String {
    json!({
        "schema_version": 1,
        "kind": kind,
        "name": name,
        "versions": { "bumper": "0.1.0" },
        "machine": { "cpu": "one", "cores": 2 },
        "figures": [{
            "name": format!("{kind}_speedup"),
            "title": "Speedup",
            "x": { "label": "processing units", "scale": "linear" },
            "y": { "label": "speedup", "scale": "linear" },
            "series": [{ "name": name, "points": [{ "x": 1.0, "y": 1.0 }, { "x": 2.0, "y": 1.9 }] }]
        }],
        "tables": [{ "title": "Serial", "columns": ["scenarios", "s"], "rows": [["10", name]] }]
    })
    .to_string()
}

fn make_run(place: &Place) {
    succeeded(&place.run_small(&["--out", &place.text("results"), "--transport", "threads"]));
}

/// The raw JSON in a page, parsed.
fn embedded(page: &str) -> Vec<Value> {
    let parts = page.split("<script type=\"application/json\"").skip(1);
    let json = |part: &str| {
        let (text, _) = part.split_once('>').unwrap().1.split_once("</script>").unwrap();
        serde_json::from_str(text).unwrap()
    };
    parts.map(json).collect()
}

#[test]
fn outputs_of_every_command_become_one_page() {
    let place = Place::new();
    make_run(&place);
    let small = ["--fixed", TRACKED, "--moving", CAR, "--count", "4"];
    let (accuracy, bench) = (place.text("levels"), place.text("bench"));
    let levels = ["accuracy", "--levels", "f32,boxes(3)", "--out", &accuracy];
    succeeded(&place.run(&[&levels[..], &small].concat()));
    let short = ["--seconds", "0.01", "--out", &bench];
    let one = ["bench", "transport", "--transport", "threads", "--bytes", "64,4096"];
    succeeded(&place.run(&[&one[..], &short].concat()));
    let one = ["bench", "engine", "--over", "threads", "--match-rules", "best"];
    succeeded(&place.run(&[&one[..], &short, &small, &["--worker-counts", "1"]].concat()));
    for kind in ["experiment", "cluster"] {
        fs::create_dir(place.path(kind)).unwrap();
        place.write(&format!("{kind}/{kind}.json"), &measured(kind, "best match"));
    }
    let folders = ["results", "levels", "bench", "experiment", "cluster"].map(|f| place.text(f));
    let folders: Vec<&str> = folders.iter().map(String::as_str).collect();
    let (page, figures) = (place.text("page.html"), place.text("figures"));
    let output =
        place.run(&[&["report"], &folders[..], &["--out", &page, "--svg", &figures]].concat());
    succeeded(&output);
    assert!(stdout(&output).contains("page.html: 13 figures"), "{}", stdout(&output));

    let page = fs::read_to_string(page).unwrap();
    let files = [
        "results/summary.json",
        "levels/accuracy.json",
        "bench/bench_transport.json",
        "bench/bench_engine.json",
        "experiment/experiment.json",
        "cluster/cluster.json",
    ];
    let written = files.map(|file| super::json(&place.path(file)));
    assert_eq!(embedded(&page), written, "unchanged, in the order of the directories");
    for (section, names) in [
        (1, &["compute_times", "pairs_of_scenarios", "workers", "stages"][..]),
        (2, &["accuracy", "depth"]),
        (3, &["latency", "bandwidth"]),
        (4, &["throughput", "speedup", "data_transfer"]),
        (5, &["experiment_speedup"]),
        (6, &["cluster_speedup"]),
    ] {
        for name in names {
            assert!(page.contains(&format!("<figure id=\"s{section}-{name}\">\n<svg")), "{name}");
            let svg = fs::read_to_string(place.path("figures").join(format!("{name}.svg")));
            assert!(svg.unwrap().starts_with("<svg"), "{name}");
        }
    }
    assert_eq!(fs::read_dir(figures).unwrap().count(), 13);
    for address in ["http:", "https:", "url(", "src="] {
        assert!(!page.contains(address), "nothing is asked of any network");
    }
    for svg in ["bench/latency.svg", "bench/throughput.svg", "levels/accuracy.svg"] {
        assert!(place.path(svg).exists(), "{svg} is written by its command");
    }
}

#[test]
fn figures_of_the_same_name_are_all_kept() {
    let place = Place::new();
    make_run(&place);
    let (results, figures) = (place.text("results"), place.text("figures"));
    let page = place.text("page.html");
    let twice = ["report", &results, &results, "--out", &page, "--svg", &figures];
    succeeded(&place.run(&twice));
    for name in ["stages.svg", "stages-2.svg", "workers.svg", "workers-2.svg"] {
        assert!(place.path("figures").join(name).exists(), "{name}");
    }
}

#[test]
fn hostile_names_stay_names() {
    let place = Place::new();
    let name = "</title></script><script>alert('<!--')</script>";
    fs::create_dir(place.path("hostile")).unwrap();
    place.write("hostile/cluster.json", &measured("cluster", name));
    let page = place.text("page.html");
    succeeded(&place.run(&["report", &place.text("hostile"), "--out", &page]));
    let page = fs::read_to_string(page).unwrap();
    assert_eq!(page.matches("<script").count(), 1, "the raw JSON");
    assert!(!page.contains("<!--"));
    assert_eq!(embedded(&page)[0]["name"], name);
    assert!(page.contains("&lt;script&gt;"));
}

#[test]
fn what_is_no_output_is_refused_and_nothing_is_written() {
    let place = Place::new();
    let page = place.text("page.html");
    let refuse = |folder: &str, words: &[&str]| {
        refused(&place.run(&["report", &place.text(folder), "--out", &page]), 1, words);
        assert!(!Path::new(&page).exists());
    };
    refuse("nowhere", &["nowhere", "No such file"]);
    place.write("file", "");
    refuse("file", &["file", "cannot be read"]);
    fs::create_dir(place.path("folder")).unwrap();
    refuse("folder", &["folder", "none of summary.json"]);
    let whole = measured("experiment", "units");
    place.write("folder/experiment.json", &whole[..whole.len() - 1]);
    refuse("folder", &["folder/experiment.json", "only a part"]);
    place.write(
        "folder/experiment.json",
        &whole.replace("\"schema_version\":1", "\"schema_version\":7"),
    );
    refuse("folder", &["folder/experiment.json", "schema_version 7"]);
    place.write("folder/experiment.json", &whole.replace("\"y\":1.9", "\"y\":1e300"));
    refuse("folder", &["folder/experiment.json", "point 1"]);
    refused(&place.run(&["report"]), 2, &["DIR"]);
}

#[test]
fn a_page_that_cannot_be_written_is_an_error() {
    let place = Place::new();
    fs::create_dir(place.path("one")).unwrap();
    place.write("one/cluster.json", &measured("cluster", "small"));
    let one = place.text("one");
    refused(&place.run(&["report", &one, "--out", "/dev/full"]), 1, &["/dev/full", "space"]);
    refused(
        &place.run(&["report", &one, "--out", &place.text("no/page.html")]),
        1,
        &["no/page.html"],
    );
}

/// The commands of the README, with fewer scenarios.
#[test]
fn the_commands_of_the_readme_make_the_example() {
    let readme = include_str!("../../README.md");
    let place = Place::new();
    // What other commands of it have made, tested by themselves.
    for (folder, kind) in [("results", "cluster"), ("experiment-depth", "experiment")] {
        fs::create_dir(place.path(folder)).unwrap();
        place.write(&format!("{folder}/{kind}.json"), &measured(kind, "depth"));
    }
    for (command, more) in [
        (
            "bumper run --out results/run",
            &["--fixed", TRACKED, "--moving", CAR, "--count", "20", "--workers", "2"][..],
        ),
        (
            "bumper accuracy config/accuracy/nearly.toml --out results/accuracy",
            &["--count", "2", "--levels", "f64"],
        ),
        (
            "bumper bench transport --out results/bench",
            &["--seconds", "0.01", "--bytes", "64,4096"],
        ),
        ("bumper report results/run results/accuracy results/bench results experiment-depth", &[]),
    ] {
        assert!(readme.contains(&format!("\n{command}\n")), "{command}");
        let words: Vec<&str> = command.split_whitespace().skip(1).collect();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let absolute = |word: &str| match word {
            word if word.starts_with("config/") => root.join(word).display().to_string(),
            word => word.to_owned(),
        };
        let words: Vec<String> = words.into_iter().map(absolute).collect();
        let words: Vec<&str> =
            words.iter().map(String::as_str).chain(more.iter().copied()).collect();
        succeeded(&place.bumper(&words).current_dir(place.path("")).output().unwrap());
    }
    let page = fs::read_to_string(place.path("report.html")).unwrap();
    assert_eq!(embedded(&page).len(), 5);
}
