//! What is on the page, and what its controls do.

use serde_json::json as value;

use super::*;

#[test]
fn the_page_says_what_the_run_said_and_asks_nobody_for_anything() {
    let place = Place::new();
    let small = [&SMALL[..], &["--count", "12"]].concat();
    let Some(mut browser) = place.open(&small) else { return };
    place.run(&[&["run", "--out", "run"], &small[..]].concat());
    let summary = json(&place.path("run/summary.json"));
    for count in ["scenarios", "colliding", "pairs"] {
        let shown = text_of(&mut browser, &format!("run-{count}")).replace(',', "");
        assert_eq!(shown, summary[count].to_string(), "{count}");
    }
    let rows = fs::read_to_string(place.path("run/scenarios.csv")).unwrap();
    let rows: Vec<_> = rows.lines().skip(1).map(|row| row.split(',').nth(2).unwrap()).collect();
    let shown = browser.evaluate("[...bumper.model.scenarios.pairs].join()");
    assert_eq!(shown, rows.join(","));
    assert!(picture(&mut browser).colours() > 20, "a blank picture");
    assert_eq!(browser.problems(), [""; 0]);
    let page = place.path("page.html").canonicalize().unwrap();
    assert_eq!(browser.requests(), [format!("file://{}", page.display())]);
}

#[test]
fn a_scenario_is_chosen_by_list_slider_and_keys() {
    let place = Place::new();
    let Some(mut browser) = place.open(&[&SMALL[..], &["--count", "12"]].concat()) else { return };
    let mut last = picture(&mut browser);
    let mut comes = |browser: &mut Chromium, number: u32, how: &str| {
        assert_eq!(text_of(browser, "heading"), format!("Scenario {number}"), "{how}");
        last = differs(browser, &last, how);
    };
    browser.evaluate("document.querySelector('[data-at=\"3\"]').click()");
    comes(&mut browser, 3, "the list");
    browser.evaluate("const s = document.getElementById('slider'); s.value = 7; s.dispatchEvent(new Event('input'))");
    comes(&mut browser, 7, "the slider");
    for (key, number) in
        [("ArrowRight", 8), ("ArrowLeft", 7), ("Home", 0), ("PageDown", 10), ("End", 11)]
    {
        browser.press(key);
        comes(&mut browser, number, key);
    }
    browser.evaluate(
        "const e = bumper.list.elements; e.sort.value = 'pairs'; e.descending.checked = true; bumper.list.arrange()",
    );
    for (key, depth) in [("b", 4), ("]", 5), ("[", 4), ("[", 3)] {
        let before = picture(&mut browser);
        browser.press(key);
        differs(&mut browser, &before, key);
        assert_eq!(text_of(&mut browser, "depth-reading"), format!("depth {depth}"));
    }
    let most = "bumper.model.scenarios.pairs[bumper.list.order[0]] === Math.max(...bumper.model.scenarios.pairs)";
    assert_eq!(browser.evaluate(most), true);
    browser.evaluate(
        "e.least.value = 1 + Math.max(...bumper.model.scenarios.pairs); bumper.list.arrange()",
    );
    assert_eq!(text_of(&mut browser, "count"), "0 of 12 listed");
    assert_eq!(browser.problems(), [""; 0]);
}

#[test]
fn every_switch_changes_the_picture() {
    let (place, scene) = Place::with_everything();
    let Some(mut browser) = place.open(&[&scene]) else { return };
    for name in ["contacts", "curves", "arrows", "boxes", "byWorker", "onTop"] {
        let switch = format!("bumper.toggle('{name}')");
        changes_the_picture(&mut browser, &switch, &switch);
    }
    for look in ["ghost", "hidden"] {
        let (there, back) = (format!("bumper.setLook(1, '{look}')"), "bumper.setLook(1, 'solid')");
        changes_the_picture(&mut browser, &there, back);
    }
    browser.evaluate("bumper.choose(1)");
    changes_the_picture(&mut browser, "bumper.toggle('arrows')", "bumper.toggle('arrows')");
    let legend = text_of(&mut browser, "entries");
    assert!(legend.contains("clearance: "), "{legend}");
    assert_eq!(browser.problems(), [""; 0]);
}

#[test]
fn every_key_of_the_help_does_something() {
    let (place, scene) = Place::with_everything();
    let Some(mut browser) = place.open(&[&scene]) else { return };
    browser.press("?");
    browser.wait_until("document.getElementById('help').open");
    let help = text_of(&mut browser, "help");
    assert!(
        help.contains("next in the list") && help.contains("time of the first impact"),
        "{help}"
    );
    browser.press("?");
    browser.wait_until("!document.getElementById('help').open");
    for key in ["c", "u", "r", "o"] {
        let before = picture(&mut browser);
        browser.press(key);
        differs(&mut browser, &before, key);
        browser.press(key);
        assert!(comes(&mut browser, |now| now.changed(&before) == 0.0), "{key} again");
    }
    for key in ["b", "w", "g", "h", "1", "2", "3", "f", "a", "+", "-", "t", "n", "i", "."] {
        let before = picture(&mut browser);
        browser.press(key);
        differs(&mut browser, &before, key);
    }
    assert_eq!(browser.problems(), [""; 0]);
}

#[test]
fn the_mouse_turns_zooms_and_names_a_triangle() {
    let (place, scene) = Place::with_everything();
    let Some(mut browser) = place.open(&[&scene]) else { return };
    let middle = [456.0, 220.0];
    browser.click(middle);
    browser.wait_until("!document.getElementById('status').hidden");
    let said = text_of(&mut browser, "status");
    assert!(said.contains("triangle ") && said.contains("builtin:blocks"), "{said}");
    let before = picture(&mut browser);
    browser.drag(middle, [500.0, 250.0]);
    let turned = differs(&mut browser, &before, "dragging");
    browser.scroll(middle, -240.0);
    differs(&mut browser, &turned, "the wheel");
}

#[test]
fn a_page_is_light_or_dark_and_moves_only_for_those_who_like_it() {
    let (place, scene) = Place::with_everything();
    let Some(mut browser) = place.open(&[&scene]) else { return };
    let corner = |browser: &mut Chromium| {
        let picture = picture(browser);
        picture.pixel(picture.width - 2, 2)
    };
    let light = corner(&mut browser);
    browser.emulate(&[("prefers-color-scheme", "dark")]);
    browser.wait_until("document.documentElement.dataset.theme === 'dark'");
    let dark = corner(&mut browser);
    assert!(light.iter().all(|&c| c > 200) && dark.iter().all(|&c| c < 60), "{light:?} {dark:?}");
    let jumps =
        |from: &str| format!("bumper.lookAtAll('{from}'), bumper.stage.flight.begin === -Infinity");
    assert_eq!(browser.evaluate(&jumps("front")), false);
    browser.wait_until("!bumper.stage.flight");
    browser.emulate(&[("prefers-reduced-motion", "reduce")]);
    assert_eq!(browser.evaluate(&jumps("left")), true);
    browser.evaluate("bumper.timeline.play()");
    assert_eq!(
        browser.evaluate("[bumper.timeline.playing, bumper.timeline.seconds]"),
        value!([null, 0.1])
    );
}

#[test]
fn names_of_files_are_shown_as_they_are() {
    let place = Place::new();
    let name = "<img src=x onerror=document.title=1>&amp;.ply";
    let mesh = SMALL[3].parse::<bumper::mesh::MeshSource>().unwrap().load().unwrap();
    bumper::mesh::write_ply(&mesh, &place.path(name)).unwrap();
    let hostile = ["--fixed", name, "--moving", name, "--count", "1", "--workers", "1"];
    let Some(mut browser) = place.open(&hostile) else { return };
    assert_eq!(text_of(&mut browser, "title"), format!("{name} – {name}"));
    assert!(text_of(&mut browser, "entries").contains(name));
    assert_eq!(browser.evaluate("document.images.length"), 0);
    assert_eq!(browser.problems(), [""; 0]);
}

/// The picture of the README, where `BUMPER_SCREENSHOTS` names a folder for it.
#[test]
fn screenshots_are_made_where_they_are_wanted() {
    let Some(folder) = std::env::var_os("BUMPER_SCREENSHOTS") else { return };
    let Some(mut browser) = Chromium::start() else { return };
    let place = Place::new();
    let scene = "version = 1\nfixed.mesh = 'builtin:tracked'\nmoving.mesh = 'builtin:car'\n\
                 scenarios.random.count = 60\neffects.segments = true\n";
    fs::write(place.path("scene.toml"), scene).unwrap();
    place.run(&["view", "scene.toml"]);
    browser.resize([1200, 720]);
    browser.open(&place.path("bumper.html"));
    ready(&mut browser);
    browser.evaluate("bumper.choose(9); bumper.lookAtContacts()");
    picture(&mut browser);
    browser.evaluate("bumper.stage.zoom(2.2)");
    picture(&mut browser);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder).join("viewer.png");
    fs::write(file, browser.screenshot()).unwrap();
}
