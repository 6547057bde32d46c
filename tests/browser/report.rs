//! What `bumper report` makes, looked at.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::chromium::Chromium;
use crate::png;

const RUN: [&str; 13] = [
    "run",
    "--fixed",
    "builtin:tracked?triangles=1500",
    "--moving",
    "builtin:car?triangles=1000",
    "--count",
    "12",
    "--workers",
    "2",
    "--transport",
    "threads",
    "--out",
    "run",
];

/// Of all figures of the page.
const FIGURES: [&str; 5] =
    ["s1-compute_times", "s1-pairs_of_scenarios", "s1-workers", "s1-stages", "s2-units"];

fn bumper(place: &Path, arguments: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_bumper"));
    command.args(arguments).stdin(Stdio::null()).current_dir(place);
    command.env("XDG_CACHE_HOME", place.join("cache")).env("XDG_RUNTIME_DIR", place);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// A report of a run and of an experiment, opened, with the raw JSON of both.
fn opened() -> Option<(Chromium, tempfile::TempDir, [Value; 2])> {
    let mut browser = Chromium::start()?;
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name);
    bumper(place.path(), &RUN);
    let point = |x: f64, y: f64| json!({ "x": x, "y": y, "spread": [0.9 * y, 1.1 * y] });
    let experiment = json!({
        "schema_version": 1,
        "kind": "experiment",
        "name": "units </script><script>document.title = 'broken'</script>",
        "versions": { "bumper": "0.1.0" },
        "machine": { "cores": 2 },
        "figures": [{
            "name": "units",
            "title": "Speedup",
            "x": { "label": "processing units", "scale": "log" },
            "y": { "label": "speedup", "scale": "linear" },
            "series": [
                { "name": "best <b>match</b>", "points": [point(1.0, 1.0), point(2.0, 1.9)] },
                { "name": "lowest match", "points": [point(1.0, 1.0), point(2.0, 1.4)] }
            ]
        }],
        "tables": [{ "title": "Serial", "columns": ["scenarios", "s"], "rows": [["10", "2.5"]] }]
    });
    fs::create_dir(path("experiment")).unwrap();
    fs::write(path("experiment/experiment.json"), experiment.to_string()).unwrap();
    bumper(place.path(), &["report", "run", "experiment", "--svg", "figures"]);
    let summary = fs::read_to_string(path("run/summary.json")).unwrap();
    browser.resize([1400, 900]);
    browser.open(&path("report.html"));
    Some((browser, place, [serde_json::from_str(&summary).unwrap(), experiment]))
}

#[test]
fn a_report_shows_its_figures_and_asks_for_nothing() {
    let Some((mut browser, _place, json)) = opened() else { return };
    assert_eq!(browser.evaluate("document.title"), "bumper: report");
    let ids = "[...document.querySelectorAll('figure')].map((figure) => figure.id)";
    assert_eq!(browser.evaluate(ids), json!(FIGURES));
    for id in FIGURES {
        let size = format!(
            "(() => {{ const box = document.querySelector('#{id} svg').getBoundingClientRect(); \
             return box.width > 300 && box.height > 150 }})()"
        );
        assert_eq!(browser.evaluate(&size), true, "{id}");
        let cells = format!("document.querySelectorAll('#{id} tbody td').length > 0");
        assert_eq!(browser.evaluate(&cells), true, "{id}");
    }
    let text = "document.querySelector('#s2-units svg').textContent";
    let words = browser.evaluate(text);
    assert!(words.as_str().unwrap().contains("best <b>match</b>"), "{words}");
    for (section, json) in json.iter().enumerate() {
        let raw = format!("document.getElementById('s{}-json').textContent", section + 1);
        let text = browser.evaluate(&raw);
        assert_eq!(serde_json::from_str::<Value>(text.as_str().unwrap()).unwrap(), *json);
    }
    assert_eq!(browser.requests().len(), 1, "the page itself");
    assert_eq!(browser.problems(), [""; 0]);
}

#[test]
fn a_report_is_dark_where_its_reader_has_it_dark_and_never_on_paper() {
    let Some((mut browser, _place, _)) = opened() else { return };
    let background = "getComputedStyle(document.body).backgroundColor";
    let ink = "getComputedStyle(document.querySelector('svg text')).fill";
    let mut seen = |scheme| {
        browser.emulate(&[("prefers-color-scheme", scheme)]);
        let colours = [background, ink].map(|what| browser.evaluate(what));
        (colours, png::decode(&browser.screenshot()))
    };
    let ([light_paper, light_ink], light) = seen("light");
    let ([dark_paper, dark_ink], dark) = seen("dark");
    assert_eq!([light_paper, dark_paper], ["rgb(255, 255, 255)", "rgb(22, 25, 29)"]);
    assert_eq!([light_ink, dark_ink], ["rgb(26, 26, 26)", "rgb(228, 228, 228)"]);
    assert!(light.changed(&dark) > 0.9);
    assert!(light.colours() > 10, "not blank");
    // Still dark on the screen.
    let on_paper = json!({ "media": "print" });
    browser.call("Emulation.setEmulatedMedia", on_paper);
    assert_eq!(browser.evaluate(background), "rgb(255, 255, 255)");
    let paper = browser.print_to_pdf();
    assert!(paper.starts_with(b"%PDF-") && paper.len() > 20_000, "{} bytes", paper.len());
}

#[test]
fn a_figure_alone_is_a_picture_too() {
    let Some((mut browser, place, _)) = opened() else { return };
    browser.emulate(&[("prefers-color-scheme", "light")]);
    browser.open(&place.path().join("figures/units.svg"));
    let light = png::decode(&browser.screenshot());
    browser.emulate(&[("prefers-color-scheme", "dark")]);
    let dark = png::decode(&browser.screenshot());
    assert!(light.colours() > 10 && light.changed(&dark) > 0.9);
    assert_eq!(browser.evaluate("document.querySelectorAll('parsererror').length"), 0);
    assert_eq!(browser.problems(), [""; 0]);
}
