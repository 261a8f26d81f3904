//! How a text table is laid out: what separates its cells, and how its decimals are written.
//!
//! It splits a line into cells with their places. It does not know what a cell means.

/// What separates the cells of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Separator {
    /// `,`
    #[default]
    Comma,
    /// `;`
    Semicolon,
    /// A tabulator.
    Tab,
    /// Runs of blanks and tabulators: no cell is empty.
    Blanks,
}

/// All separators: those first that are rarely part of a cell.
pub(crate) const SEPARATORS: [Separator; 4] =
    [Separator::Tab, Separator::Semicolon, Separator::Comma, Separator::Blanks];

impl Separator {
    /// The separator that a campaign states by its character.
    pub(crate) fn of(text: &str) -> Option<Self> {
        SEPARATORS.into_iter().find(|separator| separator.character() == text)
    }

    /// The character that stands for it in a campaign.
    pub(crate) fn character(self) -> &'static str {
        match self {
            Self::Comma => ",",
            Self::Semicolon => ";",
            Self::Tab => "\t",
            Self::Blanks => " ",
        }
    }

    /// Its byte; `None` for runs of blanks.
    pub(crate) fn byte(self) -> Option<u8> {
        match self {
            Self::Comma => Some(b','),
            Self::Semicolon => Some(b';'),
            Self::Tab => Some(b'\t'),
            Self::Blanks => None,
        }
    }

    /// Its name, in the plural.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Comma => "commas",
            Self::Semicolon => "semicolons",
            Self::Tab => "tabs",
            Self::Blanks => "blanks",
        }
    }
}

/// What stands before the decimals of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Decimal {
    /// Not known yet: the first number with decimals shows it.
    #[default]
    Open,
    /// `.`
    Point,
    /// `,`
    Comma,
}

/// The longest number (bytes) with a decimal comma.
const LONGEST: usize = 64;

impl Decimal {
    /// A number, as decimals are written in its file; `None` for anything else.
    ///
    /// The first number with decimals settles how all others are written, unless it is stated: a
    /// file that mixes points and commas has thousands separators or a fault.
    pub(crate) fn number(&mut self, cell: &str, separator: Separator) -> Option<f64> {
        match self {
            Self::Point => cell.parse().ok(),
            Self::Comma => with_comma(cell),
            // Between commas only a cell in quotes has one, and three digits may be thousands.
            Self::Open if separator == Separator::Comma && may_be_thousands(cell) => None,
            Self::Open => match cell.parse() {
                Ok(value) => {
                    if cell.contains('.') {
                        *self = Self::Point;
                    }
                    Some(value)
                }
                Err(_) => {
                    let value = with_comma(cell)?;
                    *self = Self::Comma;
                    Some(value)
                }
            },
        }
    }
}

impl Decimal {
    /// A number without its separators of thousands; `None` where it has none.
    pub(crate) fn without_thousands(&self, cell: &str) -> Option<String> {
        let (decimal, thousands) = match self {
            Self::Comma => (',', '.'),
            Self::Point => ('.', ','),
            Self::Open => return None,
        };
        let (whole, decimals) = cell.split_once(decimal).unwrap_or((cell, ""));
        let mut groups = whole.trim_start_matches(['+', '-']).split(thousands);
        let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        let is_first =
            groups.next().is_some_and(|first| matches!(first.len(), 1..=3) && is_digits(first));
        let mut others = groups.peekable();
        let are_thousands = is_first
            && others.peek().is_some()
            && others.all(|group| group.len() == 3 && is_digits(group))
            && is_digits(decimals);
        are_thousands.then(|| cell.replace(thousands, ""))
    }
}

/// Whether a comma stands before three digits, the last ones, and not after a zero alone.
fn may_be_thousands(cell: &str) -> bool {
    cell.split_once(',')
        .is_some_and(|(whole, rest)| rest.len() == 3 && whole.trim_start_matches(['+', '-']) != "0")
}

/// A number with a decimal comma, or without decimals.
fn with_comma(cell: &str) -> Option<f64> {
    let mut bytes = [0; LONGEST];
    let own = bytes.get_mut(..cell.len())?;
    own.copy_from_slice(cell.as_bytes());
    let mut commas = 0;
    for byte in own.iter_mut() {
        match byte {
            b'.' => return None,
            b',' => {
                *byte = b'.';
                commas += 1;
            }
            _ => {}
        }
    }
    if commas > 1 {
        return None;
    }
    std::str::from_utf8(own).ok()?.parse().ok()
}

/// A cell: text without blanks and quotes around it, and its bytes in the line.
pub(crate) type Cell<'a> = (&'a str, (usize, usize));

/// The cells of a line. A cell in double quotes may hold separators.
pub(crate) fn cells(line: &str, separator: Separator) -> impl Iterator<Item = Cell<'_>> {
    let mut at = Some(0);
    let is_end = move |c: char| match separator.byte() {
        Some(byte) => c == char::from(byte),
        None => c.is_ascii_whitespace(),
    };
    // Blanks around a cell, of which a separator is none.
    let is_blank = move |c: char| c.is_whitespace() && (separator.byte().is_none() || !is_end(c));
    std::iter::from_fn(move || {
        let start = at?;
        let rest = &line[start..];
        let lead = rest.len() - rest.trim_start_matches(is_blank).len();
        if separator == Separator::Blanks && lead == rest.len() {
            at = None;
            return None;
        }
        let end = match rest[lead..].strip_prefix('"') {
            Some(quoted) => {
                let close = quoted.find('"').map_or(quoted.len(), |close| close + 1);
                let after = lead + 1 + close;
                rest[after..].find(is_end).map(|end| after + end)
            }
            None => rest[lead..].find(is_end).map(|end| lead + end),
        };
        at = end.map(|end| start + end + 1);
        let raw = &rest[..end.unwrap_or(rest.len())];
        let cell = raw.trim();
        let begin = start + (raw.len() - raw.trim_start().len());
        let bare = cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"'));
        Some(match bare {
            Some(bare) => (bare.trim(), (begin + 1, begin + 1 + bare.len())),
            None => (cell, (begin, begin + cell.len())),
        })
    })
}

/// The names of a header row. Between blanks a unit in brackets belongs to the name before it, and
/// may hold blanks itself.
pub(crate) fn names(line: &str, separator: Separator) -> Vec<Cell<'_>> {
    if separator != Separator::Blanks {
        return cells(line, separator).collect();
    }
    let mut found: Vec<(usize, usize)> = Vec::new();
    let (mut depth, mut is_inside) = (0_usize, false);
    for (at, c) in line.char_indices() {
        if c.is_whitespace() && depth == 0 {
            is_inside = false;
            continue;
        }
        let end = at + c.len_utf8();
        match found.last_mut() {
            Some(last) if is_inside || matches!(c, '[' | '(') => last.1 = end,
            _ => found.push((at, end)),
        }
        is_inside = true;
        match c {
            '[' | '(' => depth += 1,
            ']' | ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    let cell = |(start, end): (usize, usize)| {
        let text = &line[start..end];
        let bare = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        bare.map_or((text, (start, end)), |bare| (bare.trim(), (start + 1, end - 1)))
    };
    found.into_iter().map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(line: &str, separator: Separator) -> Vec<&str> {
        cells(line, separator).map(|(cell, _)| cell).collect()
    }

    #[test]
    fn cells_are_split_at_their_separator_alone() {
        assert_eq!(texts(" 1, 2 ,,\"a,b\"", Separator::Comma), ["1", "2", "", "a,b"]);
        assert_eq!(texts("1;2,5; ", Separator::Semicolon), ["1", "2,5", ""]);
        assert_eq!(texts("1\t\t 3 4\t", Separator::Tab), ["1", "", "3 4", ""]);
        assert_eq!(texts("\t1  2\t 3 ", Separator::Blanks), ["1", "2", "3"]);
        assert_eq!(texts("", Separator::Comma), [""]);
        assert!(texts("  ", Separator::Blanks).is_empty());
        for separator in SEPARATORS {
            let line = "a,\"b; c\" é\t d";
            cells(line, separator).for_each(|(text, (a, b))| assert_eq!(line[a..b].trim(), text));
        }
    }

    #[test]
    fn between_blanks_a_unit_belongs_to_the_name_before_it() {
        let found = names("  time [s] x  v[m s^-1] \"q\" z (m)", Separator::Blanks);
        let found: Vec<&str> = found.into_iter().map(|(name, _)| name).collect();
        assert_eq!(found, ["time [s]", "x", "v[m s^-1]", "q", "z (m)"]);
    }

    #[test]
    fn the_first_number_with_decimals_settles_how_they_are_written() {
        let mut decimal = Decimal::Open;
        assert_eq!(decimal.number("12", Separator::Tab), Some(12.0));
        assert_eq!(decimal.number("-1,5e-3", Separator::Tab), Some(-1.5e-3));
        assert_eq!(decimal.number("1.5", Separator::Tab), None);
        assert_eq!(decimal.number("1,234,5", Separator::Tab), None);
        let mut decimal = Decimal::Open;
        assert_eq!(decimal.number("0.5", Separator::Semicolon), Some(0.5));
        assert_eq!(decimal.number("1,234", Separator::Semicolon), None);
        // Between commas in quotes alone, where it cannot be thousands.
        assert_eq!(Decimal::Open.number("1,234", Separator::Comma), None);
        let mut decimal = Decimal::Open;
        assert_eq!(decimal.number("1,5", Separator::Comma), Some(1.5));
        assert_eq!(decimal.number("1,234", Separator::Comma), Some(1.234));
        assert_eq!(Decimal::Comma.number("1,234", Separator::Comma), Some(1.234));
        let mut decimal = Decimal::Open;
        assert_eq!(decimal.number("0.5", Separator::Comma), Some(0.5));
        assert_eq!(decimal.number("1,5", Separator::Comma), None);
    }

    #[test]
    fn thousands_are_groups_of_three_digits() {
        let comma = |cell: &str| Decimal::Comma.without_thousands(cell);
        assert_eq!(comma("1.512,0").as_deref(), Some("1512,0"));
        assert_eq!(comma("-12.345.678").as_deref(), Some("-12345678"));
        for cell in ["1,5", "1512.0", "1.51,0", ".512,0", "28.11.2026", "1.512,0,1", "a.512"] {
            assert_eq!(comma(cell), None, "{cell}");
        }
        assert_eq!(Decimal::Point.without_thousands("1,512.0").as_deref(), Some("1512.0"));
        assert_eq!(Decimal::Open.without_thousands("1,512"), None);
    }
}
