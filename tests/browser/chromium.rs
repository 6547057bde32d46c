//! Debian's headless Chromium, driven over a pair of pipes: no port, no further crate.
//!
//! Protocol: <https://chromedevtools.github.io/devtools-protocol/>, messages of JSON that end with a
//! zero byte.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// For one answer or event, on a machine that has much else to do.
const PATIENCE: Duration = Duration::from_secs(120);

/// Set where a test without a browser is a failure.
const REQUIRED: &str = "BUMPER_REQUIRE_CHROMIUM";

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// WebGL is drawn by the processor; nothing is asked of any network.
const FLAGS: [&str; 17] = [
    "--headless",
    "--remote-debugging-pipe",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--no-default-browser-check",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--disable-breakpad",
    "--disable-crash-reporter",
    "--hide-scrollbars",
    "--force-color-profile=srgb",
    "--window-size=1280,800",
];

/// A browser with one page. It ends, and its profile is gone, when this is dropped.
pub struct Chromium {
    process: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    profile: tempfile::TempDir,
    session: Value,
    next_id: u64,
    seen: Seen,
}

/// What the page did while something else was waited for.
#[derive(Default)]
struct Seen {
    loaded: bool,
    problems: Vec<String>,
    requests: Vec<String>,
}

impl Chromium {
    /// Nothing where there is no Chromium; then the test says so, and has nothing to do.
    pub fn start() -> Option<Self> {
        let Some(program) = program() else {
            assert!(
                std::env::var_os(REQUIRED).is_none(),
                "{REQUIRED} is set, and none of {NAMES:?} is installed"
            );
            // Not captured, as what `eprintln` says in a test that passes is.
            let _ = writeln!(
                std::io::stderr(),
                "NOT TESTED: none of {NAMES:?} is installed, so no page was looked at"
            );
            return None;
        };
        let mut browser = Self::launch(&program);
        let page = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached = json!({ "targetId": page["targetId"], "flatten": true });
        browser.session = browser.call("Target.attachToTarget", attached)["sessionId"].take();
        for domain in ["Page", "Runtime", "Network", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    fn launch(program: &PathBuf) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let log = File::create(profile.path().join("stderr")).unwrap();
        // It reads commands from descriptor 3 and answers on 4.
        let mut process = Command::new("sh")
            .args(["-c", r#"exec "$0" "$@" 3<&0 4>&1 </dev/null >&2"#])
            .arg(program)
            .args(FLAGS)
            .arg(format!("--user-data-dir={}", profile.path().join("profile").display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(log)
            .process_group(0)
            .spawn()
            .unwrap();
        let (to, out) = (process.stdin.take().unwrap(), process.stdout.take().unwrap());
        let (session, seen) = (Value::Null, Seen::default());
        Self { process, to, from: listen(out), profile, session, next_id: 1, seen }
    }

    /// Asks, and waits for the answer.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        let id = self.next_id;
        self.next_id += 1;
        let mut message = json!({ "id": id, "method": method, "params": params });
        if !self.session.is_null() {
            message["sessionId"] = self.session.clone();
        }
        let sent = self.to.write_all(format!("{message}\0").as_bytes());
        sent.unwrap_or_else(|error| panic!("{method}: {error}\n{}", self.log()));
        let deadline = Instant::now() + PATIENCE;
        loop {
            let mut message = self.receive(deadline, method);
            if message["id"] == id {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].take();
            }
            self.seen.take(&message);
        }
    }

    /// Until the page with everything that belongs to it is there.
    pub fn navigate(&mut self, address: &str) {
        self.seen = Seen::default();
        let answer = self.call("Page.navigate", json!({ "url": address }));
        assert!(answer["errorText"].is_null(), "{address}: {}", answer["errorText"]);
        let deadline = Instant::now() + PATIENCE;
        while !self.seen.loaded {
            let message = self.receive(deadline, "Page.loadEventFired");
            self.seen.take(&message);
        }
    }

    /// Errors and warnings on the console, and exceptions that nobody caught, since the page was
    /// opened.
    pub fn problems(&mut self) -> &[String] {
        self.catch_up();
        &self.seen.problems
    }

    /// Addresses of all requests since the page was opened, that for the page itself first.
    pub fn requests(&mut self) -> &[String] {
        self.catch_up();
        &self.seen.requests
    }

    /// Events come in order: what was there before this question has been seen with its answer.
    fn catch_up(&mut self) {
        self.evaluate("new Promise((done) => setTimeout(() => done(0)))");
    }

    fn receive(&self, deadline: Instant, awaited: &str) -> Value {
        let left = deadline.saturating_duration_since(Instant::now());
        self.from.recv_timeout(left).unwrap_or_else(|error| match error {
            RecvTimeoutError::Timeout => panic!("{awaited} did not come\n{}", self.log()),
            RecvTimeoutError::Disconnected => panic!("Chromium has ended\n{}", self.log()),
        })
    }

    /// What it had to say to its terminal.
    fn log(&self) -> String {
        std::fs::read_to_string(self.profile.path().join("stderr")).unwrap_or_default()
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        let group = self.process.id() as libc::pid_t;
        // SAFETY: a plain system call; the group is that of our own child, which is not reaped yet.
        unsafe { libc::killpg(group, libc::SIGKILL) };
        let _ = self.process.wait();
    }
}

fn program() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let folders: Vec<_> = std::env::split_paths(&path).collect();
    let found = |name: &str| folders.iter().map(|f| f.join(name)).find(|program| program.is_file());
    NAMES.into_iter().find_map(found)
}

/// Messages as they come, until it ends.
fn listen(out: ChildStdout) -> Receiver<Value> {
    let (send, receive) = channel();
    thread::spawn(move || {
        let mut out = BufReader::new(out);
        let mut message = Vec::new();
        while out.read_until(0, &mut message).is_ok_and(|bytes| bytes > 0) {
            let text = message.strip_suffix(&[0]).unwrap_or(&message);
            let Ok(parsed) = serde_json::from_slice(text) else { break };
            if send.send(parsed).is_err() {
                break;
            }
            message.clear();
        }
    });
    receive
}

impl Seen {
    fn take(&mut self, message: &Value) {
        let params = &message["params"];
        match message["method"].as_str().unwrap_or_default() {
            "Page.loadEventFired" => self.loaded = true,
            "Network.requestWillBeSent" => self.requests.push(text(&params["request"]["url"])),
            "Runtime.exceptionThrown" => {
                let details = &params["exceptionDetails"];
                let thrown = text(&details["exception"]["description"]);
                self.problems.push(format!("{}: {thrown}", text(&details["text"])));
            }
            "Runtime.consoleAPICalled"
                if ["error", "warning"].map(Value::from).contains(&params["type"]) =>
            {
                let words = params["args"].as_array().map_or(&[][..], Vec::as_slice);
                let word = |argument: &Value| match &argument["value"] {
                    Value::Null => text(&argument["description"]),
                    value => text(value),
                };
                self.problems.push(words.iter().map(word).collect::<Vec<_>>().join(" "));
            }
            "Log.entryAdded"
                if ["error", "warning"].map(Value::from).contains(&params["entry"]["level"]) =>
            {
                let said = text(&params["entry"]["text"]);
                // Of our own screenshots, which wait for what is being drawn.
                if !said.contains("GPU stall due to ReadPixels") {
                    self.problems.push(said);
                }
            }
            _ => {}
        }
    }
}

fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
