//! The program as its users meet it: real processes, real files.

mod accuracy;
mod bad_input;
mod bench;
mod check;
mod clean;
mod cluster;
mod effects;
mod experiment;
mod interrupt;
mod plan;
mod report;
mod results;
mod resume;
mod stats;
mod view;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Instant;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use serde_json::Value;

const CAR: &str = "builtin:car?triangles=2000";
const TRACKED: &str = "builtin:tracked?triangles=3000";
const HEADER: &str = "qw,qx,qy,qz,tx,ty,tz\n";

/// A folder of its own for each test, gone with it.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> String {
        fs::write(self.path(name), text).unwrap();
        self.text(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    fn bumper(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bumper"));
        command.args(arguments).stdin(Stdio::null());
        command.env("XDG_CACHE_HOME", self.path("cache"));
        // The engine keeps what belongs to a run below here.
        fs::create_dir_all(self.path("runtime")).unwrap();
        command.env("XDG_RUNTIME_DIR", self.path("runtime"));
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.bumper(arguments).output().unwrap()
    }

    /// `bumper run` of two small vehicles, with more arguments. With two workers if these say
    /// nothing else: as many as cores need more memory than a container may have.
    fn run_small(&self, arguments: &[&str]) -> Output {
        let small = ["run", "--fixed", TRACKED, "--moving", CAR, "--count", "60"];
        let workers: &[&str] =
            if arguments.contains(&"--workers") { &[] } else { &["--workers", "2"] };
        self.run(&[&small, workers, arguments].concat())
    }
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn succeeded(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
}

fn refused(output: &Output, code: i32, words: &[&str]) {
    let error = stderr(output);
    assert_eq!(output.status.code(), Some(code), "{error}");
    assert_eq!(stdout(output), "", "nothing is answered");
    for word in words {
        assert!(error.contains(word), "`{word}` is missing in:\n{error}");
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Contacts of each scenario, from `contacts.parquet`.
fn contacts(path: &Path) -> BTreeMap<u32, Vec<[u32; 2]>> {
    let reader = SerializedFileReader::new(fs::File::open(path).unwrap()).unwrap();
    let mut contacts = BTreeMap::<u32, Vec<[u32; 2]>>::new();
    for row in reader.get_row_iter(None).unwrap() {
        let row = row.unwrap();
        let [scenario, fixed, moving] = [0, 1, 2].map(|column| row.get_uint(column).unwrap());
        contacts.entry(scenario).or_default().push([fixed, moving]);
    }
    contacts
}

/// The rows of `scenarios.csv`: scenario, pairs, hash.
fn scenarios(path: &Path) -> Vec<(u32, usize, String)> {
    let text = fs::read_to_string(path).unwrap();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        (fields[0].parse().unwrap(), fields[2].parse().unwrap(), fields[3].to_owned())
    };
    text.lines().skip(1).map(row).collect()
}

fn agree(out: &Path) {
    let contacts = contacts(&out.join("contacts.parquet"));
    let rows = scenarios(&out.join("scenarios.csv"));
    let mut total = 0;
    for (scenario, count, hash) in rows {
        let pairs = contacts.get(&scenario).map_or(&[][..], Vec::as_slice);
        assert_eq!(pairs.len(), count, "scenario {scenario}");
        assert_eq!(format!("{:016x}", bumper::effects::contacts::pairs_fnv1a64(pairs)), hash);
        total += count;
    }
    assert_eq!(contacts.values().map(Vec::len).sum::<usize>(), total, "no others");
    assert_eq!(json(&out.join("summary.json"))["pairs"], total);
}

#[test]
fn help_and_version_say_what_there_is() {
    let place = Place::new();
    let output = place.run(&["--help"]);
    succeeded(&output);
    assert!(stdout(&output).contains("run") && !stdout(&output).contains("worker"));
    let output = place.run(&["--version"]);
    succeeded(&output);
    assert_eq!(stdout(&output).trim(), concat!("bumper ", env!("CARGO_PKG_VERSION")));
}
