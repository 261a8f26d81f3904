//! Where the rows of a table come from: the lines of a text, or the rows of a Parquet file.

use std::path::Path;

use crate::campaign::encodings::Encoding;
use crate::campaign::header::Column;
use crate::campaign::lines::Lines;
#[cfg(feature = "parquet")]
use crate::campaign::parquet::Rows;
use crate::campaign::preamble::pass_header;
use crate::campaign::recognise::layout::Layout;
use crate::document::files::{open_regular, reason};

/// Where rows come from.
#[derive(Debug)]
pub(super) enum Source {
    Text(Lines),
    #[cfg(feature = "parquet")]
    Parquet(Box<Rows>),
}

impl Source {
    /// The same from the first row on, of a file with this layout and these columns; else why it cannot
    /// be read.
    pub(super) fn anew(
        &self,
        path: &Path,
        layout: &Layout,
        #[cfg_attr(
            not(feature = "parquet"),
            expect(unused_variables, reason = "the lines of a text have all columns")
        )]
        columns: &[Column],
    ) -> Result<Self, String> {
        let unreadable = |error: std::io::Error| reason(path, &error);
        let file = open_regular(path).map_err(unreadable)?;
        Ok(match self {
            Self::Text(_) => {
                let mut lines = Lines::of(file).map_err(unreadable)?;
                pass_header(&mut lines, layout).map_err(unreadable)?;
                Self::Text(lines)
            }
            #[cfg(feature = "parquet")]
            Self::Parquet(_) => {
                let mut rows = Rows::of(path, file)?;
                let read = columns.iter().filter(|column| column.wanted.is_some());
                let wanted = rows.want(read.map(|column| column.index).collect());
                wanted.map_err(|(_, found)| found.to_owned())?;
                Self::Parquet(Box::new(rows))
            }
        })
    }

    /// How the file is encoded, if not as UTF-8.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        match self {
            Self::Text(lines) => lines.encoding,
            #[cfg(feature = "parquet")]
            Self::Parquet(_) => None,
        }
    }

    /// Bytes of the file, packed as it is, read so far.
    pub(super) fn bytes_read(&self) -> u64 {
        match self {
            Self::Text(lines) => lines.bytes_read(),
            #[cfg(feature = "parquet")]
            Self::Parquet(rows) => rows.bytes_read(),
        }
    }
}
