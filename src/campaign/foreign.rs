//! Files of other kinds than tables of text, by their first bytes: programs, workbooks, pictures, JSON.

use crate::campaign::encodings::Encoding;

/// What to do about a file that holds a table in a form of its own.
const EXPORT: &str = "export the table as CSV";
/// What to do about a file that holds none.
const NO_TABLE: &str = "name the file that holds the table";
/// Bytes at the beginning of a text, none of which is zero.
const TEXT: usize = 512;

/// The first bytes of a kind of files, what it is, and what to do.
type Kind = (&'static [u8], &'static str, &'static str);

const KINDS: &[Kind] = &[
    (b"PK\x03\x04", "a zip archive, such as an Excel workbook (.xlsx)", EXPORT),
    (b"\xd0\xcf\x11\xe0", "an Office document, such as an Excel workbook (.xls)", EXPORT),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file", EXPORT),
    (b"MATLAB 7.3 MAT-file", "a MATLAB file", EXPORT),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file", EXPORT),
    (b"\x93NUMPY", "a NumPy array", EXPORT),
    (b"CDF\x01", "a NetCDF file", EXPORT),
    (b"CDF\x02", "a NetCDF file", EXPORT),
    (b"SQLite format 3\0", "an SQLite database", EXPORT),
    (b"#ROSBAG V", "a ROS bag", "export the topic as CSV: `rostopic echo -b BAG -p TOPIC`"),
    (b"\x89MCAP0\r\n", "an MCAP recording", "export the topic as CSV"),
    (b"TDSm", "a TDMS file of LabVIEW", EXPORT),
    (b"PAR1", "a Parquet file", "let its name end with .parquet"),
    (b"BZh", "packed with bzip2", "unpack it, or pack it with gzip"),
    (b"\xfd7zXZ\0", "packed with xz", "unpack it, or pack it with gzip"),
    (b"\x28\xb5\x2f\xfd", "packed with zstd", "unpack it, or pack it with gzip"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", "unpack it"),
    (b"\x7fELF", "a program", NO_TABLE),
    (b"\x89PNG\r\n", "a picture", NO_TABLE),
    (b"\xff\xd8\xff", "a picture", NO_TABLE),
    (b"GIF8", "a picture", NO_TABLE),
    (b"%PDF-", "a PDF document", NO_TABLE),
    (b"<?xml", "an XML file", EXPORT),
    (b"<!DOCTYPE html", "a page of HTML", NO_TABLE),
    (b"<html", "a page of HTML", NO_TABLE),
];

/// What to do about JSON.
const OF_JSON: &str = "write the table as CSV: a row of names with units, `time [s],x [mm]`, then a row of numbers each";

/// What a file is that begins with these bytes, and what to do about it; `None` for a table of text.
pub(crate) fn foreign(head: &[u8]) -> Option<String> {
    let is = |what: &str, remedy: &str| Some(format!("it is {what}, no table of text; {remedy}"));
    if let Some((_, what, remedy)) = KINDS.iter().find(|(first, ..)| head.starts_with(first)) {
        return is(what, remedy);
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    let line = text.split(|byte| *byte == b'\n').next().unwrap_or_default().trim_ascii();
    let then = |first: u8| line.strip_prefix(&[first]).map(<[u8]>::trim_ascii_start);
    let is_object = |rest: &[u8]| rest.is_empty() || rest.starts_with(b"\"");
    if then(b'{').is_some_and(is_object)
        || then(b'[').is_some_and(|rest| rest.first() == Some(&b'{'))
    {
        return is("JSON", OF_JSON);
    }
    let is_wide = matches!(Encoding::of(head), Some(Encoding::Utf16Low | Encoding::Utf16High));
    let has_zero = head.iter().take(TEXT).any(|byte| *byte == 0);
    (has_zero && !is_wide)
        .then(|| "it has bytes that are no text; export the table as CSV, in UTF-8".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_tables_of_text_are_none() {
        for (first, what, remedy) in KINDS {
            let said = foreign(&[first, &b"\x01\x02\n1,2\n"[..]].concat()).unwrap_or_default();
            assert!(said.contains(what) && said.contains(remedy), "{what}: {said}");
        }
        for text in
            ["{\"t\": 1}\n{\"t\": 2}\n", "\u{feff}{ \"t\": 1 }", "[{\"t\":1}]", "{\n \"t\": []}"]
        {
            assert!(foreign(text.as_bytes()).is_some_and(|said| said.contains("JSON")), "{text}");
        }
        assert!(foreign(b"t,x\n\x00\x01").is_some());
        let wide = |text: &str| {
            let units = text.encode_utf16().flat_map(u16::to_le_bytes);
            [0xff, 0xfe].into_iter().chain(units).collect::<Vec<u8>>()
        };
        let tables: [&[u8]; 6] = [
            b"",
            b"[s],[mm]\n",
            b"{t},{x}\n1,2\n",
            b"t,x\n1,2\n",
            b"# ROSBAG\nt,x\n",
            &wide("t,x\n1,2\n"),
        ];
        for table in tables {
            assert_eq!(foreign(table), None, "{table:?}");
        }
    }
}
