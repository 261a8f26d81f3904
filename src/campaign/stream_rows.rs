//! Rows that are left out of a stream.

/// Leaves the rows out of times and values for which this holds, by number.
pub(crate) fn leave_rows_out(
    times: &mut Vec<f64>,
    values: &mut Vec<f64>,
    is_out: impl Fn(usize) -> bool,
) {
    for list in [times, values] {
        let mut number = 0..;
        list.retain(|_| number.next().is_none_or(|row| !is_out(row)));
    }
}
