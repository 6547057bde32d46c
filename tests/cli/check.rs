//! `bumper check`: what it prints, and its exit codes.

use serde_json::Value;

use super::{Place, refused, stderr, stdout, succeeded};

const HIT: &str = "touching 1 point \
    0000000000000000 0000000000000000 0000000000000000 3ff0000000000000 0000000000000000 \
    0000000000000000 0000000000000000 3ff0000000000000 0000000000000000 0000000000000000 \
    0000000000000000 0000000000000000 bff0000000000000 0000000000000000 0000000000000000 \
    0000000000000000 bff0000000000000 0000000000000000\n";

#[test]
fn every_exact_answer_to_the_built_in_suite_is_right() {
    let command = "bumper check";
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let place = Place::new();
    let output = place.run(&[&words[..], &["--json"]].concat());
    succeeded(&output);
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!((&report["schema_version"], &report["cases"]), (&1.into(), &14_860.into()));
    assert_eq!(report["wrong"].as_array().unwrap().len(), 0);
    let rows = report["rows"].as_array().unwrap();
    for way in ["triangle pair", "obb", "aabb", "wide portable"] {
        let of_way = rows.iter().filter(|row| row["way"] == way && row["level"] == "exact");
        let cases: u64 = of_way.map(|row| row["cases"].as_u64().unwrap()).sum();
        assert_eq!(cases, if way == "triangle pair" { 12_800 } else { 12_860 }, "{way}");
    }
    assert!(rows.iter().all(|row| row["wrong"] == 0 || row["level"] != "exact"));
    for plain in ["boxes(4)", "boxes", "f32", "f64"] {
        let wrong = rows.iter().filter(|row| row["level"] == plain && row["wrong"] != 0);
        assert!(wrong.count() > 20, "{plain} does well without exact predicates?");
    }
}

#[test]
fn suites_from_files_are_counted_by_family() {
    let place = Place::new();
    let (one, two) = (place.write("one.txt", HIT), place.write("two.txt", &HIT.repeat(3)));
    let output = place.run(&["check", "--suite", &one, &two]);
    succeeded(&output);
    let table = stdout(&output);
    let row = table.lines().find(|line| line.starts_with("touching")).unwrap();
    assert!(table.starts_with("wrong, by family") && table.contains("boxes(4)"), "{table}");
    assert!(row.split_whitespace().eq(["touching", "4", "0", "0", "0", "0", "0"]), "{row}");
}

#[test]
fn a_wrong_truth_is_told_by_family_and_line_with_exit_code_1() {
    let place = Place::new();
    let suite = place.write("mine.txt", &format!("{HIT}{}", HIT.replace("1 point", "0 none")));
    let output = place.run(&["check", "--suite", &suite]);
    assert_eq!(output.status.code(), Some(1));
    let error = stderr(&output);
    assert!(error.contains("exact answers are wrong"), "{error}");
    assert!(error.contains("mine.txt:2: touching (obb)"), "{error}");
    let table = stdout(&output);
    let row = table.lines().find(|line| line.starts_with("touching")).unwrap();
    assert!(row.split_whitespace().eq(["touching", "2", "1", "1", "1", "1", "1"]), "{row}");
}

#[test]
fn damaged_suites_are_usage_errors_that_name_file_and_line() {
    let place = Place::new();
    let good = place.write("good.txt", HIT);
    let cases = [
        (place.write("bad.txt", &format!("{HIT}\n{}", &HIT[..100])), "bad.txt:3: "),
        (place.write("empty.txt", "# none\n"), "empty.txt: there is no case in it"),
        (place.text("missing.txt"), "missing.txt: cannot be read"),
        ("/dev/null".to_owned(), "is not a regular file"),
    ];
    for (suite, words) in &cases {
        refused(&place.run(&["check", "--suite", &good, suite]), 2, &[words]);
    }
    refused(&place.run(&["check", "--suite"]), 2, &["--suite"]);
}

/// Vertex p falls through triangle v0 v1 v2, halfway.
const FALL: &str = "mine/fall vf 1 \
    3fd0000000000000 3fd0000000000000 3ff0000000000000 0000000000000000 0000000000000000 \
    0000000000000000 3ff0000000000000 0000000000000000 0000000000000000 0000000000000000 \
    3ff0000000000000 0000000000000000 \
    3fd0000000000000 3fd0000000000000 bff0000000000000 0000000000000000 0000000000000000 \
    0000000000000000 3ff0000000000000 0000000000000000 0000000000000000 0000000000000000 \
    3ff0000000000000 0000000000000000\n";

/// It falls beside the triangle.
fn miss() -> String {
    FALL.replace("fall vf 1", "miss vf 0").replace("3fd0000000000000", "4000000000000000")
}

#[test]
fn continuous_queries_are_counted_by_source() {
    let place = Place::new();
    let (one, two) = (place.write("one.txt", FALL), place.write("two.txt", &(miss() + &miss())));
    let output = place.run(&["check", "--ccd", &one, &two]);
    succeeded(&output);
    let table = stdout(&output);
    let heads = ["source", "queries", "missed", "extra", "time", "error", "ns", "a", "query"];
    assert!(table.lines().next().unwrap().split_whitespace().eq(heads), "{table}");
    for (source, queries) in [("mine/fall", "1"), ("mine/miss", "2"), ("all", "3")] {
        let row = table.lines().find(|line| line.starts_with(source)).unwrap();
        let cells: Vec<&str> = row.split_whitespace().collect();
        assert_eq!(cells[1..4], [queries, "0", "0"], "{row}");
    }
    let output = place.run(&["check", "--json", "--ccd", &one, &two]);
    succeeded(&output);
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!((&report["schema_version"], &report["total"]["queries"]), (&1.into(), &3.into()));
    assert!(report["rows"][0]["worst_time_error"].as_f64().unwrap() < 1e-9);
    assert!(report["rows"][1]["worst_time_error"].is_null());
}

#[test]
fn wrong_answers_to_continuous_queries_are_told_with_exit_code_1() {
    let place = Place::new();
    let lines = FALL.replace("vf 1", "vf 0") + &miss().replace("vf 0", "vf 1");
    let output = place.run(&["check", "--ccd", &place.write("mine.txt", &lines)]);
    assert_eq!(output.status.code(), Some(1));
    let error = stderr(&output);
    assert!(error.contains("mine.txt:1: mine/fall (extra)"), "{error}");
    assert!(error.contains("mine.txt:2: mine/miss (missed)"), "{error}");
}

#[test]
fn damaged_continuous_queries_are_usage_errors() {
    let place = Place::new();
    let cases = [
        (FALL.replace("vf", "fv"), "bad.txt:1: 'fv' where the kind, vf or ee, is wanted"),
        (FALL.replace("vf 1", "vf 2"), "'2' where the truth, 0 or 1, is wanted"),
        (FALL.replace("bff0", "7ff0"), "inf is not a finite number"),
        (FALL[..300].to_owned(), "fields where 27 are wanted"),
        ("# none\n".to_owned(), "there is no case in it"),
    ];
    for (text, words) in &cases {
        refused(&place.run(&["check", "--ccd", &place.write("bad.txt", text)]), 2, &[words]);
    }
    let good = place.write("good.txt", FALL);
    refused(&place.run(&["check", "--ccd", &good, "--suite", &good]), 2, &["--suite"]);
}
