use std::num::NonZeroU32;

use super::*;
use crate::experiment::evaluation::{Parallel, Units};
use crate::report::figure::Point;
use crate::scene::{Slowdown, Transport};

/// Samples of all steps of which the speedup is told by the step.
fn measured(evaluation: &Evaluation, speedup: impl Fn(&Step) -> f64) -> Kept {
    let sample = |step: &Step| {
        let setting = evaluation.setting(step, 1000);
        let slowdowns = setting.slowdowns();
        let best_possible = slowdowns.iter().map(|factor| 1.0 / factor).sum();
        let parallel = step.matchmaker.map(|_| Parallel {
            workers: slowdowns.len() as u32,
            weighted_serial_s: 2.0,
            parallel_s: 2.0 / speedup(step),
            speedup: speedup(step),
            best_possible,
            bytes_sent: 8,
            relative_data_transfer: 0.5,
            bytes_from_workers: 0,
            first_result_s: 0.1,
            pre_analysis_s: 0.1,
            matching_s: 0.1,
        });
        Sample {
            models: evaluation.models[step.models].name.clone(),
            at: step.at,
            matchmaker: step.matchmaker,
            sample: step.sample,
            scenarios: setting.scenarios,
            pairs: 1,
            serial_s: 2.0 + f64::from(step.sample),
            parallel,
        }
    };
    Kept { models: Vec::new(), samples: evaluation.steps().iter().map(sample).collect() }
}

fn embedded(name: &str, workers: i64) -> Evaluation {
    let mut evaluation = Evaluation::embedded(name).unwrap();
    for models in &mut evaluation.models {
        models.scene.engine.workers = Some(crate::scene::WorkerCount::new(workers).unwrap());
    }
    evaluation
}

#[test]
fn points_are_means_with_the_least_and_the_most_as_their_spread() {
    let evaluation = embedded("depth", 1);
    let kept = measured(&evaluation, |step| 1.0 + f64::from(step.sample * step.sample));
    let outcome = Outcome::new(&evaluation, &Value::Null, &kept);
    assert_eq!(outcome.samples, outcome.samples_asked);
    let names: Vec<&str> = outcome.figures.iter().map(|figure| figure.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "depth-heavy-car-speedup",
            "depth-heavy-car-relative-data-transfer",
            "depth-car-car-speedup",
            "depth-car-car-relative-data-transfer"
        ]
    );
    let speedup = &outcome.figures[0];
    let lines: Vec<&str> = speedup.series.iter().map(|series| series.name.as_str()).collect();
    assert_eq!(lines, ["best", "random", "lowest", "best-load", "best possible"]);
    let expected = Point { x: 2.0, y: (1.0 + 2.0 + 5.0) / 3.0, spread: Some([1.0, 5.0]) };
    assert_eq!(speedup.series[0].points[0], expected);
    assert_eq!(speedup.series[0].points.len(), evaluation.vary.values());
    assert_eq!(speedup.series[4].points[0], Point::at(2.0, 1.0));
    assert_eq!(outcome.tables[0].rows[0][..2], ["2", "2.67 (1.00-5.00)"]);
    for table in &outcome.tables {
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{table:?}");
    }
}

#[test]
fn serial_times_have_one_figure_of_both_pairs() {
    let evaluation = embedded("serial", 1);
    let kept = measured(&evaluation, |_| 1.0);
    let outcome = Outcome::new(&evaluation, &Value::Null, &kept);
    let [figure] = &outcome.figures[..] else { panic!("one") };
    assert_eq!(figure.series.len(), 2);
    let expected = Point { x: 200.0, y: 3.0, spread: Some([2.0, 4.0]) };
    assert_eq!(figure.series[0].points[0], expected);
    assert_eq!(outcome.tables[1].rows[4], ["1000 [100%]", "3.000", "2.000", "4.000", "333"]);
}

#[test]
fn transfer_that_does_not_happen_is_said_and_not_drawn() {
    let mut evaluation = embedded("buffer", 1);
    for models in &mut evaluation.models {
        models.scene.engine.transport = Transport::Iceoryx2;
    }
    let kept = measured(&evaluation, |_| 1.0);
    let outcome = Outcome::new(&evaluation, &Value::Null, &kept);
    assert!(outcome.figures.iter().all(|figure| figure.name.ends_with("speedup")));
    assert!(outcome.notes.iter().any(|note| note.contains("no subtree is sent")));
}

#[test]
fn subtrees_that_are_not_sent_as_in_the_paper_are_pointed_out() {
    let mut evaluation = embedded("buffer", 1);
    evaluation.models[1].scene.engine.compress = Compression::Lz4;
    evaluation.models[0].scene.engine.subtrees_from = SubtreesFrom::Workers;
    let kept = measured(&evaluation, |_| 1.0);
    let outcome = Outcome::new(&evaluation, &Value::Null, &kept);
    let noted = |words: &str| outcome.notes.iter().any(|note| note.contains(words));
    assert!(noted("car-car: subtrees are sent compressed") && noted("heavy-car: what workers"));
}

#[test]
fn more_workers_than_cores_and_slow_ones_are_pointed_out() {
    let mut evaluation = embedded("units", 1);
    let cores = Machine::this().cores as u32;
    let units = vec![Units { fast: 1, slow: 0 }, Units { fast: cores, slow: 1 }];
    evaluation.vary = Vary::Units { units, slowdown: Slowdown::new(2.0).unwrap() };
    evaluation.samples = NonZeroU32::MIN;
    let kept = measured(&evaluation, |_| 1.0);
    let outcome = Outcome::new(&evaluation, &Value::Null, &kept);
    let rows = &outcome.tables[0].rows;
    assert_eq!(rows[0][0], "1");
    assert_eq!(rows[1][0], format!("{cores} + 1 slow = {cores}.5 *"));
    let noted = |words: &str| outcome.notes.iter().any(|note| note.contains(words));
    assert!(noted(&format!("more workers than the {cores} cores")) && noted("slow workers"));
    let bound = &outcome.figures[0].series[4].points;
    assert_eq!(bound[1], Point::at(f64::from(cores) + 0.5, f64::from(cores) + 0.5));
}

#[test]
fn what_is_not_measured_yet_is_left_out_and_said() {
    let evaluation = embedded("scenarios", 1);
    let mut kept = measured(&evaluation, |_| 1.0);
    kept.samples.truncate(3);
    let outcome = Outcome::new(&evaluation, &Value::Null, &kept);
    assert_eq!((outcome.samples, outcome.samples_asked), (3, 120));
    assert_eq!(outcome.figures.len(), 2, "of the first models");
    assert_eq!(outcome.tables[0].rows.len(), 1);
    assert_eq!(outcome.tables[0].rows[0][4], "-", "of the last matchmaker");
    assert!(outcome.notes.iter().any(|note| note == "not finished: 3 of 120 samples"));
    kept.samples.clear();
    let outcome = Outcome::new(&evaluation, &Value::Null, &kept);
    assert!(outcome.figures.is_empty() && outcome.tables.is_empty());
}
