//! `scenarios.csv`: one row a scenario, in order.
//!
//! Only what the scene determines is in it, so that two runs of a scene can be compared byte for
//! byte, whatever the number of workers; times are in the summary.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::output::{Outputs, partial};
use crate::effects::layout::{ABSENT, Column, Kind};
use crate::scheduler::client_manager::ScenarioResult;

/// What every header begins with.
pub(super) const HEADER: &str = "scenario,colliding";

/// What an earlier run said, as far as one that goes on with it needs to know.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Earlier {
    /// Of each scenario, whether it has a row.
    answered: Vec<bool>,
    pub scenarios: u32,
    pub colliding: u32,
    pub pairs: u64,
}

impl Earlier {
    pub(super) fn has_answered(&self, scenario: u32) -> bool {
        self.answered.get(scenario as usize) == Some(&true)
    }

    /// The scenarios that are left to be answered.
    pub fn missing(&self) -> Vec<u32> {
        (0..self.answered.len() as u32).filter(|&scenario| !self.has_answered(scenario)).collect()
    }
}

/// Each row goes to the file by itself, without a buffer: what was answered is kept, however the
/// run ends.
pub(super) struct ScenariosCsv {
    path: PathBuf,
    file: File,
    overlap_only: bool,
    row: String,
    /// Where the row of each scenario begins, in the order of the file; only of a run that goes on,
    /// whose rows may have to be put in order.
    rows: Option<Vec<(u32, u64)>>,
    /// Bytes of whole rows.
    whole: u64,
}

/// With its line end.
fn header(outputs: &Outputs) -> String {
    let mut header = HEADER.to_owned();
    if !outputs.overlap_only {
        header += ",pairs,pairs_fnv1a64";
    }
    for column in outputs.layout.columns() {
        header += ",";
        header += column.name;
    }
    header + "\n"
}

impl ScenariosCsv {
    pub(super) fn create(path: &Path, outputs: &Outputs) -> io::Result<Self> {
        let header = header(outputs);
        let mut file = File::create(path)?;
        file.write_all(header.as_bytes())?;
        let (path, overlap_only) = (path.to_owned(), outputs.overlap_only);
        let whole = header.len() as u64;
        Ok(Self { path, file, overlap_only, row: String::new(), rows: None, whole })
    }

    /// What an earlier run left, without a last row that it had not written to its end.
    pub(super) fn reopen(
        path: &Path,
        outputs: &Outputs,
        count: usize,
    ) -> io::Result<(Self, Earlier)> {
        let mut file = File::options().read(true).write(true).open(path)?;
        let header = header(outputs);
        let mut lines = BufReader::new(&file);
        let mut line = Vec::new();
        lines.by_ref().take(1 << 20).read_until(b'\n', &mut line)?;
        if line != header.as_bytes() {
            return Err(bad_row(1, "its header is not that of this run"));
        }
        let mut earlier = Earlier { answered: vec![false; count], ..Earlier::default() };
        let (mut rows, mut whole) = (Vec::new(), line.len() as u64);
        let fields = header.split(',').count();
        for number in 2.. {
            line.clear();
            lines.by_ref().take(1 << 20).read_until(b'\n', &mut line)?;
            if line.last() != Some(&b'\n') {
                break;
            }
            let row = str::from_utf8(&line).ok();
            let row = row.and_then(|row| Row::parse(row, fields, outputs.overlap_only));
            let row = row.ok_or_else(|| bad_row(number, "it is not a row of this run"))?;
            let answered = earlier.answered.get_mut(row.scenario as usize);
            if answered.is_none_or(|answered| std::mem::replace(answered, true)) {
                return Err(bad_row(number, "there is no such scenario, or it was there before"));
            }
            earlier.scenarios += 1;
            earlier.colliding += u32::from(row.colliding);
            earlier.pairs += row.pair_count();
            rows.push((row.scenario, whole));
            whole += line.len() as u64;
        }
        file.set_len(whole)?;
        file.seek(SeekFrom::Start(whole))?;
        let (path, overlap_only) = (path.to_owned(), outputs.overlap_only);
        let rows = Some(rows);
        Ok((Self { path, file, overlap_only, row: String::new(), rows, whole }, earlier))
    }

    /// Puts the rows in the order of scenarios, where a run went on before the end of another.
    pub(super) fn put_in_order(&mut self) -> io::Result<()> {
        let Some(rows) = self.rows.take().filter(|rows| !rows.is_sorted()) else { return Ok(()) };
        let ends = rows.iter().skip(1).map(|&(_, at)| at).chain([self.whole]);
        let mut spans: Vec<_> = rows.iter().zip(ends).map(|(&(n, at), end)| (n, at, end)).collect();
        let first = rows.first().map_or(self.whole, |&(_, at)| at);
        spans.push((0, 0, first));
        spans.sort_by_key(|&(scenario, at, _)| (at > 0, scenario));
        let mut reader = BufReader::new(File::open(&self.path)?);
        let mut sorted = BufWriter::new(File::create(partial(&self.path))?);
        let mut position = 0;
        for (_, at, end) in spans {
            reader.seek_relative(at as i64 - position as i64)?;
            io::copy(&mut reader.by_ref().take(end - at), &mut sorted)?;
            position = end;
        }
        sorted.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
        fs::rename(partial(&self.path), &self.path)
    }

    /// After a failure the file ends with the last whole row.
    pub(super) fn write(
        &mut self,
        result: &ScenarioResult<'_>,
        columns: impl Iterator<Item = (&'static Column, u64)>,
    ) -> io::Result<()> {
        self.row.clear();
        self.fill_row(result, columns).expect("writing to a string does not fail");
        if let Err(error) = self.file.write_all(self.row.as_bytes()) {
            // Not even that may work; the first error is the one to tell.
            let _ = self.file.set_len(self.whole);
            return Err(error);
        }
        if let Some(rows) = &mut self.rows {
            rows.push((result.scenario, self.whole));
        }
        self.whole += self.row.len() as u64;
        Ok(())
    }

    fn fill_row(
        &mut self,
        result: &ScenarioResult<'_>,
        columns: impl Iterator<Item = (&'static Column, u64)>,
    ) -> std::fmt::Result {
        let row = &mut self.row;
        write!(row, "{},{}", result.scenario, u8::from(result.pair_count > 0))?;
        if !self.overlap_only {
            write!(row, ",{},{:016x}", result.pair_count, result.pairs_fnv1a64)?;
        }
        for (column, word) in columns {
            row.push(',');
            match column.kind {
                _ if word == ABSENT => {}
                Kind::Flag | Kind::Count => write!(row, "{word}")?,
                Kind::Number => write!(row, "{:?}", f64::from_bits(word))?,
                Kind::Choice(choices) => row.push_str(choices[word as usize]),
            }
        }
        row.push('\n');
        Ok(())
    }
}

/// What stands before the effects in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub scenario: u32,
    pub colliding: bool,
    /// How many pairs, and their hash; absent where only overlap was asked for.
    pub pairs: Option<(u32, u64)>,
}

impl Row {
    /// `None` for what is no row of so many fields.
    pub(super) fn parse(line: &str, fields: usize, overlap_only: bool) -> Option<Self> {
        if line.split(',').count() != fields {
            return None;
        }
        let mut values = line.trim_end().split(',');
        let scenario = values.next()?.parse().ok()?;
        let colliding = match values.next()? {
            "0" => false,
            "1" => true,
            _ => return None,
        };
        let pairs = match overlap_only {
            true => None,
            false => {
                Some((values.next()?.parse().ok()?, u64::from_str_radix(values.next()?, 16).ok()?))
            }
        };
        let row = Self { scenario, colliding, pairs };
        (pairs.is_none_or(|(pairs, _)| colliding == (pairs > 0))).then_some(row)
    }

    /// Where only overlap was asked for, one if there is any.
    fn pair_count(&self) -> u64 {
        self.pairs.map_or(u64::from(self.colliding), |(pairs, _)| pairs.into())
    }
}

fn bad_row(line: usize, what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("line {line}: {what}"))
}
