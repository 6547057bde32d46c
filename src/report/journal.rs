//! Rows of a table as they come. A Parquet file can be read only when it is whole; what a killed run
//! had found out must not go with it. So rows are kept here first, in blocks of a scenario each: its
//! number and that of its rows, two u32, then the rows, a u64 a word; all little-endian.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::parquet::TableFile;
use crate::effects::layout::{ABSENT, Column, Table};

const HEAD: u64 = 8;

/// The rows of a scenario in the file.
#[derive(Clone, Copy, Debug)]
struct Block {
    scenario: u32,
    rows: u32,
    at: u64,
}

pub(super) struct Journal {
    file: File,
    table: &'static Table,
    blocks: Vec<Block>,
    /// Bytes of whole blocks.
    whole: u64,
    block: Vec<u8>,
}

impl Journal {
    pub(super) fn create(path: &Path, table: &'static Table) -> io::Result<Self> {
        let file = File::options().read(true).write(true).create(true).truncate(true).open(path)?;
        Ok(Self { file, table, blocks: Vec::new(), whole: 0, block: Vec::new() })
    }

    /// What an earlier run left, of the scenarios that are `kept`; what it had not written to its
    /// end is cut off.
    pub(super) fn reopen(
        path: &Path,
        table: &'static Table,
        kept: impl Fn(u32) -> bool,
    ) -> io::Result<Self> {
        let file = File::options().read(true).write(true).open(path)?;
        let length = file.metadata()?.len();
        let mut journal = Self { file, table, blocks: Vec::new(), whole: 0, block: Vec::new() };
        let mut reader = BufReader::new(&journal.file);
        let mut head = [0; HEAD as usize];
        while journal.whole + HEAD <= length {
            reader.read_exact(&mut head)?;
            let [scenario, rows] = bytemuck::cast::<_, [u32; 2]>(head).map(u32::from_le);
            let (at, bytes) = (journal.whole + HEAD, u64::from(rows) * width(table));
            if length - at < bytes {
                break;
            }
            reader.seek_relative(bytes as i64)?;
            journal.whole = at + bytes;
            if kept(scenario) {
                journal.blocks.push(Block { scenario, rows, at });
            }
        }
        journal.file.set_len(journal.whole)?;
        journal.file.seek(SeekFrom::Start(journal.whole))?;
        Ok(journal)
    }

    pub(super) fn table(&self) -> &'static Table {
        self.table
    }

    /// The rows of one scenario, word after word. After a failure the file ends with the last whole
    /// block.
    pub(super) fn write(
        &mut self,
        scenario: u32,
        words: impl IntoIterator<Item = u64>,
    ) -> io::Result<()> {
        self.block.clear();
        self.block.extend([0; HEAD as usize]);
        self.block.extend(words.into_iter().flat_map(u64::to_le_bytes));
        let bytes = self.block.len() as u64 - HEAD;
        if bytes == 0 {
            return Ok(());
        }
        let rows = u32::try_from(bytes / width(self.table)).map_err(io::Error::other)?;
        self.block[..4].copy_from_slice(&scenario.to_le_bytes());
        self.block[4..8].copy_from_slice(&rows.to_le_bytes());
        if let Err(error) = self.file.write_all(&self.block) {
            // Not even that may work; the first error is the one to tell.
            let _ = self.file.set_len(self.whole);
            return Err(error);
        }
        self.blocks.push(Block { scenario, rows, at: self.whole + HEAD });
        self.whole += self.block.len() as u64;
        Ok(())
    }

    /// The scenario whose rows came last has no answer after all.
    pub(super) fn forget(&mut self, scenario: u32) {
        self.blocks.pop_if(|block| block.scenario == scenario);
    }

    /// Writes the table as a Parquet file, in the order of scenarios.
    pub(super) fn tabulate(&mut self, path: &Path) -> io::Result<()> {
        let mut table = TableFile::create(path, self.table)?;
        self.blocks.sort_by_key(|block| block.scenario);
        let mut reader = BufReader::new(&self.file);
        let mut position = reader.seek(SeekFrom::Start(0))?;
        let mut words = Vec::new();
        for block in &self.blocks {
            reader.seek_relative(block.at as i64 - position as i64)?;
            words.resize((u64::from(block.rows) * width(self.table) / 8) as usize, 0_u64);
            reader.read_exact(bytemuck::cast_slice_mut(&mut words))?;
            position = block.at + 8 * words.len() as u64;
            let columns = self.table.columns.iter().cycle();
            let words = words.iter().copied().map(u64::from_le);
            let fits = |(word, column): (u64, &Column)| word != ABSENT && column.allows(word);
            if !words.clone().zip(columns).all(fits) {
                let reason =
                    format!("the rows of scenario {} are not of this table", block.scenario);
                return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
            }
            table.write(block.scenario, words)?;
        }
        table.close()
    }
}

/// Bytes of a row.
fn width(table: &Table) -> u64 {
    8 * table.columns.len() as u64
}

#[cfg(test)]
mod tests {
    use super::super::parquet::CONTACTS;
    use super::*;

    #[test]
    fn what_was_written_before_a_kill_is_found_again_and_what_was_torn_is_not() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("contacts.rows");
        let mut journal = Journal::create(&path, &CONTACTS).unwrap();
        for (scenario, rows) in
            [(3, vec![1, 2, 3, 4]), (5, vec![]), (6, vec![7, 8]), (9, vec![9, 9])]
        {
            journal.write(scenario, rows).unwrap();
        }
        let whole = journal.whole;
        drop(journal);
        for torn in 0..24 {
            File::options().write(true).open(&path).unwrap().set_len(whole - torn).unwrap();
            let mut again = Journal::reopen(&path, &CONTACTS, |scenario| scenario != 3).unwrap();
            let found: Vec<_> = again.blocks.iter().map(|b| (b.scenario, b.rows)).collect();
            assert_eq!(found, [(6, 1), (9, 1)][..if torn == 0 { 2 } else { 1 }], "{torn}");
            again.write(9, [9, 9]).unwrap();
        }
    }

    #[test]
    fn rows_that_no_column_allows_are_an_error() {
        let place = tempfile::tempdir().unwrap();
        let mut journal = Journal::create(&place.path().join("contacts.rows"), &CONTACTS).unwrap();
        journal.write(0, [1, 1 << 40]).unwrap();
        let refused = journal.tabulate(&place.path().join("contacts.parquet")).unwrap_err();
        assert!(refused.to_string().contains("scenario 0"), "{refused}");
    }
}
