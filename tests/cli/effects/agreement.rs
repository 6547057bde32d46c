//! Results do not depend on who computes them, and how.

use std::time::{Duration, Instant};

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

/// Which of two triangles that collide at the same time is the first one is the tree's to choose, and
/// with it the point of the impact and what follows from that; and a search may end anywhere within
/// the tolerance.
#[test]
fn every_kind_of_tree_gives_the_same_answers() {
    const SAME: [&str; 18] = [
        "colliding",
        "pairs",
        "pairs_fnv1a64",
        "contact_curves",
        "closed_contact_curves",
        "contact_length_m",
        "segment_error_m",
        "containment",
        "clearance_m",
        "near_pairs",
        "penetration_depth_m",
        "penetration_free_at_m",
        "least_translation_m",
        "overlap_volume_m3",
        "motion",
        "contact_intervals",
        "contact_known_until_s",
        "energy_rises",
    ];
    let place = Place::new();
    let text = fs::read_to_string(scene(&place, &everything())).unwrap();
    let of_kind = |kind: &str| {
        let tree = format!("[tree]\nkind = '{kind}'\n[scenarios]");
        let scene = place.write("kind.toml", &text.replace("[scenarios]", &tree));
        Run::of(&place, &scene, &[])
    };
    let wide = of_kind("wide");
    for kind in ["obb", "aabb"] {
        let other = of_kind(kind);
        for column in SAME {
            assert_eq!(other.cells(column), wide.cells(column), "{kind}: {column}");
        }
        for table in ["segments", "curves", "near_pairs"] {
            assert!(other.tables[table] == wide.tables[table], "{kind}: {table}");
        }
        // The tolerance of 0.1 mm over the speed of 15 m/s along the normals.
        let times = wide.numbers("impact_time_s").into_iter().zip(other.numbers("impact_time_s"));
        for (expected, found) in times {
            assert_eq!(expected.is_some(), found.is_some());
            near(found.unwrap_or_default(), expected.unwrap_or_default(), 1e-4);
        }
    }
}

/// Processes whose command line has this in it.
fn processes(of: &str) -> Vec<String> {
    let all = fs::read_dir("/proc")
        .unwrap()
        .filter_map(|entry| entry.unwrap().file_name().into_string().ok());
    let is_ours = |pid: &String| {
        let line = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        line.windows(of.len()).any(|window| window == of.as_bytes())
    };
    all.filter(|name| name.bytes().all(|byte| byte.is_ascii_digit())).filter(is_ours).collect()
}

#[test]
fn a_killed_worker_changes_no_result() {
    let place = Place::new();
    let scene = scene(&place, &everything());
    let poses = fs::read_to_string(place.path("p.csv")).unwrap();
    let again = poses.split_once('\n').unwrap().1.repeat(3);
    place.write("p.csv", &format!("{HEADER}{again}"));
    let out = place.text("killed");
    let mut arguments = vec!["run", &scene, "--no-cache", "--workers", "2", "--out", &out];
    // So slow that it is at work when it is killed, and with little of it at a time.
    arguments.extend(["--slowdowns", "3,3", "--buffer-scenarios", "2"]);
    let mut command = place.bumper(&arguments);
    let mut master = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    let rows = || fs::read_to_string(place.path("killed/scenarios.csv")).unwrap_or_default();
    while rows().lines().count() < 4 {
        assert!(begin.elapsed() < Duration::from_secs(60), "no result came");
        std::thread::sleep(Duration::from_millis(1));
    }
    // Workers are told of their run's directory, the master is not.
    let workers = processes(&place.text("runtime"));
    assert_eq!(workers.len(), 2, "{workers:?}");
    let killed = Command::new("kill").args(["-KILL", &workers[0]]).status().unwrap();
    assert!(killed.success() && rows().lines().count() < 18, "it was over before");
    assert!(master.wait().unwrap().success());
    let run = Run::read(&place.path("killed"));
    let reports = run.summary["worker_reports"].as_array().unwrap().iter();
    assert_eq!(reports.map(|report| report["restarts"].as_u64().unwrap()).sum::<u64>(), 1);
    let calm = Run::of(&place, &scene, &[]);
    assert!(run.csv == calm.csv && run.tables == calm.tables);
    // The same scenarios three times.
    let first: Vec<_> = run.rows.iter().map(|row| &row[1..]).collect();
    assert!((6..18).all(|row| first[row] == first[row % 6]));
}
