//! What a user does with a page, and what a test wants to know of it.

use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use super::chromium::Chromium;

const PATIENCE: Duration = Duration::from_secs(120);

impl Chromium {
    /// A page in a file.
    pub fn open(&mut self, path: &Path) {
        let path = path.canonicalize().unwrap();
        self.navigate(&format!("file://{}", path.display()));
    }

    /// The value of an expression, when it has settled if it is a promise.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let params =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", params);
        let thrown = &answer["exceptionDetails"];
        assert!(thrown.is_null(), "{expression}: {thrown}");
        answer["result"]["value"].take()
    }

    /// Until an expression is true.
    pub fn wait_until(&mut self, condition: &str) {
        let deadline = Instant::now() + PATIENCE;
        while self.evaluate(condition) != true {
            assert!(Instant::now() < deadline, "never true: {condition}");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// A key by its name in `KeyboardEvent.key`.
    pub fn press(&mut self, key: &str) {
        let mut down = json!({ "type": "keyDown", "key": key });
        if key.chars().count() == 1 {
            down["text"] = key.into();
        } else {
            down["code"] = key.into();
        }
        self.call("Input.dispatchKeyEvent", down);
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": key }));
    }

    /// Where, in pixels of the page from its upper left corner.
    pub fn click(&mut self, at: [f64; 2]) {
        self.mouse("mouseMoved", at, json!({}));
        let left = json!({ "button": "left", "clickCount": 1 });
        self.mouse("mousePressed", at, left.clone());
        self.mouse("mouseReleased", at, left);
    }

    /// With the left button.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        let left = json!({ "button": "left", "buttons": 1, "clickCount": 1 });
        self.mouse("mousePressed", from, left.clone());
        for step in 1..=4 {
            let part = f64::from(step) / 4.0;
            let at = [0, 1].map(|k| from[k] + part * (to[k] - from[k]));
            self.mouse("mouseMoved", at, left.clone());
        }
        self.mouse("mouseReleased", to, json!({ "button": "left", "clickCount": 1 }));
    }

    /// With the wheel, downwards.
    pub fn scroll(&mut self, at: [f64; 2], by: f64) {
        self.mouse("mouseWheel", at, json!({ "deltaX": 0, "deltaY": by }));
    }

    fn mouse(&mut self, kind: &str, at: [f64; 2], mut params: Value) {
        params["type"] = kind.into();
        params["x"] = at[0].into();
        params["y"] = at[1].into();
        self.call("Input.dispatchMouseEvent", params);
    }

    /// Media features of CSS and what they are to be.
    pub fn emulate(&mut self, features: &[(&str, &str)]) {
        let feature = |(name, value): &(&str, &str)| json!({ "name": name, "value": value });
        let features: Vec<_> = features.iter().map(feature).collect();
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Of the window in pixels.
    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// A PNG of what is seen of the page.
    pub fn screenshot(&mut self) -> Vec<u8> {
        let picture = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        decoded(&picture["data"])
    }

    /// The whole page on paper.
    pub fn print_to_pdf(&mut self) -> Vec<u8> {
        let paper = self.call("Page.printToPDF", json!({ "printBackground": true }));
        decoded(&paper["data"])
    }
}

fn decoded(data: &Value) -> Vec<u8> {
    BASE64_STANDARD.decode(data.as_str().unwrap()).unwrap()
}
