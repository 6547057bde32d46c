use std::path::PathBuf;

use super::*;
use crate::report::accuracy_plot::{AccuracyPlot, Mark};
use crate::report::figure::tests::elements;
use crate::report::figure::{Axis, Figure, Point, Series};

const HOSTILE: &str = "</script><!--<script>alert(1)</script> \"&'\u{0}";

fn section(text: &str) -> Section {
    let points = vec![Point::at(1.0, 2.0), Point { x: 2.0, y: 3.0, spread: Some([2.0, 4.0]) }];
    let figure = Figure {
        name: "a_figure".to_owned(),
        title: text.to_owned(),
        x: Axis::linear(text),
        y: Axis::log(text),
        series: vec![Series { name: text.to_owned(), points }],
    };
    let mark = Mark { name: text.to_owned(), time_us: 1.0, error: 0.0, group: 0 };
    let plot = AccuracyPlot { title: text.to_owned(), marks: vec![mark] };
    let row = || vec![text.to_owned()];
    Section {
        heading: text.to_owned(),
        origin: PathBuf::from(text),
        made_by: vec![[text.to_owned(), text.to_owned()]],
        notes: row(),
        drawings: vec![figure.into(), Drawing::Accuracy(plot)],
        tables: vec![Table { title: text.to_owned(), columns: row(), rows: vec![row()] }],
        json: serde_json::to_string(text).unwrap(),
    }
}

/// The text of the elements of raw JSON, and the page without it.
fn taken_apart(page: &str) -> (Vec<String>, String) {
    let mut parts = page.split("<script type=\"application/json\"");
    let mut rest = parts.next().unwrap().to_owned();
    let mut found = Vec::new();
    for part in parts {
        let (json, after) = part.split_once('>').unwrap().1.split_once("</script>").unwrap();
        found.push(json.to_owned());
        rest += after;
    }
    (found, rest)
}

/// As XML has it: without what HTML leaves open.
fn count_elements(page: &str) -> usize {
    let body = page.strip_prefix("<!DOCTYPE html>\n").unwrap();
    let is_void = |line: &&str| line.starts_with("<meta");
    let closed: Vec<&str> = body.lines().filter(|line| !is_void(line)).collect();
    elements(&closed.join("\n"))
}

#[test]
fn a_page_is_well_formed_and_has_every_figure_and_table() {
    let page = html(&[section("one"), section("other")]).unwrap();
    let (_, rest) = taken_apart(&page);
    count_elements(&rest);
    for id in ["s1-a_figure", "s1-accuracy", "s2-a_figure", "s2-accuracy"] {
        assert_eq!(rest.matches(&format!("<figure id=\"{id}\">")).count(), 1, "{id}");
    }
    assert_eq!(rest.matches("<svg").count(), 4);
    assert_eq!(rest.matches("<table>").count(), 6, "one for each figure, and its own");
    assert!(rest.contains("3 (2–4)"), "{rest}");
    assert_eq!(rest.matches("href=\"#s").count(), 2);
}

#[test]
fn a_page_names_no_place_outside() {
    let page = html(&[section("one")]).unwrap();
    assert!(page.contains("default-src 'none'"));
    for outside in ["http:", "https:", "//", "src=\"", "url(", "@import", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn raw_json_survives_unchanged() {
    let json = r#"{ "schema_version": 1, "x": [0.1, 1e-7], "s": "</script><!-- \u0000 \"" }"#;
    let page = html(&[Section { json: json.to_owned(), ..section("one") }]).unwrap();
    let (found, _) = taken_apart(&page);
    assert_eq!(found[0].replace("\\u003c", "<"), json);
    let value = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    assert_eq!(value(&found[0]), value(json));
}

#[test]
fn hostile_text_stays_text() {
    let page = html(&[section(HOSTILE), section(HOSTILE)]).unwrap();
    let (found, rest) = taken_apart(&page);
    assert_eq!(found.len(), 2);
    for json in found {
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), HOSTILE);
    }
    assert!(!rest.contains("<script") && !rest.contains("<!--") && !rest.contains('\0'));
    assert_eq!(count_elements(&rest), count_elements(&html_of_plain()));
}

fn html_of_plain() -> String {
    taken_apart(&html(&[section("one"), section("other")]).unwrap()).1
}

#[test]
fn no_section_is_a_page_too() {
    count_elements(&html(&[]).unwrap());
}
