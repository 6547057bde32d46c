//! Tables as Parquet files: a column `scenario`, then those of the table; rows in the order of
//! scenarios.

use std::fmt::Write as _;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int32Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::parser::parse_message_type;

use crate::effects::layout::{Column, Kind, Table};

/// Of `contacts.parquet`: one row for each pair of triangles that touch.
pub const CONTACTS: Table = Table {
    name: "contacts",
    columns: &[Column::count("fixed_triangle"), Column::count("moving_triangle")],
};

const SCENARIO: Column = Column::count("scenario");

/// Rows of a row group.
const ROW_GROUP: usize = 1 << 20;

/// Rows that wait for their row group to be full, and the groups already in the file. The file can
/// be read only after [`TableFile::close`].
pub(super) struct TableFile {
    writer: SerializedFileWriter<File>,
    columns: Vec<(Column, Vec<u64>)>,
}

impl TableFile {
    pub(super) fn create(path: &Path, table: &Table) -> io::Result<Self> {
        let columns: Vec<_> = [SCENARIO].iter().chain(table.columns).copied().collect();
        let schema = parse_message_type(&schema(table.name, &columns)).expect("a valid schema");
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("bumper ", env!("CARGO_PKG_VERSION")).to_owned())
            .build();
        let file = File::create(path)?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties));
        let columns = columns.into_iter().map(|column| (column, Vec::new())).collect();
        Ok(Self { writer: writer.map_err(to_io)?, columns })
    }

    /// Rows of one scenario, word after word.
    pub(super) fn write(
        &mut self,
        scenario: u32,
        words: impl IntoIterator<Item = u64>,
    ) -> io::Result<()> {
        let last = self.columns.len() - 1;
        for (at, word) in words.into_iter().enumerate() {
            if at % last == 0 {
                self.columns[0].1.push(scenario.into());
            }
            self.columns[1 + at % last].1.push(word);
        }
        if self.columns[0].1.len() >= ROW_GROUP { self.write_row_group() } else { Ok(()) }
    }

    pub(super) fn close(mut self) -> io::Result<()> {
        if !self.columns[0].1.is_empty() {
            self.write_row_group()?;
        }
        self.writer.close().map(drop).map_err(to_io)
    }

    fn write_row_group(&mut self) -> io::Result<()> {
        let mut group = self.writer.next_row_group().map_err(to_io)?;
        for (column, words) in &mut self.columns {
            let next = group.next_column().map_err(to_io)?;
            let mut chunk = next.expect("one chunk for each column of the schema");
            write_chunk(&mut chunk, column, words).map_err(to_io)?;
            chunk.close().map_err(to_io)?;
            words.clear();
        }
        group.close().map(drop).map_err(to_io)
    }
}

fn schema(name: &str, columns: &[Column]) -> String {
    let mut schema = format!("message {name} {{\n");
    for Column { name, kind } in columns {
        let line = match kind {
            Kind::Flag => format!("REQUIRED BOOLEAN {name};"),
            Kind::Count => format!("REQUIRED INT32 {name} (INTEGER(32,false));"),
            Kind::Number => format!("REQUIRED DOUBLE {name};"),
            Kind::Choice(_) => format!("REQUIRED BYTE_ARRAY {name} (STRING);"),
        };
        writeln!(schema, "  {line}").expect("writing to a string does not fail");
    }
    schema + "}"
}

fn write_chunk(
    chunk: &mut SerializedColumnWriter<'_>,
    column: &Column,
    words: &[u64],
) -> Result<usize, ParquetError> {
    match column.kind {
        Kind::Flag => {
            let values: Vec<bool> = words.iter().map(|&word| word != 0).collect();
            chunk.typed::<BoolType>().write_batch(&values, None, None)
        }
        Kind::Count => {
            // u32 as Parquet stores them: the same bits as i32.
            let values: Vec<i32> = words.iter().map(|&word| word as i32).collect();
            chunk.typed::<Int32Type>().write_batch(&values, None, None)
        }
        Kind::Number => {
            let values: Vec<f64> = words.iter().copied().map(f64::from_bits).collect();
            chunk.typed::<DoubleType>().write_batch(&values, None, None)
        }
        Kind::Choice(choices) => {
            let value = |&word: &u64| ByteArray::from(choices[word as usize]);
            let values: Vec<_> = words.iter().map(value).collect();
            chunk.typed::<ByteArrayType>().write_batch(&values, None, None)
        }
    }
}

fn to_io(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => io::Error::other(inner),
        other => io::Error::other(other),
    }
}
