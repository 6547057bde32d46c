//! The output directory of a run.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use super::Summary;
use super::identity::RunIdentity;
use super::journal::Journal;
use super::parquet::CONTACTS;
use super::scenarios_csv::{self, Earlier, ScenariosCsv};
use crate::effects::TABLES;
use crate::effects::layout::{Layout, Table};
use crate::scheduler::client_manager::ScenarioResult;

/// The scene as it was run.
pub const SCENE: &str = "scene.toml";
/// What the rows belong to.
const IDENTITY: &str = "run.json";
const SUMMARY: &str = "summary.json";
pub const SCENARIOS: &str = "scenarios.csv";
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
    #[error("{path}: there is no run to go on with: {reason}; begin one with --out", path = path.display())]
    NoRun { path: PathBuf, reason: String },
    #[error("{path}: this run cannot go on with that one: {reason}", path = path.display())]
    OtherRun { path: PathBuf, reason: String },
}

/// What a run writes, beside its summary and its scenarios.
#[derive(Clone, Debug)]
pub struct Outputs {
    /// The scene as a file.
    pub scene: String,
    pub identity: RunIdentity,
    pub overlap_only: bool,
    /// Of what effects say.
    pub layout: Layout,
}

impl Outputs {
    fn tables(&self) -> impl Iterator<Item = &'static Table> {
        self.identity.contacts.then_some(&CONTACTS).into_iter().chain(self.layout.tables())
    }
}

/// A directory that results can be written to: a new one, an empty one, or one that holds an
/// earlier run (its `scenarios.csv` starts with our header). Only files of our names are ever
/// replaced, and only when the first results are about to come; those of a run that is gone on with
/// are kept. Nobody else has it meanwhile.
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
        let lock = lock(path)?;
        if !is_empty(path).map_err(unusable)? && !holds_a_run(path) {
            return Err(OutputError::NotOurs { path: path.to_owned() });
        }
        // Vanishes at once: only its creation matters.
        tempfile::tempfile_in(path).map_err(unusable)?;
        Ok(Self { path: path.to_owned(), lock })
    }

    /// A directory with the rows of a run that was not finished.
    pub fn of_unfinished(path: &Path) -> Result<Self, OutputError> {
        let no_run =
            |reason: &str| OutputError::NoRun { path: path.to_owned(), reason: reason.into() };
        if !path.is_dir() {
            return Err(no_run("it is not a directory"));
        }
        let lock = lock(path)?;
        match [SCENE, IDENTITY, SCENARIOS].iter().find(|name| !path.join(name).is_file()) {
            Some(name) => Err(no_run(&format!("it has no {name}"))),
            None => Ok(Self { path: path.to_owned(), lock }),
        }
    }

    /// As the run that wrote here left it.
    pub fn summary(&self) -> Result<String, OutputError> {
        let path = self.path.join(SUMMARY);
        fs::read_to_string(&path).map_err(|source| OutputError::Io { path, source })
    }

    /// Whether nothing is missing in it.
    pub fn is_complete(&self) -> bool {
        let summary = self.summary().unwrap_or_default();
        let summary = serde_json::from_str::<serde_json::Value>(&summary).unwrap_or_default();
        let none_set_aside = summary["set_aside"].as_array().is_some_and(Vec::is_empty);
        summary["interrupted"] == false && none_set_aside
    }

    /// Of the run that began here.
    pub fn identity(&self) -> Result<RunIdentity, OutputError> {
        let path = self.path.join(IDENTITY);
        let text = fs::read_to_string(&path);
        let text = text.map_err(|source| OutputError::Io { path: path.clone(), source })?;
        RunIdentity::parse(&text).map_err(|reason| OutputError::NoRun { path, reason })
    }

    /// Keeps the rows that are there.
    pub fn go_on(self, outputs: Outputs) -> Result<(ResultFiles, Earlier), OutputError> {
        if let Some(reason) = outputs.identity.difference(&self.identity()?) {
            return Err(OutputError::OtherRun { path: self.path, reason });
        }
        let path = self.path.join(SCENARIOS);
        let reopened = ScenariosCsv::reopen(&path, &outputs, outputs.identity.scenarios);
        let (scenarios, earlier) =
            reopened.map_err(|source| OutputError::Incomplete { path, source })?;
        let reopen = |table: &'static Table| {
            let path = self.path.join(rows_file(table.name));
            Journal::reopen(&path, table, |scenario| earlier.has_answered(scenario))
                .map_err(|source| OutputError::Incomplete { path, source })
        };
        let tables = outputs.tables().map(reopen).collect::<Result<_, _>>()?;
        let (folder, _lock) = (self.path, self.lock);
        Ok((ResultFiles { folder, _lock, outputs, scenarios, tables }, earlier))
    }

    /// Replaces the files of an earlier run by new ones.
    pub fn start(self, outputs: Outputs) -> Result<ResultFiles, OutputError> {
        let path = self.path.clone();
        self.replace_files(outputs).map_err(|source| OutputError::Io { path, source })
    }

    fn replace_files(self, outputs: Outputs) -> io::Result<ResultFiles> {
        let tables = || TABLES.iter().chain([&CONTACTS.name]);
        let tables =
            tables().map(|name| table_file(name)).chain(tables().map(|name| rows_file(name)));
        let others = [SUMMARY].iter().chain(&DEFORMED).map(|&name| name.to_owned());
        for path in others.chain(tables) {
            let path = self.path.join(path);
            remove_if_there(&path)?;
            remove_if_there(&partial(&path))?;
        }
        // Rows without what they belong to would be of no use: they begin last.
        fs::write(self.path.join(SCENE), &outputs.scene)?;
        fs::write(self.path.join(IDENTITY), outputs.identity.to_json())?;
        let create =
            |table: &'static Table| Journal::create(&self.path.join(rows_file(table.name)), table);
        let tables = outputs.tables().map(create).collect::<io::Result<_>>()?;
        let scenarios = ScenariosCsv::create(&self.path.join(SCENARIOS), &outputs)?;
        Ok(ResultFiles { folder: self.path, _lock: self.lock, outputs, scenarios, tables })
    }
}

fn lock(path: &Path) -> Result<File, OutputError> {
    let lock = File::open(path);
    let lock = lock.map_err(|source| OutputError::Io { path: path.to_owned(), source })?;
    match lock.try_lock() {
        Err(TryLockError::WouldBlock) => Err(OutputError::InUse { path: path.to_owned() }),
        // Some file systems cannot lock a directory.
        Err(TryLockError::Error(error)) => {
            let path = path.display();
            tracing::warn!("{path}: no second run is kept from writing here: {error}");
            Ok(lock)
        }
        Ok(()) => Ok(lock),
    }
}

fn table_file(table: &str) -> String {
    format!("{table}.parquet")
}

/// Where the rows of a table are until all have come.
fn rows_file(table: &str) -> String {
    format!("{table}.rows")
}

/// The files of a run that is going on.
pub struct ResultFiles {
    folder: PathBuf,
    _lock: File,
    outputs: Outputs,
    scenarios: ScenariosCsv,
    /// The contacts, if they are wanted, and those of the effects.
    tables: Vec<Journal>,
}

impl ResultFiles {
    /// After a failure all results before it are kept. A scenario is answered when its row is in
    /// `scenarios.csv`: that comes last.
    pub fn write(&mut self, result: &ScenarioResult<'_>) -> Result<(), OutputError> {
        let said = result.effects;
        let mut tables = self.tables.iter_mut();
        let contacts = if self.outputs.identity.contacts { tables.next() } else { None };
        let contacts = contacts.into_iter().try_for_each(|table| {
            let words = result.pairs.as_flattened().iter().copied().map(u64::from);
            table.write(result.scenario, words).map_err(|error| (table.table(), error))
        });
        let others = || {
            tables.zip(said.tables()).try_for_each(|(table, (_, rows))| {
                let words = rows.iter().copied();
                table.write(result.scenario, words).map_err(|error| (table.table(), error))
            })
        };
        let written = contacts.and_then(|()| others());
        written.map_err(|(table, source)| self.incomplete(&rows_file(table.name), source))?;
        let written = self.scenarios.write(result, said.columns());
        written.map_err(|source| {
            self.tables.iter_mut().for_each(|table| table.forget(result.scenario));
            self.incomplete(SCENARIOS, source)
        })
    }

    /// Makes the tables of what has come.
    pub fn finish_tables(&mut self) -> Result<(), OutputError> {
        let ordered = self.scenarios.put_in_order();
        ordered.map_err(|source| self.incomplete(SCENARIOS, source))?;
        let mut tables = std::mem::take(&mut self.tables).into_iter();
        tables.try_for_each(|mut table| {
            let name = table_file(table.table().name);
            let path = self.folder.join(&name);
            let finished =
                table.tabulate(&partial(&path)).and_then(|()| fs::rename(partial(&path), &path));
            finished.map_err(|source| self.give_up(&name, source))
        })
    }

    /// The last file to appear. With all scenarios answered, what only a run that goes on would need
    /// is removed.
    pub fn write_summary(&mut self, summary: &Summary) -> Result<(), OutputError> {
        let path = self.folder.join(SUMMARY);
        let write = || {
            fs::write(partial(&path), summary.to_json() + "\n")?;
            fs::rename(partial(&path), &path)?;
            let is_complete = !summary.interrupted && summary.set_aside.is_empty();
            let rows = self.outputs.tables().filter(|_| is_complete);
            rows.map(|table| self.folder.join(rows_file(table.name)))
                .try_for_each(|path| remove_if_there(&path))
        };
        write().map_err(|source| self.give_up(SUMMARY, source))
    }

    /// A part of a file that can only be read as a whole is of no use to anybody.
    fn give_up(&self, name: &str, source: io::Error) -> OutputError {
        // What made the file fail may make this fail: the first error is the one to tell.
        let _ = remove_if_there(&partial(&self.folder.join(name)));
        self.incomplete(name, source)
    }

    fn incomplete(&self, name: &str, source: io::Error) -> OutputError {
        OutputError::Incomplete { path: self.folder.join(name), source }
    }
}

/// Where a file grows that means nothing until it is whole.
pub(super) fn partial(path: &Path) -> PathBuf {
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
    use crate::geometry::Pose;
    use crate::mesh::TriangleMesh;

    fn outputs() -> Outputs {
        let mesh = TriangleMesh::new(vec![[0.0; 3]], vec![[0, 0, 0]]).unwrap();
        let identity = RunIdentity::new(&mesh, &mesh, &[Pose::IDENTITY; 3], true);
        let (scene, layout) = (String::new(), Layout::default());
        Outputs { scene, identity, overlap_only: false, layout }
    }

    fn write(
        files: &mut ResultFiles,
        scenario: u32,
        pairs: &[[u32; 2]],
    ) -> Result<(), OutputError> {
        let nothing = Layout::default();
        files.write(&ScenarioResult {
            scenario,
            pair_count: pairs.len() as u32,
            pairs_fnv1a64: 0,
            compute_ns: 1,
            cost: None,
            worker: 0,
            pairs,
            effects: nothing.read(&[]).unwrap(),
        })
    }

    #[test]
    fn a_directory_has_one_run_at_a_time() {
        let place = tempfile::tempdir().unwrap();
        let refused = || OutputDir::prepare(place.path()).unwrap_err().to_string();
        let first = OutputDir::prepare(place.path()).unwrap();
        assert!(refused().contains("still going on"), "{}", refused());
        let files = first.start(outputs()).unwrap();
        assert!(refused().contains("still going on"), "{}", refused());
        let refused = OutputDir::of_unfinished(place.path()).unwrap_err().to_string();
        assert!(refused.contains("still going on"), "{refused}");
        drop(files);
        OutputDir::prepare(place.path()).unwrap();
    }

    #[test]
    fn contacts_that_do_not_fit_are_an_error_and_all_that_came_is_kept() {
        let place = tempfile::tempdir().unwrap();
        let mut files = OutputDir::prepare(place.path()).unwrap().start(outputs()).unwrap();
        write(&mut files, 0, &[[1, 2]]).unwrap();
        let kept = files.tables.remove(0);
        files.tables.push(Journal::create(Path::new("/dev/full"), &CONTACTS).unwrap());
        let refused = write(&mut files, 1, &[[3, 4]]).unwrap_err().to_string();
        assert!(refused.contains("contacts.rows") && refused.contains("space"), "{refused}");
        assert_eq!(fs::read_to_string(place.path().join(SCENARIOS)).unwrap().lines().count(), 2);
        drop((files, kept));
        let again = OutputDir::of_unfinished(place.path()).unwrap();
        let (mut files, earlier) = again.go_on(outputs()).unwrap();
        assert_eq!((earlier.scenarios, earlier.colliding, earlier.pairs), (1, 1, 1));
        fs::create_dir(place.path().join("contacts.parquet.partial")).unwrap();
        let refused = files.finish_tables().unwrap_err().to_string();
        assert!(refused.contains("contacts.parquet"), "{refused}");
        assert!(place.path().join("contacts.rows").exists(), "it can be tried again");
    }

    #[test]
    fn rows_of_a_run_that_goes_on_come_out_in_order() {
        let place = tempfile::tempdir().unwrap();
        let mut files = OutputDir::prepare(place.path()).unwrap().start(outputs()).unwrap();
        write(&mut files, 0, &[[1, 2]]).unwrap();
        write(&mut files, 2, &[]).unwrap();
        drop(files);
        let csv = place.path().join(SCENARIOS);
        let text = fs::read_to_string(&csv).unwrap();
        fs::write(&csv, text.clone() + "1,1,").unwrap();
        let again = OutputDir::of_unfinished(place.path()).unwrap();
        let (mut files, earlier) = again.go_on(outputs()).unwrap();
        assert_eq!((earlier.scenarios, earlier.colliding, earlier.pairs), (2, 1, 1));
        assert_eq!(earlier.missing(), [1], "0 and 2 are answered");
        write(&mut files, 1, &[[3, 4], [5, 6]]).unwrap();
        files.finish_tables().unwrap();
        drop(files);
        let rows = fs::read_to_string(&csv).unwrap();
        let numbers: Vec<_> = rows.lines().map(|line| line.split(',').next().unwrap()).collect();
        assert_eq!(numbers, ["scenario", "0", "1", "2"]);
        for bad in ["0,1,1,0\n", "9,0,0,0\n", "1,1,0,0\n", "1,0\n", "x\n"] {
            fs::write(&csv, text.clone() + bad).unwrap();
            let again = OutputDir::of_unfinished(place.path()).unwrap();
            let refused = again.go_on(outputs()).map(drop).unwrap_err().to_string();
            assert!(refused.contains("line 4"), "{bad}: {refused}");
        }
    }
}
