//! `contacts.parquet`: one row for each pair of triangles that touch, in the order of scenarios and
//! then of triangles; columns `scenario`, `fixed_triangle`, `moving_triangle`, all u32.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::Int32Type;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use crate::tree::descent::Pair;

const SCHEMA: &str = "
message contacts {
  REQUIRED INT32 scenario (INTEGER(32,false));
  REQUIRED INT32 fixed_triangle (INTEGER(32,false));
  REQUIRED INT32 moving_triangle (INTEGER(32,false));
}";

/// Rows of a row group: 12 MB before compression.
const ROW_GROUP: usize = 1 << 20;

/// Rows that wait for their row group to be full, and the groups already in the file. The file can
/// be read only after [`ContactsFile::close`].
pub(super) struct ContactsFile {
    writer: SerializedFileWriter<File>,
    /// u32 as Parquet stores them: the same bits as i32.
    columns: [Vec<i32>; 3],
}

impl ContactsFile {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let schema = parse_message_type(SCHEMA).expect("the schema is valid");
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("bumper ", env!("CARGO_PKG_VERSION")).to_owned())
            .build();
        let file = File::create(path)?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties));
        Ok(Self { writer: writer.map_err(to_io)?, columns: Default::default() })
    }

    pub(super) fn write(&mut self, scenario: u32, pairs: &[Pair]) -> io::Result<()> {
        for &[fixed, moving] in pairs {
            for (column, value) in self.columns.iter_mut().zip([scenario, fixed, moving]) {
                column.push(value.cast_signed());
            }
        }
        if self.columns[0].len() >= ROW_GROUP { self.write_row_group() } else { Ok(()) }
    }

    pub(super) fn close(mut self) -> io::Result<()> {
        if !self.columns[0].is_empty() {
            self.write_row_group()?;
        }
        self.writer.close().map(drop).map_err(to_io)
    }

    fn write_row_group(&mut self) -> io::Result<()> {
        let mut group = self.writer.next_row_group().map_err(to_io)?;
        for column in &mut self.columns {
            let next = group.next_column().map_err(to_io)?;
            let mut chunk = next.expect("one chunk for each column of the schema");
            chunk.typed::<Int32Type>().write_batch(column, None, None).map_err(to_io)?;
            chunk.close().map_err(to_io)?;
            column.clear();
        }
        group.close().map(drop).map_err(to_io)
    }
}

fn to_io(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => io::Error::other(inner),
        other => io::Error::other(other),
    }
}
