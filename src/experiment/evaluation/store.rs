//! `points.jsonl`: every sample on disk as soon as there is one, and read again to go on after it.
//!
//! A line is a JSON object of one key: `setup`, the first one, says what is measured, on what; then
//! come `models` as they are loaded, and each `sample`. A line without its line feed is what a killed
//! run was writing: it is dropped.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::plan::Evaluation;
use super::sample::{Facts, Sample};
use super::setup;

const FILE: &str = "points.jsonl";

/// Why samples cannot be kept, or gone on after.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("{path}: {source}", path = path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("{path}: holds files, but no experiment: choose a new or an empty directory", path = path.display())]
    NotOurs { path: PathBuf },
    #[error(
        "{path}: holds the points of an experiment: go on after them with --resume, or choose \
         another directory",
        path = path.display()
    )]
    Finished { path: PathBuf },
    #[error("{path}: an experiment that is still going on writes here", path = path.display())]
    InUse { path: PathBuf },
    #[error(
        "{path}: is of another experiment: {differences}; give what it was made with, or choose \
         another directory",
        path = path.display()
    )]
    Other { path: PathBuf, differences: String },
    #[error("{path}:{line}: {reason}: choose another directory", path = path.display())]
    Line { path: PathBuf, line: usize, reason: String },
    #[error(
        "{path}: its points are of other models than are now loaded as {models} (there \
         {there}; here {here}): give those, or choose another directory",
        path = path.display()
    )]
    OtherModels { path: PathBuf, models: String, there: String, here: String },
}

impl StoreError {
    /// Whether the command makes no sense, and not the disk.
    pub fn is_refusal(&self) -> bool {
        !matches!(self, Self::Io { .. })
    }
}

#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
enum Record<'a> {
    Setup(&'a Value),
    Models(&'a Facts),
    Sample(&'a Sample),
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum OwnedRecord {
    Setup(Value),
    Models(Facts),
    Sample(Sample),
}

/// What is on disk.
#[derive(Debug, Default, PartialEq)]
pub struct Kept {
    pub models: Vec<Facts>,
    /// Each of another step of the experiment.
    pub samples: Vec<Sample>,
}

/// The file, which nobody else writes meanwhile.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    file: File,
    kept: Kept,
}

impl Store {
    /// In a directory that is new or empty; with `resume`, also in one that holds samples of this
    /// very experiment, and only what is to be measured still is.
    pub fn open(
        folder: &Path,
        evaluation: &Evaluation,
        setup: &Value,
        resume: bool,
    ) -> Result<Self, StoreError> {
        let path = folder.join(FILE);
        let failed = |source| StoreError::Io { path: path.clone(), source };
        fs::create_dir_all(folder)
            .map_err(|source| StoreError::Io { path: folder.to_owned(), source })?;
        let is_there = path.try_exists().map_err(failed)?;
        if !is_there && fs::read_dir(folder).map_err(failed)?.next().is_some() {
            return Err(StoreError::NotOurs { path: folder.to_owned() });
        }
        let mut options = OpenOptions::new();
        let file = options.read(true).append(true).create(true).open(&path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StoreError::InUse { path }),
            Err(TryLockError::Error(source)) => return Err(StoreError::Io { path, source }),
        }
        let mut store = Self { path, file, kept: Kept::default() };
        let text = store.whole_lines()?;
        if text.is_empty() {
            store.append(&Record::Setup(setup))?;
            File::open(folder).and_then(|folder| folder.sync_all()).map_err(|e| store.failed(e))?;
        } else if resume {
            store.read(&text, evaluation, setup)?;
        } else {
            return Err(StoreError::Finished { path: folder.to_owned() });
        }
        Ok(store)
    }

    pub fn kept(&self) -> &Kept {
        &self.kept
    }

    /// To be said before samples of these models are: those that are kept are of the same.
    pub fn add_models(&mut self, facts: Facts) -> Result<(), StoreError> {
        match self.kept.models.iter().find(|known| known.models == facts.models) {
            None => {
                self.append(&Record::Models(&facts))?;
                self.kept.models.push(facts);
                Ok(())
            }
            Some(known) if *known == facts => Ok(()),
            Some(known) => {
                let json = |facts| serde_json::to_string(facts).expect("plain values");
                let (path, there, here) = (self.path.clone(), json(known), json(&facts));
                Err(StoreError::OtherModels { path, models: facts.models, there, here })
            }
        }
    }

    /// On disk when this returns.
    pub fn add_sample(&mut self, sample: Sample) -> Result<(), StoreError> {
        self.append(&Record::Sample(&sample))?;
        self.kept.samples.push(sample);
        Ok(())
    }

    fn append(&mut self, record: &Record<'_>) -> Result<(), StoreError> {
        let line = serde_json::to_string(record).expect("string keys and plain values") + "\n";
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        written.map_err(|e| self.failed(e))
    }

    /// Cuts off what a killed run was writing.
    fn whole_lines(&mut self) -> Result<String, StoreError> {
        let mut bytes = Vec::new();
        self.file.read_to_end(&mut bytes).map_err(|e| self.failed(e))?;
        let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        if whole < bytes.len() {
            bytes.truncate(whole);
            self.file.set_len(whole as u64).map_err(|e| self.failed(e))?;
        }
        String::from_utf8(bytes).map_err(|_| self.bad_line(1, "is no text of ours"))
    }

    fn read(
        &mut self,
        text: &str,
        evaluation: &Evaluation,
        setup: &Value,
    ) -> Result<(), StoreError> {
        let mut steps = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let wrong = |reason: String| self.bad_line(index + 1, &reason);
            let record = serde_json::from_str(line).map_err(|error| {
                wrong(format!("is not a line that this bumper writes ({error})"))
            })?;
            match (index, record) {
                (0, OwnedRecord::Setup(there)) => {
                    let differences = setup::differences(&there, setup);
                    if !differences.is_empty() {
                        let (path, differences) = (self.path.clone(), differences.join("; "));
                        return Err(StoreError::Other { path, differences });
                    }
                }
                (0, _) | (_, OwnedRecord::Setup(_)) => {
                    return Err(wrong("the setup is the first line, and only that".to_owned()));
                }
                (_, OwnedRecord::Models(facts)) => self.kept.models.push(facts),
                (_, OwnedRecord::Sample(sample)) => match sample.step(evaluation) {
                    Some(step) if !steps.contains(&step) => {
                        steps.push(step);
                        self.kept.samples.push(sample);
                    }
                    Some(_) => return Err(wrong("is a sample that is there already".to_owned())),
                    None => return Err(wrong("is a sample of no point".to_owned())),
                },
            }
        }
        Ok(())
    }

    fn failed(&self, source: io::Error) -> StoreError {
        StoreError::Io { path: self.path.clone(), source }
    }

    fn bad_line(&self, line: usize, reason: &str) -> StoreError {
        StoreError::Line { path: self.path.clone(), line, reason: reason.to_owned() }
    }
}

#[cfg(test)]
mod tests;
