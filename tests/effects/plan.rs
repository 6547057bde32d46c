use bumper::effects::clearance::ClearanceOptions;
use bumper::effects::penetration::{Effort, PenetrationOptions};
use bumper::effects::{DESCRIPTIONS, Plan, Step, TABLES};

#[test]
fn every_table_of_a_step_is_known_by_name() {
    let margin = ClearanceOptions { margin_m: Some(0.1), ..ClearanceOptions::default() };
    let least = PenetrationOptions { direction: None, least: Some(Effort::default()) };
    let steps =
        vec![Step::Segments, Step::Containment, Step::Clearance(margin), Step::Penetration(least)];
    let layout = Plan { ignore: vec![], steps }.layout();
    assert!(layout.tables().all(|table| TABLES.contains(&table.name)));
    assert!(layout.steps.iter().zip(&DESCRIPTIONS).all(|(step, d)| step.name == d.effect));
}
