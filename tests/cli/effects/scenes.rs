//! The scenes in `config/effects/`: they run, and say what they promise.

use super::*;

const CONTAINMENT: &[&str] = &["containment", "fixed_parts_inside", "moving_parts_inside"];
const SEGMENTS: &[&str] =
    &["contact_curves", "closed_contact_curves", "contact_length_m", "segment_error_m"];
const CLEARANCE: &[&str] = &[
    "clearance_m",
    "clearance_lower_bound_m",
    "nearest_fixed_triangle",
    "nearest_moving_triangle",
    "nearest_fixed_x_m",
    "nearest_fixed_y_m",
    "nearest_fixed_z_m",
    "nearest_moving_x_m",
    "nearest_moving_y_m",
    "nearest_moving_z_m",
    "near_pairs",
];
const PENETRATION: &[&str] = &[
    "penetration_depth_m",
    "penetration_free_at_m",
    "least_translation_m",
    "least_translation_x_m",
    "least_translation_y_m",
    "least_translation_z_m",
];
const VOLUME: &[&str] = &["overlap_volume_m3", "overlap_volume_error_m3"];
const MOTION: &[&str] = &[
    "motion",
    "impact_time_s",
    "impact_distance_m",
    "impact_fixed_triangle",
    "impact_moving_triangle",
    "impact_x_m",
    "impact_y_m",
    "impact_z_m",
    "impact_normal_x",
    "impact_normal_y",
    "impact_normal_z",
    "contact_intervals",
    "contact_known_until_s",
];
const RESPONSE: &[&str] = &[
    "impact",
    "contact_x_m",
    "contact_y_m",
    "contact_z_m",
    "contact_normal_x",
    "contact_normal_y",
    "contact_normal_z",
    "closing_speed_m_s",
    "impulse_x_n_s",
    "impulse_y_n_s",
    "impulse_z_n_s",
    "fixed_delta_v_m_s",
    "fixed_delta_v_x_m_s",
    "fixed_delta_v_y_m_s",
    "fixed_delta_v_z_m_s",
    "fixed_delta_spin_x_rad_s",
    "fixed_delta_spin_y_rad_s",
    "fixed_delta_spin_z_rad_s",
    "fixed_pdof_deg",
    "moving_delta_v_m_s",
    "moving_delta_v_x_m_s",
    "moving_delta_v_y_m_s",
    "moving_delta_v_z_m_s",
    "moving_delta_spin_x_rad_s",
    "moving_delta_spin_y_rad_s",
    "moving_delta_spin_z_rad_s",
    "moving_pdof_deg",
    "energy_loss_j",
    "energy_rises",
];
const CRUSH: &[&str] = &[
    "fixed_crush_m",
    "moving_crush_m",
    "fixed_crush_energy_j",
    "moving_crush_energy_j",
    "fixed_ees_m_s",
    "moving_ees_m_s",
    "fixed_crash3_delta_v_m_s",
    "moving_crash3_delta_v_m_s",
];
const SMALL_TRACKED: &str = "builtin:tracked?triangles=2000";
const SMALL_CAR: &str = "builtin:car?triangles=1000";

/// Of a scene as it is, but for the given arguments.
fn run(name: &str, arguments: &[&str]) -> Run {
    let scene = format!("{}/config/effects/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Run::of(&Place::new(), &scene, arguments)
}

fn says(run: &Run, columns: &[&[&str]], tables: &[&str]) {
    let expected: Vec<&str> = ["scenario", "colliding"]
        .into_iter()
        .chain(columns.iter().copied().flatten().copied())
        .collect();
    assert_eq!(run.header, expected);
    assert_eq!(run.table_names(), tables);
}

const PAIRS: &[&str] = &["pairs", "pairs_fnv1a64"];

#[test]
fn overlap_says_yes_or_no_and_nothing_else() {
    let run = run("overlap", &["--fixed", SMALL_TRACKED, "--moving", SMALL_CAR]);
    says(&run, &[], &[]);
    assert_eq!(run.effects(), [("overlap", 40)]);
    let colliding = run.cells("colliding").iter().filter(|&&cell| cell == "1").count();
    assert!((1..40).contains(&colliding), "{colliding} of 40");
    assert_eq!(run.summary["colliding"], colliding);
}

#[test]
fn contacts_come_with_their_segments_and_curves() {
    let few = ["--fixed", SMALL_TRACKED, "--moving", SMALL_CAR, "--count", "5"];
    let run = run("contacts", &few);
    says(&run, &[PAIRS, SEGMENTS], &["curves", "segments"]);
    assert_eq!(run.effects(), [("contacts", 5), ("contacts.segments", 5)]);
    // Every pair has its corners, and every curve that is counted its points.
    let mut pairs: Vec<[u64; 3]> = run
        .table("segments")
        .iter()
        .map(|row| ["scenario", "fixed_triangle", "moving_triangle"].map(|name| row[name] as u64))
        .collect();
    pairs.dedup();
    assert_eq!(run.summary["pairs"], pairs.len());
    let mut curves: Vec<[u64; 2]> = run
        .table("curves")
        .iter()
        .map(|row| ["scenario", "curve"].map(|n| row[n] as u64))
        .collect();
    curves.dedup();
    let counted: f64 = run.numbers("contact_curves").into_iter().flatten().sum();
    assert_eq!(curves.len() as f64, counted);
}

#[test]
fn near_misses_have_a_distance_and_all_pairs_within_the_margin() {
    let run = run("near_misses", &["--fixed", SMALL_TRACKED, "--moving", SMALL_CAR]);
    says(&run, &[PAIRS, CLEARANCE], &["near_pairs"]);
    let mut near = [0; 40];
    for row in run.table("near_pairs") {
        assert!(row["distance_m"] <= 0.05 && row["distance_m"] > 0.0, "{row:?}");
        near[row["scenario"] as usize] += 1;
    }
    let (colliding, clearance) = (run.cells("colliding"), run.numbers("clearance_m"));
    for (scenario, pairs) in run.numbers("near_pairs").into_iter().enumerate() {
        assert_eq!(clearance[scenario].is_none(), colliding[scenario] == "1");
        assert_eq!(pairs.unwrap_or(0.0), f64::from(near[scenario]));
        // The reported distance may be so much too large.
        let within = clearance[scenario].is_some_and(|metres| metres <= 0.05);
        assert!(!within || near[scenario] > 0, "scenario {scenario}");
    }
    assert!(near.iter().any(|&pairs| pairs > 0) && colliding.contains(&"1"));
}

#[test]
fn a_crash_says_all_there_is_to_say() {
    let run = run("crash", &["--fixed", SMALL_CAR, "--moving", SMALL_CAR]);
    let columns =
        [PAIRS, SEGMENTS, CONTAINMENT, CLEARANCE, PENETRATION, VOLUME, MOTION, RESPONSE, CRUSH];
    says(&run, &columns, &["contact_intervals", "curves", "near_pairs", "segments"]);
    let motion = run.cells("motion");
    assert_eq!(motion, ["impact", "impact", "impact", "impact", "apart", "in_contact"]);
    let impact = run.cells("impact");
    assert!(
        impact
            .iter()
            .zip(&motion)
            .all(|(impact, motion)| impact.is_empty() == (*motion == "apart"))
    );
    for (name, scenarios) in [("contacts.segments", 1), ("clearance", 5), ("penetration", 1)] {
        assert!(run.effects().contains(&(name, scenarios)), "{name} in {:?}", run.effects());
    }
    for hit in [0, 1, 2, 3, 5] {
        // A car of 60 km/h loses some of them to one that stands, and not all together.
        assert!((1.0..16.7).contains(&run.number("moving_delta_v_m_s", hit)));
        assert!(run.number("moving_crush_m", hit) > 0.0);
    }
}

#[test]
fn turning_wheels_meet_the_kerb_first() {
    const WHEELS: [std::ops::RangeInclusive<f64>; 2] = [3492.0..=3603.0, 3716.0..=3827.0];
    let run = run("wheel", &[]);
    says(&run, &[PAIRS, MOTION], &["contact_intervals"]);
    assert_eq!(run.cells("motion"), ["impact", "impact", "apart"]);
    for (scenario, wheel) in WHEELS.iter().enumerate() {
        let triangle = run.number("impact_moving_triangle", scenario);
        assert!(wheel.contains(&triangle), "triangle {triangle} is not of {wheel:?}");
        assert_eq!(run.number("contact_intervals", scenario), 2.0, "front and rear wheel");
    }
}
