//! Texts in other encodings than UTF-8, turned into UTF-8 as they are read: UTF-16 by its byte order
//! mark, and Windows-1252, whose `°`, `µ` and `ä` are single bytes that UTF-8 does not have.

use std::io::{self, Read};

/// Tables have more ASCII than this.
const MOSTLY_ASCII: f64 = 0.8;
/// Bytes read at a time.
const CHUNK: usize = 1 << 14;

/// How a text is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// UTF-16, the low byte first.
    Utf16Low,
    /// UTF-16, the high byte first.
    Utf16High,
    /// Windows-1252, of which Latin-1 is a part.
    Windows1252,
}

impl Encoding {
    /// Of a file that begins with these bytes; `None` for UTF-8, and for what is no text.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        if head.starts_with(b"\xff\xfe") {
            return Some(Self::Utf16Low);
        }
        if head.starts_with(b"\xfe\xff") {
            return Some(Self::Utf16High);
        }
        // The last character may be cut.
        let fault = std::str::from_utf8(head).err().filter(|fault| fault.error_len().is_some());
        let is_text = |byte: &u8| match byte {
            b'\t' | b'\r' | b'\n' => true,
            // No characters of the encoding, and one that no header has.
            0x81 | 0x8d | 0x8f | 0x90 | 0x9d | 0xff => false,
            other => *other >= b' ',
        };
        let plain = head.iter().filter(|byte| byte.is_ascii()).count();
        let is_table = head.iter().all(is_text) && plain as f64 > MOSTLY_ASCII * head.len() as f64;
        fault.filter(|_| is_table).map(|_| Self::Windows1252)
    }

    /// Its name.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Utf16Low | Self::Utf16High => "UTF-16",
            Self::Windows1252 => "Windows-1252",
        }
    }

    /// Turns bytes into UTF-8, as far as their characters are whole; how many were taken.
    fn decode(self, bytes: &[u8], is_last: bool, into: &mut Vec<u8>) -> usize {
        let mut push = |c: char| into.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
        let of_pair = match self {
            Self::Windows1252 => {
                bytes.iter().for_each(|byte| push(windows_1252(*byte)));
                return bytes.len();
            }
            Self::Utf16Low => u16::from_le_bytes,
            Self::Utf16High => u16::from_be_bytes,
        };
        let mut units: Vec<u16> =
            bytes.chunks_exact(2).map(|pair| of_pair([pair[0], pair[1]])).collect();
        // The other half of a pair of units may be still to come.
        if !is_last && units.last().is_some_and(|unit| (0xd800..0xdc00).contains(unit)) {
            units.pop();
        }
        let taken = if is_last { bytes.len() } else { 2 * units.len() };
        let all = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        all.filter(|c| *c != '\u{feff}').for_each(push);
        taken
    }
}

/// What Windows-1252 has between 0x80 and 0x9f.
const AFTER_ASCII: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}',
    '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

fn windows_1252(byte: u8) -> char {
    match byte {
        0x80..=0x9f => AFTER_ASCII[usize::from(byte - 0x80)],
        other => char::from(other),
    }
}

/// A text as UTF-8.
pub(crate) struct Decoded<R> {
    source: R,
    encoding: Encoding,
    /// Bytes of a character that is not whole yet.
    rest: Vec<u8>,
    text: Vec<u8>,
    /// How much of the text was shown.
    shown: usize,
}

impl<R: Read> Decoded<R> {
    /// Of a text in this encoding.
    pub(crate) fn new(source: R, encoding: Encoding) -> Self {
        Self { source, encoding, rest: Vec::new(), text: Vec::new(), shown: 0 }
    }
}

impl<R: Read> Read for Decoded<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.shown == self.text.len() {
            (self.shown, self.text) = (0, Vec::new());
            let before = self.rest.len();
            self.rest.resize(before + CHUNK, 0);
            let read = self.source.read(&mut self.rest[before..]);
            self.rest.truncate(before + *read.as_ref().unwrap_or(&0));
            let is_last = read? == 0;
            let taken = self.encoding.decode(&self.rest, is_last, &mut self.text);
            self.rest.drain(..taken);
            if is_last && self.text.is_empty() {
                return Ok(0);
            }
        }
        let count = into.len().min(self.text.len() - self.shown);
        into[..count].copy_from_slice(&self.text[self.shown..self.shown + count]);
        self.shown += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    /// Gives three bytes at a time.
    struct Drops<'a>(&'a [u8]);

    impl Read for Drops<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let count = self.0.len().min(into.len()).min(3);
            into[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    #[test]
    fn texts_are_the_same_in_each_encoding() {
        let text = "Temperatur [°C];Weg [µm]\r\n1,5;2\r\n";
        let beyond = format!("{text}𝛼 \n");
        let utf16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            let marked = format!("\u{feff}{beyond}");
            marked.encode_utf16().flat_map(bytes).collect()
        };
        let single: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
        for (bytes, encoding, due) in [
            (utf16(u16::to_le_bytes), Encoding::Utf16Low, beyond.as_str()),
            (utf16(u16::to_be_bytes), Encoding::Utf16High, beyond.as_str()),
            (single, Encoding::Windows1252, text),
        ] {
            assert_eq!(Encoding::of(&bytes), Some(encoding));
            let mut found = String::new();
            Decoded::new(Drops(&bytes), encoding).read_to_string(&mut found).unwrap();
            assert_eq!(found, due, "{}", encoding.words());
        }
        assert_eq!(Encoding::of(beyond.as_bytes()), None);
        // Cut in the middle of a character; no text.
        assert_eq!(Encoding::of(&"m °".as_bytes()[..3]), None);
        assert_eq!(Encoding::of(b"\x00\xff\x00\xfe"), None);
        let half = [0xff, 0xfe, 0x41, 0x00, 0x00, 0xd8, 0x42];
        let mut found = String::new();
        Decoded::new(Drops(&half), Encoding::Utf16Low).read_to_string(&mut found).unwrap();
        assert_eq!(found, "A\u{fffd}");
    }
}
