//! Values and options as they are typed into a shell.

/// A value as it is typed into a shell.
pub(super) fn typed(value: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=@~+:".contains(c);
    if value.chars().all(is_plain) {
        value.to_owned()
    } else {
        format!("'{}'", value.replace('\'', "'\\''"))
    }
}

/// An option with each of its values, as it is typed into a shell.
pub(super) fn in_shell((option, values): (&str, Vec<String>)) -> Vec<String> {
    values.iter().map(|value| format!("{option} {}", typed(value))).collect()
}
