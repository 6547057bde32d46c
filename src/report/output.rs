//! The output directory of a run.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::Summary;
use super::parquet::{CONTACTS, TableFile};
use super::scenarios_csv::{self, ScenariosCsv};
use crate::effects::TABLES;
use crate::effects::layout::{Layout, Table};
use crate::scheduler::client_manager::ScenarioResult;

/// The scene as it was run.
pub const SCENE: &str = "scene.toml";
const SUMMARY: &str = "summary.json";
const SCENARIOS: &str = "scenarios.csv";
/// Of the fixed and of the moving vehicle, after a crash.
pub const DEFORMED: [&str; 2] = ["fixed_deformed.ply", "moving_deformed.ply"];

#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    #[error("{path}: cannot write results here: {source}", path = path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{path}: cannot be completed: {source}", path = path.display())]
    Incomplete { path: PathBuf, source: io::Error },
    #[error(
        "{path}: holds files, but not of an earlier run: choose a new or an empty directory",
        path = path.display()
    )]
    NotOurs { path: PathBuf },
    #[error(
        "{path}: a run that is still going on writes its results here: choose another directory, \
         or wait for its end",
        path = path.display()
    )]
    InUse { path: PathBuf },
}

/// What a run writes, beside its summary and its scenarios.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// The scene as a file.
    pub scene: String,
    pub contacts: bool,
    pub overlap_only: bool,
    /// Of what effects say.
    pub layout: Layout,
}

impl Outputs {
    fn tables(&self) -> impl Iterator<Item = &'static Table> {
        self.contacts.then_some(&CONTACTS).into_iter().chain(self.layout.tables())
    }
}

/// A directory that results can be written to: a new one, an empty one, or one that holds an
/// earlier run (its `scenarios.csv` starts with our header). Only files of our names are ever
/// replaced, and only when the first results are about to come. Nobody else has it meanwhile.
#[derive(Debug)]
pub struct OutputDir {
    path: PathBuf,
    lock: File,
}

impl OutputDir {
    /// Makes the directory where there is none, and tries whether it can be written to.
    pub fn prepare(path: &Path) -> Result<Self, OutputError> {
        let unusable = |source| OutputError::Io { path: path.to_owned(), source };
        fs::create_dir_all(path).map_err(unusable)?;
        let lock = File::open(path).map_err(unusable)?;
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(OutputError::InUse { path: path.to_owned() });
            }
            // Some file systems cannot lock a directory.
            Err(TryLockError::Error(error)) => {
                let path = path.display();
                tracing::warn!("{path}: no second run is kept from writing here: {error}");
            }
            Ok(()) => {}
        }
        if !is_empty(path).map_err(unusable)? && !holds_a_run(path) {
            return Err(OutputError::NotOurs { path: path.to_owned() });
        }
        // Vanishes at once: only its creation matters.
        tempfile::tempfile_in(path).map_err(unusable)?;
        Ok(Self { path: path.to_owned(), lock })
    }

    /// Replaces the files of an earlier run by new ones.
    pub fn start(self, outputs: Outputs) -> Result<ResultFiles, OutputError> {
        let path = self.path.clone();
        self.replace_files(outputs).map_err(|source| OutputError::Io { path, source })
    }

    fn replace_files(self, outputs: Outputs) -> io::Result<ResultFiles> {
        let tables = TABLES.iter().chain([&CONTACTS.name]).map(|name| table_file(name));
        let others = [SUMMARY].iter().chain(&DEFORMED).map(|&name| name.to_owned());
        for path in others.chain(tables) {
            let path = self.path.join(path);
            remove_if_there(&path)?;
            remove_if_there(&partial(&path))?;
        }
        fs::write(self.path.join(SCENE), &outputs.scene)?;
        let scenarios = ScenariosCsv::create(&self.path.join(SCENARIOS), &outputs)?;
        let create = |table: &Table| {
            let name = table_file(table.name);
            let file = TableFile::create(&partial(&self.path.join(&name)), table)?;
            Ok((name, file))
        };
        let tables = outputs.tables().map(create).collect::<io::Result<_>>()?;
        Ok(ResultFiles { folder: self.path, _lock: self.lock, outputs, scenarios, tables })
    }
}

fn table_file(table: &str) -> String {
    format!("{table}.parquet")
}

/// The files of a run that is going on.
pub struct ResultFiles {
    folder: PathBuf,
    _lock: File,
    outputs: Outputs,
    scenarios: ScenariosCsv,
    /// With the names of their files: the contacts, if they are wanted, and those of the effects.
    tables: Vec<(String, TableFile)>,
}

impl ResultFiles {
    /// In scenario order. After a failure, `scenarios.csv` holds all results before it.
    pub fn write(&mut self, result: &ScenarioResult<'_>) -> Result<(), OutputError> {
        let said = result.effects;
        let written = self.scenarios.write(result, said.columns());
        written.map_err(|source| self.incomplete(SCENARIOS, source))?;
        let mut tables = self.tables.iter_mut();
        let contacts = if self.outputs.contacts { tables.next() } else { None };
        let contacts = contacts.into_iter().try_for_each(|(name, table)| {
            let words = result.pairs.as_flattened().iter().copied().map(u64::from);
            table.write(result.scenario, words).map_err(|error| (name.clone(), error))
        });
        let others = || {
            tables.zip(said.tables()).try_for_each(|((name, table), (_, rows))| {
                let words = rows.iter().copied();
                table.write(result.scenario, words).map_err(|error| (name.clone(), error))
            })
        };
        contacts.and_then(|()| others()).map_err(|(name, source)| self.give_up(&name, source))
    }

    /// Completes the tables: their files appear only now, as only now they can be read.
    pub fn finish_tables(&mut self) -> Result<(), OutputError> {
        while !self.tables.is_empty() {
            let (name, table) = self.tables.remove(0);
            let path = self.folder.join(&name);
            let finished = table.close().and_then(|()| fs::rename(partial(&path), path));
            finished.map_err(|source| self.give_up(&name, source))?;
        }
        Ok(())
    }

    /// The last file to appear: a directory with a summary is complete.
    pub fn write_summary(&mut self, summary: &Summary) -> Result<(), OutputError> {
        let path = self.folder.join(SUMMARY);
        let write = || {
            fs::write(partial(&path), summary.to_json() + "\n")?;
            fs::rename(partial(&path), &path)
        };
        write().map_err(|source| self.give_up(SUMMARY, source))
    }

    /// A part of a file that can only be read as a whole is of no use to anybody.
    fn give_up(&mut self, name: &str, source: io::Error) -> OutputError {
        let others = self.tables.drain(..).map(|(name, _)| name);
        for name in others.chain([name.to_owned()]) {
            // What made the file fail may make this fail: the first error is the one to tell.
            let _ = remove_if_there(&partial(&self.folder.join(name)));
        }
        self.incomplete(name, source)
    }

    fn incomplete(&self, name: &str, source: io::Error) -> OutputError {
        OutputError::Incomplete { path: self.folder.join(name), source }
    }
}

/// Where a file grows that means nothing until it is whole.
fn partial(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".partial");
    name.into()
}

fn is_empty(folder: &Path) -> io::Result<bool> {
    fs::read_dir(folder)?.next().transpose().map(|first| first.is_none())
}

fn holds_a_run(folder: &Path) -> bool {
    let start = || -> io::Result<Vec<u8>> {
        use io::Read;
        let mut start = Vec::new();
        let file = File::open(folder.join(SCENARIOS))?;
        file.take(scenarios_csv::HEADER.len() as u64).read_to_end(&mut start)?;
        Ok(start)
    };
    start().is_ok_and(|start| start == scenarios_csv::HEADER.as_bytes())
}

fn remove_if_there(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_has_one_run_at_a_time() {
        let place = tempfile::tempdir().unwrap();
        let refused = || OutputDir::prepare(place.path()).unwrap_err().to_string();
        let first = OutputDir::prepare(place.path()).unwrap();
        assert!(refused().contains("still going on"), "{}", refused());
        let files = first.start(Outputs::default()).unwrap();
        assert!(refused().contains("still going on"), "{}", refused());
        drop(files);
        OutputDir::prepare(place.path()).unwrap();
    }

    #[test]
    fn contacts_that_do_not_fit_are_an_error_and_leave_no_part() {
        let place = tempfile::tempdir().unwrap();
        let outputs = Outputs { contacts: true, ..Outputs::default() };
        let mut files = OutputDir::prepare(place.path()).unwrap().start(outputs).unwrap();
        files.tables[0].1 = TableFile::create(Path::new("/dev/full"), &CONTACTS).unwrap();
        let (pairs, nothing) = ([[1, 2]], Layout::default());
        let result = ScenarioResult {
            scenario: 0,
            pair_count: 1,
            pairs_fnv1a64: 0,
            compute_ns: 1,
            cost: None,
            worker: 0,
            pairs: &pairs,
            effects: nothing.read(&[]).unwrap(),
        };
        files.write(&result).unwrap();
        let refused = files.finish_tables().unwrap_err().to_string();
        assert!(refused.contains("contacts.parquet") && refused.contains("space"), "{refused}");
        let names: Vec<_> =
            fs::read_dir(place.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names.len(), 2, "{names:?}");
        assert!([SCENARIOS, SCENE].iter().all(|name| names.contains(&name.into())));
        assert_eq!(fs::read_to_string(place.path().join(SCENARIOS)).unwrap().lines().count(), 2);
    }
}
