//! The rows of a Parquet file, block by block, as a table's cells.
//!
//! Columns are named like those of a CSV file, `name [unit]`; numbers of any width are read, a null
//! is a reading that is not there. Lists and texts are no columns of numbers.

use std::fs::File;
use std::path::Path;

use parquet::basic::Type as Physical;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

/// Rows taken from the file at a time.
const STEP: usize = 4096;

/// A Parquet file being read.
pub(crate) struct Rows {
    file: SerializedFileReader<File>,
    /// Columns to be read.
    wanted: Vec<usize>,
    /// The next group of rows, and the readers of the one at hand.
    group: usize,
    readers: Vec<ColumnReader>,
    /// Rows of the group at hand that are still to come.
    left: usize,
    /// Values of the rows at hand by wanted column, `None` for a null, and how many were taken.
    block: Vec<Vec<Option<f64>>>,
    taken: usize,
    /// Rows shown.
    number: usize,
    /// Bytes of the groups read.
    bytes: u64,
}

impl std::fmt::Debug for Rows {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Rows").field("number", &self.number).finish_non_exhaustive()
    }
}

impl Rows {
    /// The rows of a file that is open; `path` names it in messages.
    ///
    /// # Errors
    /// In words: unreadable, or not a Parquet file.
    pub(crate) fn of(path: &Path, file: File) -> Result<Self, String> {
        let file = SerializedFileReader::new(file)
            .map_err(|error| format!("`{}` is not a Parquet file: {error}", path.display()))?;
        Ok(Self {
            file,
            wanted: Vec::new(),
            group: 0,
            readers: Vec::new(),
            left: 0,
            block: Vec::new(),
            taken: 0,
            number: 0,
            bytes: 0,
        })
    }

    /// The names of all columns, in their order.
    pub(crate) fn names(&self) -> Vec<String> {
        let schema = self.file.metadata().file_metadata().schema_descr();
        schema.columns().iter().map(|column| column.path().parts().join(".")).collect()
    }

    /// Lets these columns be read.
    ///
    /// # Errors
    /// The first of them that holds no numbers, and what it holds.
    pub(crate) fn want(&mut self, columns: Vec<usize>) -> Result<(), (usize, &'static str)> {
        let schema = self.file.metadata().file_metadata().schema_descr();
        for column in &columns {
            let described = schema.column(*column);
            let found = match described.physical_type() {
                _ if described.max_rep_level() > 0 => "lists",
                Physical::BOOLEAN => "true and false",
                Physical::INT96 => "dates",
                Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY => "texts",
                _ => continue,
            };
            return Err((*column, found));
        }
        self.block = vec![Vec::new(); columns.len()];
        self.wanted = columns;
        Ok(())
    }

    /// Bytes read so far, about.
    pub(crate) fn bytes_read(&self) -> u64 {
        self.bytes
    }

    /// The cells of the wanted columns of the next row with the row's number, from 1; `None` at the
    /// end.
    ///
    /// # Errors
    /// The file's.
    pub(crate) fn next(&mut self, cells: &mut Vec<Option<f64>>) -> Result<Option<usize>, String> {
        while self.taken >= self.block.first().map_or(0, Vec::len) {
            if !self.fill().map_err(|error| error.to_string())? {
                return Ok(None);
            }
        }
        cells.clear();
        cells.extend(self.block.iter().map(|column| column.get(self.taken).copied().flatten()));
        self.taken += 1;
        self.number += 1;
        Ok(Some(self.number))
    }

    /// Takes the next rows from the file; whether there are any.
    fn fill(&mut self) -> Result<bool, ParquetError> {
        while self.left == 0 {
            if self.group >= self.file.num_row_groups() || self.wanted.is_empty() {
                return Ok(false);
            }
            let group = self.file.get_row_group(self.group)?;
            self.left = usize::try_from(group.metadata().num_rows()).unwrap_or_default();
            self.bytes += u64::try_from(group.metadata().compressed_size()).unwrap_or_default();
            self.readers = self
                .wanted
                .iter()
                .map(|column| group.get_column_reader(*column))
                .collect::<Result<_, _>>()?;
            self.group += 1;
        }
        let rows = self.left.min(STEP);
        for (reader, column) in self.readers.iter_mut().zip(&mut self.block) {
            match reader {
                ColumnReader::DoubleColumnReader(reader) => take(reader, rows, column, |v| v),
                ColumnReader::FloatColumnReader(reader) => take(reader, rows, column, f64::from),
                ColumnReader::Int32ColumnReader(reader) => take(reader, rows, column, f64::from),
                ColumnReader::Int64ColumnReader(reader) => {
                    take(reader, rows, column, |value| value as f64)
                }
                _ => Err(ParquetError::General("a column holds no numbers".to_owned())),
            }?;
        }
        (self.left, self.taken) = (self.left - rows, 0);
        Ok(true)
    }
}

/// Reads so many rows of a column.
fn take<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
    into: &mut Vec<Option<f64>>,
    number: impl Fn(T::T) -> f64,
) -> Result<(), ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let mut read = 0;
    while read < rows {
        let (records, ..) =
            reader.read_records(rows - read, Some(&mut levels), None, &mut values)?;
        if records == 0 {
            return Err(ParquetError::EOF("a column is shorter than its group of rows".to_owned()));
        }
        read += records;
    }
    // A column without nulls has no levels; else the highest level is a value.
    let highest = levels.iter().copied().max().unwrap_or_default();
    let is_full = values.len() == rows;
    let mut values = values.into_iter().map(number);
    into.clear();
    if is_full {
        into.extend(values.map(Some));
    } else {
        let there = |level: i16| level == highest && level > 0;
        into.extend(levels.iter().map(|l| if there(*l) { values.next() } else { None }));
    }
    Ok(())
}
