//! `scenarios.csv`: one row a scenario, in order.
//!
//! Only what the scene determines is in it, so that two runs of a scene can be compared byte for
//! byte, whatever the number of workers; times are in the summary.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use crate::scheduler::client_manager::ScenarioResult;

pub(super) const HEADER: &str = "scenario,colliding,pairs,pairs_fnv1a64\n";

/// Each row goes to the file by itself, without a buffer: what was answered is kept, however the
/// run ends.
pub(super) struct ScenariosCsv {
    file: File,
    /// Bytes of whole rows.
    whole: u64,
}

impl ScenariosCsv {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let mut file = File::create(path)?;
        file.write_all(HEADER.as_bytes())?;
        Ok(Self { file, whole: HEADER.len() as u64 })
    }

    /// After a failure the file ends with the last whole row.
    pub(super) fn write(&mut self, result: &ScenarioResult<'_>) -> io::Result<()> {
        let row = format!(
            "{},{},{},{:016x}\n",
            result.scenario,
            u8::from(result.pair_count > 0),
            result.pair_count,
            result.pairs_fnv1a64
        );
        if let Err(error) = self.file.write_all(row.as_bytes()) {
            // Not even that may work; the first error is the one to tell.
            let _ = self.file.set_len(self.whole);
            return Err(error);
        }
        self.whole += row.len() as u64;
        Ok(())
    }
}
