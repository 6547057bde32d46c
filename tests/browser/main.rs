//! Pages as their readers meet them: in a real browser, without a screen.

mod chromium;
mod driving;
mod png;
mod report;
mod viewer;

use chromium::Chromium;
use serde_json::json;

/// A page with one of everything that the tests of our pages rely on to be noticed.
const PAGE: &str = r#"<!doctype html><meta charset="utf-8"><title>a page</title>
<style>body { background: #fff; margin: 0 } @media (prefers-color-scheme: dark) { body { background: #000 } }</style>
<button id="b" style="position: absolute; left: 10px; top: 10px; width: 100px; height: 40px">0</button>
<script>
  let keys = '', clicks = 0, wheel = 0, moved = 0;
  addEventListener('keydown', (e) => keys += e.key);
  addEventListener('wheel', (e) => wheel += e.deltaY);
  addEventListener('pointermove', (e) => moved += e.buttons === 1);
  b.onclick = () => b.textContent = ++clicks;
</script>"#;

fn open_page(text: &str) -> Option<(Chromium, tempfile::TempDir)> {
    let mut browser = Chromium::start()?;
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("page.html");
    std::fs::write(&path, text).unwrap();
    browser.open(&path);
    Some((browser, place))
}

#[test]
fn keys_and_the_mouse_reach_a_page() {
    let Some((mut browser, _place)) = open_page(PAGE) else { return };
    assert_eq!(browser.evaluate("document.title"), "a page");
    ["a", "?", "ArrowLeft"].into_iter().for_each(|key| browser.press(key));
    assert_eq!(browser.evaluate("keys"), "a?ArrowLeft");
    browser.click([60.0, 30.0]);
    browser.click([60.0, 30.0]);
    browser.wait_until("b.textContent === '2'");
    browser.drag([200.0, 200.0], [300.0, 250.0]);
    browser.wait_until("moved > 0");
    browser.scroll([200.0, 200.0], 120.0);
    browser.wait_until("wheel === 120");
    assert_eq!(browser.evaluate("Promise.resolve([1, 'x'])"), json!([1, "x"]));
    assert_eq!(browser.problems(), [""; 0]);
}

#[test]
fn pictures_are_of_what_is_there() {
    let Some((mut browser, _place)) = open_page(PAGE) else { return };
    browser.resize([500, 400]);
    let light = png::decode(&browser.screenshot());
    browser.emulate(&[("prefers-color-scheme", "dark")]);
    let dark = png::decode(&browser.screenshot());
    assert_eq!([light.width, light.height], [500, 400]);
    assert_eq!([light.pixel(499, 399), dark.pixel(499, 399)], [[255; 3], [0; 3]]);
    assert!(light.changed(&dark) > 0.9 && light.changed(&light) == 0.0);
    let empty = dark.part(200..300, 300..400);
    assert_eq!([empty.colours(), empty.count_near([2, 0, 0], 2)], [1, 100 * 100]);
    assert!(light.colours() > 2, "there is a button");
    assert!(browser.print_to_pdf().starts_with(b"%PDF"));
}

#[test]
fn problems_of_a_page_and_its_requests_are_seen() {
    let page = "<script>console.error('no', 5); fetch('http://127.0.0.1:9/x').catch(() => 0); \
                setTimeout(() => { throw new Error('thrown') })</script>";
    let Some((mut browser, _place)) = open_page(page) else { return };
    browser.wait_until("true");
    let (problems, requests) = (browser.problems().join("\n"), browser.requests());
    assert!(problems.contains("no 5") && problems.contains("thrown"), "{problems}");
    let leaves = |request: &&String| !request.starts_with("file:");
    assert_eq!(requests.iter().filter(leaves).collect::<Vec<_>>(), ["http://127.0.0.1:9/x"]);
}
