//! Results do not depend on who computes them, and how.

use std::time::Duration;

use super::free::{everything, scene};
use super::*;

#[test]
fn every_transport_and_number_of_workers_gives_the_same_bytes() {
    let place = Place::new();
    let scene = scene(&place, &everything());
    let run = |arguments: &[&str]| {
        let run = Run::of(&place, &scene, arguments);
        (run.csv, run.tables)
    };
    let expected = run(&["--workers", "1"]);
    for workers in ["2", "3"] {
        assert!(run(&["--workers", workers]) == expected, "{workers} workers");
    }
    for transport in ["threads", "pipe", "socket"] {
        assert!(run(&["--transport", transport]) == expected, "{transport}");
    }
    assert!(run(&["--start-from", "root-pairs"]) == expected, "from pairs of subtrees");
}
