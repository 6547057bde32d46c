//! `bumper view`: the page as a file, and what becomes of bad input. `tests/browser` looks at it.

mod server;

use super::*;

const SMALL: [&str; 6] = ["--fixed", TRACKED, "--moving", CAR, "--workers", "2"];

impl Place {
    fn view(&self, arguments: &[&str]) -> Output {
        let mut command = self.bumper(&[&["view"], arguments].concat());
        command.current_dir(self.0.path()).output().unwrap()
    }

    /// The results of a small run, in `results`.
    fn with_results() -> (Self, String) {
        let place = Self::new();
        let results = place.text("results");
        let run = [&["run", "--count", "5", "--out", &results], &SMALL[..]].concat();
        succeeded(&place.run(&run));
        (place, results)
    }
}

#[test]
fn the_scene_of_the_readme_becomes_one_page_that_needs_nothing_else() {
    let place = Place::new();
    let command = "bumper view config/effects/crash.toml";
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/config/effects/crash.toml");
    assert!(scene.ends_with(command.split(' ').nth(2).unwrap()));
    let small = ["--fixed", "builtin:car?triangles=1000", "--moving", "builtin:car?triangles=1000"];
    let output = place.view(&[&[scene], &small[..]].concat());
    succeeded(&output);
    assert_eq!(stdout(&output), "bumper.html\n");
    let page = fs::read_to_string(place.path("bumper.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.ends_with("</html>\n"));
    let frame = page.split("<script").next().unwrap();
    assert!(frame.contains("default-src 'none'") && !frame.contains("src="), "{frame}");
    assert!(page.contains("The MIT License"), "of what is in it");
    let others: Vec<_> =
        fs::read_dir(place.0.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(others.iter().all(|name| name != "results"), "{others:?}");
}

#[test]
fn full_vehicles_fit_into_a_page_of_twelve_megabytes() {
    let place = Place::new();
    let full = ["--fixed", "builtin:tracked", "--moving", "builtin:car", "--count", "2"];
    succeeded(&place.view(&[&full[..], &["--workers", "2"]].concat()));
    let bytes = fs::metadata(place.path("bumper.html")).unwrap().len();
    assert!(bytes < 6_000_000, "{bytes} bytes before any pair of triangles");
}

#[test]
fn a_finished_run_is_shown_and_held_against_its_answers() {
    let (place, results) = Place::with_results();
    succeeded(&place.view(&[&results, "--out", "page.html"]));
    assert!(place.path("page.html").is_file());
    let csv = place.path("results/scenarios.csv");
    let rows = fs::read_to_string(&csv).unwrap();
    let row = rows.lines().nth(3).unwrap();
    let hash = row.split(',').nth(3).unwrap();
    fs::write(&csv, rows.replace(hash, "0123456789abcdef")).unwrap();
    fs::remove_file(place.path("page.html")).unwrap();
    let output = place.view(&[&results, "--out", "page.html"]);
    refused(&output, 1, &["scenario 2", "0123456789abcdef", hash, "has changed since"]);
    assert!(!place.path("page.html").exists(), "a page that is wrong");
    // The same with a mesh that is not the run's.
    fs::write(&csv, &rows).unwrap();
    refused(&place.view(&[&results, "--fixed", CAR]), 1, &["scenario 0", "has changed since"]);
}

#[test]
fn of_a_run_that_was_stopped_what_it_answered_is_shown() {
    let (place, results) = Place::with_results();
    let csv = place.path("results/scenarios.csv");
    let rows = fs::read_to_string(&csv).unwrap();
    let two: Vec<&str> = rows.lines().take(3).collect();
    fs::write(&csv, two.join("\n") + "\n").unwrap();
    succeeded(&place.view(&[&results]));
    fs::write(&csv, two[0].to_owned() + "\n").unwrap();
    refused(&place.view(&[&results]), 1, &["has not answered any scenario"]);
    fs::write(&csv, two.join("\n") + "\n2,1,x").unwrap();
    refused(&place.view(&[&results]), 1, &["scenarios.csv", "line 4"]);
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let place = Place::new();
    fs::create_dir(place.path("empty")).unwrap();
    let cases: [(&[&str], i32, &[&str]); 7] = [
        (&["empty"], 1, &["empty", "scene.toml", "give the scene file"]),
        (&["nowhere.toml"], 1, &["nowhere.toml", "cannot read the scene"]),
        (&["--accuracy", "boxes(3)"], 2, &["boxes(3)", "no triangles to show"]),
        (&["--serve", "0.0.0.0:80"], 2, &["0.0.0.0:80", "this machine only", "127.0.0.1:80"]),
        (&["--serve", "[::]:80"], 2, &["this machine only"]),
        (&["--serve", "localhost"], 2, &["no address with a port"]),
        (
            &["--count", "1", "--out", "nowhere/page.html"],
            1,
            &["nowhere/page.html", "cannot write"],
        ),
    ];
    for (arguments, code, words) in cases {
        refused(&place.view(&[arguments, &SMALL[..]].concat()), code, words);
    }
    assert!(!place.path("bumper.html").exists());
}

/// Where a name could be taken for HTML, it is packed.
#[test]
fn names_of_files_are_no_part_of_the_html() {
    let place = Place::new();
    let name = "<img src=x onerror=alert(73)>'\"&.ply";
    let mesh =
        "builtin:car?triangles=1000".parse::<bumper::mesh::MeshSource>().unwrap().load().unwrap();
    bumper::mesh::write_ply(&mesh, &place.path(name)).unwrap();
    let arguments = ["--fixed", name, "--moving", name, "--count", "1", "--workers", "1"];
    succeeded(&place.view(&arguments));
    let page = fs::read_to_string(place.path("bumper.html")).unwrap();
    assert!(!page.contains("alert(73)") && !page.contains("<img src=x"));
}
