//! The suite of known truth.

use bumper::hardcases::continuous::{QuerySuite, check};

fn suite() -> QuerySuite {
    QuerySuite::parse(include_bytes!("../data/ccd/own.txt.gz"), "own.txt.gz").unwrap()
}

#[test]
fn no_contact_is_missed_and_none_invented() {
    let report = check(&[suite()], &|_| {});
    assert_eq!((report.total.queries, report.rows.len()), (1_800, 18));
    assert!(report.wrong.is_empty(), "{:?}", report.wrong);
    assert!(report.total.worst_time_error <= Some(1e-9), "{:?}", report.total);
}

#[test]
fn integers_alone_know_every_answer() {
    for query in suite().queries {
        let answer = query.reference();
        assert_eq!(answer.is_some(), query.contact, "line {}", query.line);
        if let Some(time) = answer {
            assert!(time.latest - time.earliest <= 2_f64.powi(-53), "line {}", query.line);
        }
    }
}

#[test]
fn the_first_time_is_within_the_interval_however_wide_it_may_be() {
    for query in suite().queries.iter().filter(|query| query.contact) {
        let exact = query.reference().unwrap();
        for tolerance in [0.0, 1e-12, 1e-6, 1.0] {
            let time = query.answer(tolerance).unwrap();
            let line = query.line;
            assert!(0.0 <= time.earliest && time.latest <= 1.0, "line {line}: {time:?}");
            assert!(time.latest - time.earliest <= tolerance.max(2_f64.powi(-53)), "line {line}");
            let meets = time.earliest <= exact.latest && exact.earliest <= time.latest;
            assert!(meets, "line {line}: {time:?} without {exact:?}");
        }
    }
}
