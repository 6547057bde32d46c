//! `bumper bench`: short forms, with real workers. What is timed is not asserted, what is answered is.

use std::fs;

use serde_json::Value;

use super::{CAR, Place, stdout, succeeded};

const README: &str = include_str!("../../README.md");

/// A command of the README, with more arguments, so that it takes less time.
fn in_short(place: &Place, command: &str, more: &[&str]) -> String {
    assert!(README.contains(&format!("\n{command}\n")), "{command}");
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let output = place.run(&[&words[..], more].concat());
    succeeded(&output);
    stdout(&output)
}

#[test]
fn every_transport_hands_over_what_it_is_given() {
    let place = Place::new();
    let figure = place.path("latency.svg");
    let sizes = ["--seconds", "0.01", "--bytes", "64,100000,1000000"];
    let forms = ["--json", "--svg", figure.to_str().unwrap()];
    let words = in_short(&place, "bumper bench transport", &[&sizes[..], &forms].concat());
    let report: Value = serde_json::from_str(&words).unwrap();
    assert_eq!(report["schema_version"], 1);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4 * 3 * 3, "transports, ways to wake up, sizes");
    for row in rows {
        let time = |key: &str, q: &str| row[key][q].as_f64().unwrap();
        assert!(row["count"].as_u64().unwrap() >= 30, "{row}");
        assert!(0.0 < time("one_way", "median"), "{row}");
        assert!(time("one_way", "median") <= time("one_way", "p99_9"), "{row}");
        assert!(time("one_way", "median") <= time("round_trip", "p99_9"), "{row}");
        let is_shared = ["iceoryx2", "threads"].contains(&row["transport"].as_str().unwrap());
        assert_eq!(row["publish_us"].as_f64().unwrap() > 0.0, is_shared, "{row}");
    }
    let svg = fs::read_to_string(figure).unwrap();
    assert!(svg.contains("<svg") && svg.contains("iceoryx2, block"), "{svg}");
}

#[test]
fn every_transport_and_matchmaker_is_measured_on_the_same_scenarios() {
    let place = Place::new();
    let figure = place.path("engine.svg");
    let small = ["--fixed", "builtin:tracked?triangles=2000", "--moving", CAR, "--count", "40"];
    let short = ["--worker-counts", "1,2", "--seconds", "0.01"];
    let forms = ["--json", "--svg", figure.to_str().unwrap()];
    let words = in_short(&place, "bumper bench engine", &[&small[..], &short, &forms].concat());
    let report: Value = serde_json::from_str(&words).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4 * 4 * 2, "transports, matchmakers, workers");
    for row in rows {
        assert!(row["scenarios_per_s"].as_f64().unwrap() > 0.0, "{row}");
        let is_shared = ["iceoryx2", "threads"].contains(&row["transport"].as_str().unwrap());
        assert_eq!(row["relative_data_transfer"].as_f64().unwrap() == 0.0, is_shared, "{row}");
    }
    assert!(fs::read_to_string(figure).unwrap().contains("scenarios / s"));
    let one = ["--over", "threads", "--match-rules", "best", "--worker-counts", "1"];
    let table = in_short(&place, "bumper bench engine", &[&small[..], &short[2..], &one].concat());
    assert!(table.contains("over serial") && table.contains("threads"), "{table}");
}
