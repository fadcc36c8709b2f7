//! Tables for a page.

/// A table in Markdown: the first column to the left, numbers to the right.
pub fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut text = format!("| {} |\n|---|", header.join(" | "));
    text += &"---:|".repeat(header.len().saturating_sub(1));
    text.push('\n');
    for row in rows {
        text += &format!("| {} |\n", row.join(" | "));
    }
    text + "\n"
}

/// What stands where nothing was measured.
pub const NOTHING: &str = "—";

/// A value as a cell of a table.
pub fn cell<T>(value: Option<T>, show: impl FnOnce(T) -> String) -> String {
    value.map_or(NOTHING.to_owned(), show)
}
