use serde_json::json;

use super::*;
use crate::experiment::evaluation::TreeFacts;
use crate::experiment::evaluation::plan::Step;

fn experiment() -> Evaluation {
    Evaluation::embedded("serial").unwrap()
}

fn sample(step: &Step) -> Sample {
    let experiment = experiment();
    Sample {
        models: experiment.models[step.models].name.clone(),
        at: step.at,
        matchmaker: step.matchmaker,
        sample: step.sample,
        scenarios: 10,
        pairs: 3,
        serial_s: 0.1 + f64::from(step.sample) / 3.0,
        parallel: None,
    }
}

fn facts(models: &str) -> Facts {
    let tree = TreeFacts { triangles: 7, bytes: 640, xxh3: "00ff".to_owned() };
    let (fixed, moving) = (tree.clone(), tree);
    Facts { models: models.to_owned(), fixed, moving, scenarios: 10, poses_xxh3: "1".to_owned() }
}

fn open(folder: &Path, resume: bool) -> Result<Store, StoreError> {
    Store::open(folder, &experiment(), &json!({ "name": "serial" }), resume)
}

#[track_caller]
fn refused(opened: Result<Store, StoreError>, words: &[&str]) {
    let error = opened.unwrap_err();
    assert!(error.is_refusal());
    for word in words {
        assert!(error.to_string().contains(word), "`{word}` is missing in:\n{error}");
    }
}

/// With models and the first samples of the experiment in it.
fn filled(folder: &Path, samples: usize) -> Kept {
    let mut store = open(folder, false).unwrap();
    store.add_models(facts("heavy-car")).unwrap();
    for step in &experiment().steps()[..samples] {
        store.add_sample(sample(step)).unwrap();
    }
    store.kept
}

#[test]
fn what_was_added_is_there_again() {
    let place = tempfile::tempdir().unwrap();
    let written = filled(place.path(), 4);
    assert_eq!(written.samples.len(), 4);
    assert_eq!(open(place.path(), true).unwrap().kept, written);
}

#[test]
fn a_file_that_ends_anywhere_keeps_its_whole_lines_and_goes_on_after_them() {
    let place = tempfile::tempdir().unwrap();
    let written = filled(place.path(), 3);
    let path = place.path().join(FILE);
    let whole = fs::read(&path).unwrap();
    let around = |at: usize| [at, at + 1, at + 2];
    let ends = (0..whole.len()).filter(|&at| whole[at] == b'\n').flat_map(around);
    for length in ends.chain((0..whole.len()).step_by(37)).filter(|&end| end < whole.len()) {
        fs::write(&path, &whole[..length]).unwrap();
        let mut store = open(place.path(), true).unwrap();
        let lines = whole[..length].iter().filter(|&&byte| byte == b'\n').count();
        let kept = lines.saturating_sub(2);
        assert_eq!(store.kept.samples, written.samples[..kept]);
        assert_eq!(store.kept.models.len(), usize::from(lines >= 2));
        store.add_models(facts("heavy-car")).unwrap();
        for sample in &written.samples[kept..] {
            store.add_sample(sample.clone()).unwrap();
        }
        drop(store);
        assert_eq!(fs::read(&path).unwrap(), whole, "as if nothing had happened at {length}");
    }
}

#[test]
fn only_new_and_empty_directories_are_begun_in() {
    let place = tempfile::tempdir().unwrap();
    filled(&place.path().join("new"), 1);
    refused(open(&place.path().join("new"), false), &["--resume", "new"]);
    refused(open(place.path(), true), &["no experiment"]);
    let first = open(&place.path().join("new"), true).unwrap();
    refused(open(&place.path().join("new"), true), &["still going on"]);
    drop(first);
    open(&place.path().join("new"), true).unwrap();
}

#[test]
fn samples_of_another_setup_are_not_gone_on_after() {
    let place = tempfile::tempdir().unwrap();
    filled(place.path(), 1);
    let other = Store::open(place.path(), &experiment(), &json!({ "name": "depth" }), true);
    refused(other, &["`name` was \"serial\" and is \"depth\""]);
}

#[test]
fn models_that_have_changed_since_are_refused() {
    let place = tempfile::tempdir().unwrap();
    filled(place.path(), 1);
    let mut store = open(place.path(), true).unwrap();
    store.add_models(facts("heavy-car")).unwrap();
    store.add_models(Facts { scenarios: 99, ..facts("car-car") }).unwrap();
    let error = store.add_models(Facts { scenarios: 11, ..facts("heavy-car") }).unwrap_err();
    assert!(error.is_refusal());
    let words = error.to_string();
    assert!(words.contains("\"scenarios\":10") && words.contains("\"scenarios\":11"), "{words}");
    assert_eq!(store.kept.models.len(), 2, "a second time is no second line");
}

#[test]
fn lines_that_are_not_ours_are_refused_with_their_number() {
    let place = tempfile::tempdir().unwrap();
    filled(place.path(), 2);
    let path = place.path().join(FILE);
    let whole = fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    let stranger = lines[3].replace("\"at\":1", "\"at\":99");
    for (added, words) in [
        ("{}", "not a line"),
        ("nonsense", "not a line"),
        ("{\"sample\":{\"models\":1}}", "not a line"),
        (lines[0], "only that"),
        (lines[3], "already"),
        (&stranger, "no point"),
    ] {
        fs::write(&path, format!("{whole}{added}\n")).unwrap();
        refused(open(place.path(), true), &["points.jsonl:5", words]);
    }
    fs::write(&path, format!("{}\n", lines[3])).unwrap();
    refused(open(place.path(), true), &["points.jsonl:1", "first line"]);
    fs::write(&path, b"\xff\n").unwrap();
    refused(open(place.path(), true), &["no text"]);
}

#[test]
fn a_disk_that_is_full_is_no_refusal() {
    let error = Store {
        path: FILE.into(),
        file: OpenOptions::new().append(true).open("/dev/full").unwrap(),
        kept: Kept::default(),
    }
    .add_models(facts("a"))
    .unwrap_err();
    assert!(!error.is_refusal());
    assert!(error.to_string().contains("space"), "{error}");
}
