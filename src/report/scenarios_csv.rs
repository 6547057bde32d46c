//! `scenarios.csv`: one row a scenario, in order.
//!
//! Only what the scene determines is in it, so that two runs of a scene can be compared byte for
//! byte, whatever the number of workers; times are in the summary.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use super::output::Outputs;
use crate::effects::layout::{ABSENT, Column, Kind};
use crate::scheduler::client_manager::ScenarioResult;

/// What every header begins with.
pub(super) const HEADER: &str = "scenario,colliding";

/// Each row goes to the file by itself, without a buffer: what was answered is kept, however the
/// run ends.
pub(super) struct ScenariosCsv {
    file: File,
    overlap_only: bool,
    row: String,
    /// Bytes of whole rows.
    whole: u64,
}

impl ScenariosCsv {
    pub(super) fn create(path: &Path, outputs: &Outputs) -> io::Result<Self> {
        let mut header = HEADER.to_owned();
        if !outputs.overlap_only {
            header += ",pairs,pairs_fnv1a64";
        }
        for column in outputs.layout.columns() {
            header += ",";
            header += column.name;
        }
        header += "\n";
        let mut file = File::create(path)?;
        file.write_all(header.as_bytes())?;
        let (overlap_only, whole) = (outputs.overlap_only, header.len() as u64);
        Ok(Self { file, overlap_only, row: String::new(), whole })
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
