//! Output directories of commands, read back to be shown.
//!
//! A command that draws its own figures makes them from what it has just written, by the same code:
//! a file and its report cannot differ.

mod accuracy;
mod bench;
mod measured;
mod run;
mod scenarios;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::Drawing;
use super::figure::{FigureError, Table, grouped, number};

/// What is to be shown of one command's output.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    pub heading: String,
    /// The file, as the user named its directory.
    pub origin: PathBuf,
    /// What made it, and the machine it was made on: names and values.
    pub made_by: Vec<[String; 2]>,
    /// What has to be known to read the figures.
    pub notes: Vec<String>,
    pub drawings: Vec<Drawing>,
    pub tables: Vec<Table>,
    /// All of the file.
    pub json: String,
}

/// A command's output, known by the name of its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    Run,
    BenchTransport,
    BenchEngine,
    Accuracy,
    Experiment,
    Cluster,
}

#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    #[error("{path}: cannot be read: {source}", path = path.display())]
    Io { path: PathBuf, source: std::io::Error },
    #[error(
        "{path}: holds no output of a command: none of {files} is there",
        path = path.display(),
        files = Source::ALL.map(Source::file).join(", ")
    )]
    Nothing { path: PathBuf },
    #[error("{path}: is not what bumper writes, or only a part of it: {source}", path = path.display())]
    Json { path: PathBuf, source: serde_json::Error },
    #[error(
        "{path}: has schema_version {found}, and this bumper knows {SCHEMA_VERSION}: use the one \
         that wrote it",
        path = path.display()
    )]
    SchemaVersion { path: PathBuf, found: u64 },
    #[error("{path}: is of the kind `{found}`, not `{expected}`", path = path.display())]
    Kind { path: PathBuf, found: String, expected: &'static str },
    #[error("{path}: {source}", path = path.display())]
    Figure { path: PathBuf, source: FigureError },
    #[error("{path}: line {line}: {reason}", path = path.display())]
    Row { path: PathBuf, line: usize, reason: String },
    #[error(
        "{path}: has {found} scenarios, and the summary beside it {expected}",
        path = path.display()
    )]
    Scenarios { path: PathBuf, found: u64, expected: u64 },
}

/// Of all files that are read here.
const SCHEMA_VERSION: u64 = 1;

impl Source {
    pub const ALL: [Self; 6] = [
        Self::Run,
        Self::BenchTransport,
        Self::BenchEngine,
        Self::Accuracy,
        Self::Experiment,
        Self::Cluster,
    ];

    pub fn file(self) -> &'static str {
        match self {
            Self::Run => "summary.json",
            Self::BenchTransport => "bench_transport.json",
            Self::BenchEngine => "bench_engine.json",
            Self::Accuracy => "accuracy.json",
            Self::Experiment => "experiment.json",
            Self::Cluster => "cluster.json",
        }
    }

    /// Of the text of its file in a directory.
    pub fn section(self, folder: &Path, json: String) -> Result<Section, SourceError> {
        let file = ReadFile { folder, path: folder.join(self.file()), json: &json };
        let found = file.parse::<Head>()?.schema_version;
        if found != SCHEMA_VERSION {
            return Err(SourceError::SchemaVersion { path: file.path, found });
        }
        let shown = match self {
            Self::Run => run::show(&file),
            Self::BenchTransport => bench::show_transport(&file),
            Self::BenchEngine => bench::show_engine(&file),
            Self::Accuracy => accuracy::show(&file),
            Self::Experiment => measured::show(&file, "experiment"),
            Self::Cluster => measured::show(&file, "cluster"),
        }?;
        let checks = shown.drawings.iter().map(Drawing::check);
        checks
            .chain(shown.tables.iter().map(Table::check))
            .collect::<Result<(), _>>()
            .map_err(|source| SourceError::Figure { path: file.path.clone(), source })?;
        let MadeBy { versions, machine } = file.parse()?;
        let made_by = [versions, machine].iter().flat_map(|value| facts("", value)).collect();
        let (Shown { heading, notes, drawings, tables }, origin) = (shown, file.path);
        Ok(Section { heading, origin, made_by, notes, drawings, tables, json })
    }
}

/// Of everything that is in a directory, at least one.
pub fn sections(folder: &Path) -> Result<Vec<Section>, SourceError> {
    let unreadable = |path: &Path| {
        let path = path.to_owned();
        |source| SourceError::Io { path, source }
    };
    // Tells a directory that is not there from one without our files.
    fs::read_dir(folder).map_err(unreadable(folder))?;
    let mut sections = Vec::new();
    for source in Source::ALL {
        let path = folder.join(source.file());
        match fs::read_to_string(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(unreadable(&path)(error)),
            Ok(json) => sections.push(source.section(folder, json)?),
        }
    }
    match sections.is_empty() {
        true => Err(SourceError::Nothing { path: folder.to_owned() }),
        false => Ok(sections),
    }
}

struct ReadFile<'a> {
    folder: &'a Path,
    path: PathBuf,
    json: &'a str,
}

impl ReadFile<'_> {
    fn parse<T: DeserializeOwned>(&self) -> Result<T, SourceError> {
        let path = || self.path.clone();
        serde_json::from_str(self.json).map_err(|source| SourceError::Json { path: path(), source })
    }
}

#[derive(Deserialize)]
struct Head {
    schema_version: u64,
}

/// In every file.
#[derive(Deserialize)]
struct MadeBy {
    versions: Value,
    machine: Value,
}

struct Shown {
    heading: String,
    notes: Vec<String>,
    drawings: Vec<Drawing>,
    tables: Vec<Table>,
}

/// The entries of an object, whatever they are: what a later version adds is shown too.
fn facts(prefix: &str, value: &Value) -> Vec<[String; 2]> {
    let Value::Object(entries) = value else {
        return if value.is_null() { Vec::new() } else { vec![[prefix.to_owned(), words(value)]] };
    };
    let fact =
        |(name, value): (&String, &Value)| match (name.strip_suffix("_bytes"), value.as_f64()) {
            (Some(name), Some(bytes)) => {
                vec![[spaced(name), format!("{} GB", number((bytes * 1e-7).round() * 1e-2))]]
            }
            _ => facts(&spaced(name), value),
        };
    entries.iter().flat_map(fact).collect()
}

fn unfinished(done: u64, asked: u64) -> Vec<String> {
    let note = || format!("not finished: {} of {} scenarios", grouped(done), grouped(asked));
    (done < asked).then(note).into_iter().collect()
}

fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

fn words(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// A table of names and values.
fn listed(title: &str, rows: Vec<[String; 2]>) -> Table {
    table(title, &["", ""], rows.into_iter().map(Vec::from).collect())
}

fn table(title: &str, columns: &[&str], rows: Vec<Vec<String>>) -> Table {
    let columns = columns.iter().map(|&column| column.to_owned()).collect();
    Table { title: title.to_owned(), columns, rows }
}

/// A body of a scene.
#[derive(Deserialize)]
struct Body {
    mesh: String,
}

impl Body {
    /// Without its folder and its ending.
    fn name(&self) -> String {
        let stem = Path::new(&self.mesh).file_stem();
        stem.map_or_else(|| self.mesh.clone(), |stem| stem.display().to_string())
    }
}

#[cfg(test)]
mod tests;
