//! What `bumper view` makes, looked at.

mod geometry;
mod server;
mod shown;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

use crate::chromium::Chromium;
use crate::png::{self, Picture};

const SMALL: [&str; 6] = [
    "--fixed",
    "builtin:tracked?triangles=1500",
    "--moving",
    "builtin:car?triangles=1000",
    "--workers",
    "2",
];

/// Two boxes of a kind, near each other and overlapping, with everything that can be drawn.
const EVERYTHING: &str = r#"version = 1
[fixed]
mesh = "builtin:blocks?triangles=12"
depth = 2
[moving]
mesh = "builtin:blocks?triangles=12"
depth = 2
velocity_m_s = [-1.0, 0.1, 0.0]
spin_rad_s = [0.1, 0.2, 0.9]
cg_m = [0.01, 0.02, 0.0]
[scenarios]
poses = "poses.csv"
[motion]
duration_s = 1.0
resolution_s = 0.01
[effects]
segments = true
clearance = {}
penetration = { direction = [1.0, 0.0, 0.0], least = true, directions = 8 }
[engine]
workers = 2
"#;

/// One overlaps, two come to impact, one goes away.
const POSES: &str = "qw,qx,qy,qz,tx,ty,tz\n1,0,0,0,0.2,0.05,0.03\n1,0,0,0,0.6,0,0\n\
                     0.8,0,0,0.6,0.5,0.1,0.05\n0,0,0,1,0.7,0.2,0\n";

/// A folder of its own for each test, with pages in it.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        fs::create_dir_all(place.path("runtime")).unwrap();
        place
    }

    /// With the scene that has everything.
    fn with_everything() -> (Self, String) {
        let place = Self::new();
        fs::write(place.path("poses.csv"), POSES).unwrap();
        fs::write(place.path("scene.toml"), EVERYTHING).unwrap();
        let scene = place.path("scene.toml").to_str().unwrap().to_owned();
        (place, scene)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn bumper(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bumper"));
        command.args(arguments).stdin(Stdio::null()).current_dir(self.0.path());
        command.env("XDG_CACHE_HOME", self.path("cache"));
        command.env("XDG_RUNTIME_DIR", self.path("runtime"));
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let output = self.bumper(arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output
    }

    /// The page of a scene, open.
    fn open(&self, arguments: &[&str]) -> Option<Chromium> {
        let browser = Chromium::start()?;
        self.run(&[&["view", "--out", "page.html"], arguments].concat());
        Some(shown(browser, &self.path("page.html")))
    }
}

fn shown(mut browser: Chromium, page: &Path) -> Chromium {
    browser.resize([920, 520]);
    browser.open(page);
    ready(&mut browser);
    // It is over the picture, and its round corners are not always the same.
    browser.press("l");
    assert_eq!(browser.evaluate("document.getElementById('legend').hidden"), true);
    browser
}

fn ready(browser: &mut Chromium) {
    let condition = "document.documentElement.dataset.ready === 'true' || \
                     document.getElementById('status').textContent.startsWith('This page')";
    browser.wait_until(condition);
    assert_eq!(browser.evaluate("document.documentElement.dataset.ready"), "true");
}

/// The vehicles, without what is beside them, once they stand still.
fn picture(browser: &mut Chromium) -> Picture {
    browser.wait_until("!bumper.stage.isAsked && !bumper.stage.flight");
    // What was drawn in one frame is on the screen after the next.
    let frame = "new Promise((done) => requestAnimationFrame(() => done(true)))";
    (0..2).for_each(|_| assert_eq!(browser.evaluate(frame), true));
    let place =
        browser.evaluate("Object.values(bumper.page.canvas.getBoundingClientRect().toJSON())");
    let number = |at: usize| place[at].as_f64().unwrap() as usize;
    let (x, y, width, height) = (number(0), number(1), number(2), number(3));
    let whole = png::decode(&browser.screenshot());
    // Below the status.
    whole.part(x..x + width, y + 60..y + height)
}

/// That something changes what is drawn, and taking it back takes that back.
fn changes_the_picture(browser: &mut Chromium, there: &str, back: &str) {
    let before = picture(browser);
    browser.evaluate(there);
    differs(browser, &before, there);
    browser.evaluate(back);
    assert!(comes(browser, |now| now.changed(&before) == 0.0), "{back} does not take it back");
}

fn differs(browser: &mut Chromium, before: &Picture, why: &str) -> Picture {
    assert!(comes(browser, |now| now.changed(before) > 0.0), "{why} changes nothing");
    picture(browser)
}

/// Whether a picture comes soon: a busy machine may show what was drawn some frames later.
fn comes(browser: &mut Chromium, is_it: impl Fn(&Picture) -> bool) -> bool {
    (0..20).any(|_| is_it(&picture(browser)))
}

fn text_of(browser: &mut Chromium, id: &str) -> String {
    let text = browser.evaluate(&format!("document.getElementById('{id}').textContent"));
    text.as_str().unwrap().to_owned()
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}
