//! `bumper plan`: the steps of a scene, what is left out, and what they are likely to cost.

use super::{Place, stderr, stdout};

#[test]
fn a_plan_has_the_steps_of_its_scene_and_what_is_left_out() {
    let place = Place::new();
    let command = "bumper plan config/effects/crash.toml";
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/config/effects/crash.toml");
    let verb = command.split(' ').nth(1).unwrap();
    let output = place.run(&[verb, scene, "--sample", "2", "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let plan: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(plan["sample"], 2);
    let names = |list: &str| -> Vec<String> {
        let list = plan[list].as_array().unwrap();
        list.iter().map(|step| step["effect"].as_str().unwrap().to_owned()).collect()
    };
    let (steps, left_out) = (names("steps"), names("left_out"));
    assert_eq!(steps[0], "contacts");
    for effect in ["clearance", "motion", "response", "crush"] {
        assert!(steps.iter().any(|step| step == effect), "{steps:?}");
    }
    assert!(left_out.iter().all(|name| !steps.contains(name)), "{left_out:?}");
    // Both cars of the first two scenarios start apart.
    let clearance = steps.iter().position(|step| step == "clearance").unwrap();
    assert_eq!(plan["steps"][clearance]["needed"], 2);
}

#[test]
fn a_scene_without_effects_leaves_all_of_them_out_and_says_what_would_call_for_each() {
    let place = Place::new();
    let output = place.run(&[
        "plan",
        "--fixed",
        "builtin:tracked?triangles=1000",
        "--moving",
        "builtin:car?triangles=1000",
        "--sample",
        "3",
    ]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    let (runs, left_out) = text.split_once("left out").expect("something is left out");
    assert!(runs.contains("3,744 scenarios") && runs.contains("contacts "), "{text}");
    for key in ["effects.clearance", "effects.segments", "motion.duration_s", "effects.crush"] {
        assert!(left_out.contains(key) && !runs.contains(key), "{key}: {text}");
    }
}

#[test]
fn the_crash_of_the_readme_runs_as_it_is_written() {
    let place = Place::new();
    let command = "bumper run config/effects/crash.toml --out results";
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/config/effects/crash.toml");
    let out = place.text("results");
    let words = command.split(' ').skip(1).map(|word| match word {
        "config/effects/crash.toml" => scene,
        "results" => &out,
        other => other,
    });
    let small = ["--fixed", "builtin:car?triangles=1000", "--moving", "builtin:car?triangles=1000"];
    let words: Vec<&str> = words.chain(small).collect();
    let output = place.run(&words);
    assert!(output.status.success(), "{}", stderr(&output));
    let (head, table) = stdout(&output)
        .split_once("\neffect ")
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .expect("a table of effects");
    assert!(
        head.contains("scenarios     6") && table.contains("motion") && table.contains("crush")
    );
}
