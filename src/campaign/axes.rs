//! Names that differ in their axis alone: `px`, `py`, `pz`, or `pos_e`, `pos_n`, `pos_u`.

/// The axes x, y, z, wherever they stand in a name.
const LETTERS: [&str; 3] = ["x", "y", "z"];
/// Axes that are a whole part of a name: east, north, up.
const WORDS: [[&str; 3]; 4] = [
    ["e", "n", "u"],
    ["east", "north", "up"],
    ["easting", "northing", "elevation"],
    ["easting", "northing", "height"],
];
/// What parts a name.
const PARTS: [char; 5] = ['_', '.', '-', '/', ' '];

/// The names of all three axes, for each axis that a name in small letters may hold as its first, with
/// the bytes before the axis.
pub(crate) fn triples(first: &str) -> Vec<(usize, [String; 3])> {
    let with = |at: usize, axes: [&str; 3]| {
        let end = at + axes[0].len();
        (at, axes.map(|axis| format!("{}{axis}{}", &first[..at], &first[end..])))
    };
    let letters = first.match_indices(LETTERS[0]).map(|(at, _)| with(at, LETTERS));
    let words = WORDS.into_iter().flat_map(|axes| {
        let is_part = move |(at, axis): &(usize, &str)| {
            let (before, behind) = (&first[..*at], &first[at + axis.len()..]);
            (before.is_empty() || before.ends_with(PARTS))
                && (behind.is_empty() || behind.starts_with(PARTS))
        };
        let all = first.match_indices(axes[0]).filter(is_part);
        all.map(move |(at, _)| with(at, axes))
    });
    letters.chain(words).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_letters_of_a_name_or_whole_parts_of_it() {
        let all = |first: &str| -> Vec<String> {
            triples(first).into_iter().map(|(_, names)| names.join(" ")).collect()
        };
        assert_eq!(all("px"), ["px py pz"]);
        assert_eq!(all("xx_m"), ["xx_m yx_m zx_m", "xx_m xy_m xz_m"]);
        assert_eq!(all("e-baseline"), ["e-baseline n-baseline u-baseline"]);
        assert_eq!(all("pos_east"), ["pos_east pos_north pos_up"]);
        assert_eq!(all("e"), ["e n u"]);
        assert_eq!(all("easting").len(), 2);
        assert!(all("theta").is_empty() && all("he").is_empty());
    }
}
