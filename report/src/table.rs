//! Tables for the terminal.

/// Lays out rows under a header: columns as wide as their widest cell, text to
/// the left, numbers to the right. Cells missing at the end of a row are empty.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let columns = header.len();
    let cell = |row: &[String], c: usize| row.get(c).cloned().unwrap_or_default();
    let width = |c: usize| {
        let cells = rows.iter().map(|row| cell(row, c).chars().count());
        cells.chain([header[c].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let numeric: Vec<bool> =
        (0..columns).map(|c| rows.iter().all(|row| is_number(&cell(row, c)))).collect();
    let line = |cell: &dyn Fn(usize) -> String| {
        let padded = (0..columns).map(|c| {
            let (text, width) = (cell(c), widths[c]);
            if numeric[c] { format!("{text:>width$}") } else { format!("{text:<width$}") }
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    let mut out = line(&|c| header[c].to_owned());
    out += &line(&|c| "-".repeat(widths[c]));
    for row in rows {
        out += &line(&|c| cell(row, c));
    }
    out
}

/// Numbers, numbers with a unit or sign after a blank, and blanks for none.
fn is_number(cell: &str) -> bool {
    let first = cell.split_whitespace().next().unwrap_or("-");
    first == "-" || first.trim_end_matches('%').parse::<f64>().is_ok()
}
