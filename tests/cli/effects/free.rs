//! What a scene does not ask for costs nothing, and changes nothing.

use super::*;

/// Everything that a scene can ask for beside pairs; the columns of each, by the first and the last.
const ALL: [(&str, &str, [&str; 2]); 8] = [
    ("contacts.segments", "segments = true", ["contact_curves", "segment_error_m"]),
    ("containment", "containment = true", ["containment", "moving_parts_inside"]),
    ("clearance", "clearance = { margin_m = 0.3 }", ["clearance_m", "near_pairs"]),
    (
        "penetration",
        "penetration = { direction = [1.0, 0.0, 0.0], least = true, directions = 8 }",
        ["penetration_depth_m", "least_translation_z_m"],
    ),
    ("volume", "volume = true", ["overlap_volume_m3", "overlap_volume_error_m3"]),
    ("motion", "", ["motion", "contact_known_until_s"]),
    ("response", "response = true", ["impact", "energy_rises"]),
    ("crush", "crush.width_m = 1.5", ["fixed_crush_m", "moving_crash3_delta_v_m_s"]),
];

/// Tables, by the effects that they are of.
const TABLES: [(&str, &str); 4] = [
    ("contact_intervals", "motion"),
    ("curves", "contacts.segments"),
    ("near_pairs", "clearance"),
    ("segments", "contacts.segments"),
];

/// What of others an effect needs.
fn needs(effect: &str) -> &'static [&'static str] {
    match effect {
        "penetration" | "volume" => &["containment"],
        "response" => &["motion"],
        "crush" => &["motion", "response"],
        _ => &[],
    }
}

/// Two small cars that touch, pass each other or collide, and these effects.
pub(super) fn scene(place: &Place, effects: &[&str]) -> String {
    let asked = |effect| effects.contains(&effect);
    let words = |on: bool, words: &'static str| if on { words } else { "" };
    let mass = "mass_kg = 1000.0\ninertia_kg_m2 = [400.0, 1700.0, 1900.0]\n";
    let mass = words(asked("response"), mass);
    let stiffness = words(asked("crush"), "stiffness = { a_n_m = 5e4, b_n_m2 = 4e5 }\n");
    let velocity = words(asked("motion"), "velocity_m_s = [15.0, 0.0, 0.0]\n");
    let wheel = "[[moving.parts]]\nname = 'wheel'\ntriangles = [[900, 931]]\n\
                 motion.turn = { point_m = [0, 0, 0], axis = [0, 1, 0], rate_rad_s = 1 }\n";
    let wheel = words(asked("motion"), wheel);
    let motion = words(asked("motion"), "[motion]\nduration_s = 0.3\nresolution_s = 0.02\n");
    let lines: Vec<&str> =
        ALL.iter().filter(|(name, ..)| asked(name)).map(|(_, line, _)| *line).collect();
    let heading = words(!lines.iter().all(|line| line.is_empty()), "[effects]\n");
    let poses = "0,0,0,1,6,0.3,0\n0,0,0,1,4.4,-0.4,0\n0.8,0,0,0.6,-3.6,0.2,0.1\n\
                 0,0,0,1,7,2.5,0\n0.8,0,0,-0.6,0.3,2.6,0\n1,0,0,0,-4.45,0.3,0\n";
    place.write("p.csv", &format!("{HEADER}{poses}"));
    let mesh = "mesh = 'builtin:car?triangles=1000'\n";
    let text = format!(
        "version = 1\n[scenarios]\nposes = 'p.csv'\n[fixed]\n{mesh}{mass}{stiffness}\
         [moving]\n{mesh}{mass}{stiffness}{velocity}{wheel}{motion}{heading}{}\n",
        lines.join("\n")
    );
    place.write("scene.toml", &text)
}

pub(super) fn everything() -> Vec<&'static str> {
    ALL.iter().map(|(name, ..)| *name).collect()
}

/// The cells of all columns from one to another.
fn part<'a>(run: &'a Run, [first, last]: [&str; 2]) -> Vec<&'a [String]> {
    let at = |name| run.header.iter().position(|column| column == name).unwrap();
    let columns = at(first)..=at(last);
    run.rows.iter().map(|row| &row[columns.clone()]).collect()
}

#[test]
fn a_scene_that_asks_for_nothing_gets_pairs_and_no_more() {
    let place = Place::new();
    let run = Run::of(&place, &scene(&place, &[]), &[]);
    assert_eq!(run.header, ["scenario", "colliding", "pairs", "pairs_fnv1a64"]);
    assert_eq!(run.table_names(), [""; 0]);
    assert_eq!(run.effects(), [("contacts", 6)]);
}

#[test]
fn an_effect_says_the_same_alone_as_among_all_others() {
    let place = Place::new();
    let all = Run::of(&place, &scene(&place, &everything()), &[]);
    assert_eq!(
        all.effects().iter().map(|(name, _)| *name).skip(1).collect::<Vec<_>>(),
        everything()
    );
    for (effect, _, columns) in ALL {
        let asked = [needs(effect), &[effect]].concat();
        let run = Run::of(&place, &scene(&place, &asked), &[]);
        for columns in [columns, ["scenario", "pairs_fnv1a64"]] {
            assert_eq!(part(&run, columns), part(&all, columns), "{effect}");
        }
        let names: Vec<&str> = run.effects().iter().map(|(name, _)| *name).collect();
        assert_eq!(names, [&["contacts"], &asked[..]].concat(), "what is off is not in it");
        let tables: Vec<&str> =
            TABLES.into_iter().filter(|(_, of)| asked.contains(of)).map(|(name, _)| name).collect();
        assert_eq!(run.table_names(), tables, "{effect}");
        assert!(tables.iter().all(|name| run.tables[*name] == all.tables[*name]), "{effect}");
    }
}

/// By the columns of others, which effects a scenario needs.
#[test]
fn a_scenario_runs_only_what_it_needs() {
    let place = Place::new();
    let run = Run::of(&place, &scene(&place, &everything()), &[]);
    let touching: Vec<bool> = run.cells("colliding").iter().map(|&cell| cell == "1").collect();
    let impact: Vec<bool> =
        run.cells("impact").iter().map(|cell| ["full", "sliding"].contains(cell)).collect();
    let collides = run.cells("motion").iter().map(|cell| *cell != "apart").collect();
    let apart: Vec<bool> = touching.iter().map(|touching| !touching).collect();
    for mixed in [&touching, &impact, &collides] {
        assert!(mixed.contains(&true) && mixed.contains(&false), "the scene is of one kind");
    }
    assert!(run.cells("containment").iter().all(|cell| ["none", ""].contains(cell)));
    let expected = [
        ("contacts.segments", &touching),
        ("containment", &apart),
        ("clearance", &apart),
        ("penetration", &touching),
        ("volume", &touching),
        ("motion", &vec![true; touching.len()]),
        ("response", &collides),
        ("crush", &impact),
    ];
    for ((name, needed), (_, _, [column, _])) in expected.into_iter().zip(ALL) {
        let count = needed.iter().filter(|&&needed| needed).count() as u64;
        assert!(run.effects().contains(&(name, count)), "{name}: {count}, {:?}", run.effects());
        let said: Vec<bool> = run.cells(column).iter().map(|cell| !cell.is_empty()).collect();
        assert_eq!(said, *needed, "{name}");
    }
}
