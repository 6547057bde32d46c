//! `scenarios.csv`, read back.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::SourceError;
use crate::report::scenarios_csv::HEADER;

/// What its rows say, column by column.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Scenarios {
    pub rows: u64,
    pub columns: Vec<Column>,
}

#[derive(Debug, Default, PartialEq)]
pub(super) struct Column {
    pub name: String,
    /// Sorted.
    pub numbers: Vec<f64>,
    /// Words and how often each is there.
    pub words: BTreeMap<String, u64>,
}

/// Columns that number and identify, and measure nothing.
const LABELS: [&str; 2] = ["scenario", "pairs_fnv1a64"];

impl Scenarios {
    pub fn read(path: &Path) -> Result<Self, SourceError> {
        let text = fs::read_to_string(path)
            .map_err(|source| SourceError::Io { path: path.to_owned(), source })?;
        let refused = |line: usize, reason: String| {
            Err(SourceError::Row { path: path.to_owned(), line, reason })
        };
        let mut lines = text.lines();
        let header = lines.next().unwrap_or_default();
        if !header.starts_with(HEADER) {
            return refused(1, format!("does not begin with `{HEADER}`"));
        }
        let names = header.split(',').map(str::to_owned);
        let mut columns: Vec<Column> =
            names.map(|name| Column { name, ..Column::default() }).collect();
        let mut rows = 0;
        for line in lines {
            rows += 1;
            let cells: Vec<&str> = line.split(',').collect();
            if cells.len() != columns.len() {
                let reason = format!("has {} cells, and the header {}", cells.len(), columns.len());
                return refused(rows + 1, reason);
            }
            columns.iter_mut().zip(cells).for_each(|(column, cell)| column.add(cell));
        }
        columns.retain(|column| !LABELS.contains(&column.name.as_str()));
        columns.iter_mut().for_each(|column| column.numbers.sort_by(f64::total_cmp));
        Ok(Self { rows: rows as u64, columns })
    }

    /// The numbers of a column; none where there is no such column.
    pub fn numbers(&self, name: &str) -> &[f64] {
        let column = self.columns.iter().find(|column| column.name == name);
        column.map_or(&[], |column| &column.numbers)
    }
}

impl Column {
    fn add(&mut self, cell: &str) {
        match cell.parse::<f64>() {
            _ if cell.is_empty() => {}
            Ok(number) if number.is_finite() => self.numbers.push(number),
            _ => *self.words.entry(cell.to_owned()).or_default() += 1,
        }
    }
}
