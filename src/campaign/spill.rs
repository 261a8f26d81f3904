//! Columns of numbers in an unnamed temporary file, in blocks, read back by place.
//!
//! A block holds its columns one after the other, little-endian `f64`; a stretch of one column is
//! one positional read, so any number of threads read at once. The file has no name in the folder
//! of temporary files (`TMPDIR`) and is gone with its last user, however the program ends.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::sync::Arc;

/// Samples in one block: as many whole chunks of those that are computed together.
pub const BLOCK: usize = 12_288;
/// Bytes of one number.
const WIDTH: usize = 8;

/// A temporary file that grows block by block.
#[derive(Debug)]
pub(crate) struct Spill {
    file: Arc<File>,
    end: u64,
}

impl Spill {
    /// An empty file.
    ///
    /// # Errors
    /// The disk's.
    pub(crate) fn new() -> io::Result<Self> {
        Ok(Self { file: Arc::new(tempfile::tempfile()?), end: 0 })
    }

    /// A table in this file, of so many columns, without rows yet.
    pub(crate) fn table(&self, columns: usize) -> Table {
        Table { file: self.file.clone(), columns, len: 0, blocks: Vec::new() }
    }

    /// Adds one block to a table of this file: as many columns as it has, of the same length. Every
    /// block but a table's last has [`BLOCK`] rows.
    ///
    /// # Errors
    /// The disk's.
    pub(crate) fn append<'a>(
        &mut self,
        table: &mut Table,
        columns: impl Iterator<Item = &'a [f64]>,
        rows: usize,
    ) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(table.columns * rows * WIDTH);
        for column in columns {
            column.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
        }
        write_at(&self.file, &bytes, self.end)?;
        table.blocks.push(self.end);
        table.len += rows;
        self.end += bytes.len() as u64;
        Ok(())
    }
}

/// Where the columns of one table stand in a temporary file.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    file: Arc<File>,
    columns: usize,
    len: usize,
    /// Where each block begins.
    blocks: Vec<u64>,
}

impl Table {
    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Puts rows of a column at the end of `into`.
    ///
    /// # Errors
    /// The disk's; `into` is then as it was, or longer.
    pub(crate) fn read(
        &self,
        column: usize,
        rows: Range<usize>,
        into: &mut Vec<f64>,
    ) -> io::Result<()> {
        let mut bytes = [0; 8 * BLOCK];
        let mut at = rows.start;
        while at < rows.end {
            let block = at / BLOCK;
            let begin = block * BLOCK;
            let end = self.len.min(begin + BLOCK);
            let stop = rows.end.min(end);
            let start = self.blocks.get(block).filter(|_| at < end);
            let start = start.ok_or_else(|| io::Error::from(io::ErrorKind::UnexpectedEof))?;
            let place = (column * (end - begin) + at - begin) * WIDTH;
            let bytes = &mut bytes[..(stop - at) * WIDTH];
            read_at(&self.file, bytes, start + place as u64)?;
            into.extend(bytes.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)));
            at = stop;
        }
        Ok(())
    }
}

#[cfg(not(windows))]
fn write_at(file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, at)
}

#[cfg(not(windows))]
fn read_at(file: &File, bytes: &mut [u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, at)
}

#[cfg(windows)]
fn write_at(file: &File, mut bytes: &[u8], mut at: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let count = std::os::windows::fs::FileExt::seek_write(file, bytes, at)?;
        if count == 0 {
            return Err(io::ErrorKind::WriteZero.into());
        }
        (bytes, at) = (&bytes[count..], at + count as u64);
    }
    Ok(())
}

#[cfg(windows)]
fn read_at(file: &File, mut bytes: &mut [u8], mut at: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let count = std::os::windows::fs::FileExt::seek_read(file, bytes, at)?;
        if count == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        (bytes, at) = (&mut bytes[count..], at + count as u64);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn rows_come_back_bit_by_bit_across_blocks_and_beside_other_tables() {
        let mut spill = Spill::new().unwrap();
        let (mut one, mut other) = (spill.table(2), spill.table(1));
        let value = |column: usize, row: usize| (row as f64).sin() * 10_f64.powi(column as i32);
        let rows = 2 * BLOCK + 77;
        for begin in (0..rows).step_by(BLOCK) {
            let count = BLOCK.min(rows - begin);
            let columns: Vec<Vec<f64>> = (0..2)
                .map(|column| (begin..begin + count).map(|row| value(column, row)).collect())
                .collect();
            spill.append(&mut one, columns.iter().map(Vec::as_slice), count).unwrap();
            let special = [f64::NAN, -0.0, f64::MIN_POSITIVE / 4.0];
            spill.append(&mut other, std::iter::once(special.as_slice()), 3).unwrap();
        }
        assert_eq!(one.len(), rows);
        for range in [0..rows, 5..5, BLOCK - 1..BLOCK + 1, 2 * BLOCK..rows, 17..2 * BLOCK + 3] {
            for column in 0..2 {
                let mut found = Vec::new();
                one.read(column, range.clone(), &mut found).unwrap();
                let expected: Vec<f64> = range.clone().map(|row| value(column, row)).collect();
                assert_eq!(found, expected, "{range:?}");
            }
        }
        let mut found = Vec::new();
        other.read(0, 0..3, &mut found).unwrap();
        assert!(found[0].is_nan() && found[1].is_sign_negative() && found[2] > 0.0);
        assert!(one.read(0, rows - 1..rows + 1, &mut found).is_err(), "past the end");
    }
}
