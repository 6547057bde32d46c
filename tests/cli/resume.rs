//! Runs that go on after they were killed or interrupted.

use std::fs;
use std::path::Path;
use std::process::Child;
use std::time::Duration;

use super::interrupt::{interrupt, start};
use super::*;

const SCENARIOS: &str = "400";

/// What is run, with more arguments.
fn arguments<'a>(place: &Place, more: &[&'a str]) -> Vec<String> {
    let scene = place.write("scene.toml", &scene());
    let first = ["run".to_owned(), scene];
    first.into_iter().chain(more.iter().map(|&word: &&'a str| word.to_owned())).collect()
}

/// With tables of two kinds beside the contacts.
fn scene() -> String {
    format!(
        "version = 1\nfixed.mesh = \"{TRACKED}\"\nmoving.mesh = \"{CAR}\"\n\
         scenarios.random.count = {SCENARIOS}\n[effects]\nsegments = true\n"
    )
}

fn strs(words: &[String]) -> Vec<&str> {
    words.iter().map(String::as_str).collect()
}

/// Begins to write to `out`, so slowly that it can be stopped on its way, however fast the machine.
fn begin(place: &Place, out: &str) -> Child {
    let csv = Path::new(out).join("scenarios.csv");
    for slowdown in ["2,2", "16,16", "128,128", "1024,1024"] {
        let more = ["--workers", "2", "--slowdowns", slowdown, "--contacts", "--out", out];
        let mut child = start(place, &strs(&arguments(place, &more)));
        while child.try_wait().unwrap().is_none() {
            if fs::read_to_string(&csv).map_or(0, |text| text.lines().count()) >= 50 {
                return child;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        fs::remove_dir_all(out).unwrap();
    }
    panic!("too fast to be stopped");
}

fn files(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let names = ["scenarios.csv", "contacts.parquet", "segments.parquet", "curves.parquet"];
    names.map(|name| (name.to_owned(), fs::read(directory.join(name)).unwrap())).into()
}

fn undisturbed(place: &Place) -> BTreeMap<String, Vec<u8>> {
    let out = place.text("whole");
    let more = ["--workers", "2", "--contacts", "--out", &out];
    succeeded(&place.run(&strs(&arguments(place, &more))));
    files(&place.path("whole"))
}

#[test]
fn a_killed_run_goes_on_over_another_transport_to_the_same_bytes() {
    let place = Place::new();
    let expected = undisturbed(&place);
    let out = place.text("out");
    for transport in ["pipe", "threads"] {
        let _ = fs::remove_dir_all(&out);
        let mut child = begin(&place, &out);
        child.kill().unwrap();
        child.wait().unwrap();
        let csv = place.path("out/scenarios.csv");
        let before = fs::read_to_string(&csv).unwrap();
        // Torn in the middle of a row, as by a full disk.
        fs::write(&csv, &before[..before.len() - 5]).unwrap();
        let rows = before.lines().count() - 2;
        assert!((40..400).contains(&rows), "{rows}");
        assert!(!place.path("out/contacts.parquet").exists());

        let resumed = ["run", "--resume", &out, "--workers", "3", "--transport", transport];
        let output = place.run(&[&resumed[..], &["--json", "--slowdowns", "1"]].concat());
        succeeded(&output);
        assert!(files(&place.path("out")) == expected, "other bytes over {transport}");
        let summary = json(&place.path("out/summary.json"));
        assert_eq!(summary["scenarios"], 400);
        assert_eq!(summary["answered_before"], rows);
        let whole = json(&place.path("whole/summary.json"));
        for key in ["pairs", "colliding"] {
            assert_eq!(summary[key], whole[key], "{key}");
        }
        let left = fs::read_dir(place.path("out")).unwrap();
        let left: Vec<_> = left.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        assert!(!left.iter().any(|name| name.contains("rows") || name.contains("partial")));

        fs::rename(&out, place.path("results")).unwrap();
        let command: Vec<_> = "bumper run --resume results".split(' ').skip(1).collect();
        let output = place.bumper(&command).current_dir(place.path("")).output().unwrap();
        succeeded(&output);
        assert!(stdout(&output).contains("nothing is missing"), "{}", stdout(&output));
        fs::rename(place.path("results"), &out).unwrap();
    }
}

#[test]
fn an_interrupted_run_goes_on_with_its_scene_given_again() {
    let place = Place::new();
    let expected = undisturbed(&place);
    let out = place.text("out");
    let output = interrupt(begin(&place, &out));
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    agree(&place.path("out"));
    let scene = place.text("scene.toml");
    let fast = ["--slowdowns", "1", "--workers", "2"];
    succeeded(&place.run(&[&["run", &scene, "--resume", &out], &fast[..]].concat()));
    assert!(files(&place.path("out")) == expected);
    agree(&place.path("out"));
}

#[test]
fn what_is_not_the_run_that_began_is_refused_and_says_what_differs() {
    let place = Place::new();
    let mesh = place.path("car.stl");
    fs::write(&mesh, triangle_stl(1.0)).unwrap();
    let poses = place.write("poses.csv", &format!("{HEADER}{}", "1,0,0,0,0.1,0,0\n".repeat(9)));
    let (mesh, out) = (place.text("car.stl"), place.text("out"));
    let run = ["run", "--fixed", &mesh, "--moving", &mesh, "--poses", &poses, "--workers", "1"];
    succeeded(&place.run(&[&run[..], &["--out", &out]].concat()));
    // As if it had been killed before its last two rows and its summary.
    let csv = place.path("out/scenarios.csv");
    let text = fs::read_to_string(&csv).unwrap();
    let rows: Vec<_> = text.lines().take(8).collect();
    let unfinish = || {
        fs::write(&csv, rows.join("\n") + "\n").unwrap();
        let _ = fs::remove_file(place.path("out/summary.json"));
    };
    unfinish();
    let resume = ["run", "--resume", &out, "--workers", "1"];
    let with = |more: &[&str]| place.run(&[&resume[..], more].concat());

    refused(&with(&["--count", "5"]), 2, &["another scene", "`scenarios.first`"]);
    refused(&with(&["--accuracy", "f32"]), 2, &["another scene", "`accuracy`"]);
    refused(&with(&["--moving", CAR]), 2, &["another scene", "`moving.mesh`"]);
    let other = place.write("other.toml", &scene());
    refused(&place.run(&["run", &other, "--resume", &out]), 2, &["another scene", "`"]);

    fs::write(&mesh, triangle_stl(1.5)).unwrap();
    refused(&with(&[]), 1, &["cannot go on", "the fixed mesh"]);
    fs::write(&mesh, triangle_stl(1.0)).unwrap();
    fs::write(&poses, format!("{HEADER}{}", "1,0,0,0,0.2,0,0\n".repeat(9))).unwrap();
    refused(&with(&[]), 1, &["cannot go on", "a pose"]);
    fs::write(&poses, format!("{HEADER}{}", "1,0,0,0,0.1,0,0\n".repeat(9))).unwrap();

    let identity = fs::read_to_string(place.path("out/run.json")).unwrap();
    let older = identity.replace(env!("CARGO_PKG_VERSION"), "0.0.1");
    fs::write(place.path("out/run.json"), older).unwrap();
    refused(&with(&[]), 1, &["cannot go on", "bumper 0.0.1"]);
    fs::write(place.path("out/run.json"), "{").unwrap();
    refused(&with(&[]), 1, &["run.json"]);
    fs::write(place.path("out/run.json"), &identity).unwrap();

    fs::write(&csv, text.replace("\n3,", "\n33,")).unwrap();
    refused(&with(&[]), 1, &["scenarios.csv", "line 5"]);
    unfinish();
    succeeded(&with(&[]));
    assert_eq!(fs::read_to_string(&csv).unwrap(), text);

    let nothing = place.text("nothing");
    refused(&place.run(&["run", "--resume", &nothing]), 1, &["no run to go on with"]);
    fs::create_dir(&nothing).unwrap();
    refused(&place.run(&["run", "--resume", &nothing]), 1, &["no run", "scene.toml"]);
}

/// Binary, of one triangle.
fn triangle_stl(size: f32) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(1_u32.to_le_bytes());
    let numbers = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, size, 0.0, 0.0, 0.0, size, 0.0_f32];
    bytes.extend(numbers.into_iter().flat_map(f32::to_le_bytes));
    bytes.extend([0, 0]);
    bytes
}
