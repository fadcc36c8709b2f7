//! Where the numbers of a sphere stand in a line: the forms in which programs write packings.

use super::number::number;
use crate::excerpt::excerpt;
use crate::input::InputError;

/// How to write a line, in words.
pub(super) const LINE_FORM: &str = "a line is `x y z r` in metres, separated by blanks";
const NAMES: &str = "name the columns x, y, z and radius (or r, diameter, d)";

/// Columns of x, y, z and the size.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    column: [usize; 4],
    /// Radius per size.
    factor: f64,
    columns: Columns,
}

/// How many columns a line has.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Columns {
    Exactly(usize),
    /// Attributes follow.
    AtLeast(usize),
}

impl Layout {
    /// `x y z r`.
    const PLAIN: Layout =
        Layout { column: [0, 1, 2, 3], factor: 1.0, columns: Columns::Exactly(4) };

    /// The layout that a header names: column names of a table, or of a LAMMPS dump.
    ///
    /// # Errors
    /// A coordinate or the size is missing.
    pub fn named(names: &[&str]) -> Result<Layout, InputError> {
        let names: Vec<String> =
            names.iter().map(|name| name.trim().to_ascii_lowercase()).collect();
        let find = |wanted: &[&str]| names.iter().position(|n| wanted.contains(&n.as_str()));
        let size = find(&["radius", "r"]).map(|k| (k, 1.0));
        let size = size.or_else(|| find(&["diameter", "d"]).map(|k| (k, 0.5)));
        let (Some(x), Some(y), Some(z), Some((r, factor))) =
            (find(&["x", "xu"]), find(&["y", "yu"]), find(&["z", "zu"]), size)
        else {
            let names = excerpt(&names.join(" "));
            let what = format!("the columns `{names}` have no x, y, z and radius");
            return Err(InputError::new(what, NAMES));
        };
        Ok(Layout { column: [x, y, z, r], factor, columns: Columns::Exactly(names.len()) })
    }

    /// The layout that YADE names in a comment, `#format x_y_z_r...`: attributes follow the four.
    pub fn of_format(format: &str) -> Option<Layout> {
        let rest = format.strip_prefix("x_y_z_r")?;
        let columns = if rest.is_empty() { Columns::Exactly(4) } else { Columns::AtLeast(4) };
        Some(Layout { columns, ..Layout::PLAIN })
    }

    /// The layout of a file without a header, from its first line: `x y z r`, with a whole number
    /// after it (a clump's or a material's, as YADE's `SpherePack.save` writes), or
    /// `number Sphere x y z r` (Woo).
    pub fn of_line(words: &[&str]) -> Layout {
        match words {
            [_, "Sphere", ..] => {
                Layout { column: [2, 3, 4, 5], columns: Columns::Exactly(6), ..Layout::PLAIN }
            }
            [_, _, _, _, last] if last.parse::<i64>().is_ok() => {
                Layout { columns: Columns::Exactly(5), ..Layout::PLAIN }
            }
            _ => Layout::PLAIN,
        }
    }

    /// Centre and radius (m).
    ///
    /// # Errors
    /// Another number of columns, or a word that is no number.
    pub fn read(&self, words: &[&str]) -> Result<[f64; 4], InputError> {
        let fits = match self.columns {
            Columns::Exactly(n) => words.len() == n,
            Columns::AtLeast(n) => words.len() >= n,
        };
        if !fits {
            let (Columns::Exactly(n) | Columns::AtLeast(n)) = self.columns;
            let what = format!("{} columns where {n} are due", words.len());
            return Err(InputError::new(what, LINE_FORM));
        }
        let mut values = [0.0; 4];
        for (value, &column) in values.iter_mut().zip(&self.column) {
            *value = number(words[column], LINE_FORM)?;
        }
        values[3] *= self.factor;
        Ok(values)
    }
}

/// The words of a line, separated by blanks, commas or semicolons.
pub(super) fn words(line: &str) -> Vec<&str> {
    match line.contains([',', ';']) {
        true => line.split([',', ';']).map(str::trim).collect(),
        false => line.split_whitespace().collect(),
    }
}

/// True for a line of column names: no word is a number.
pub(super) fn is_header(words: &[&str]) -> bool {
    words.len() >= 4 && words.iter().all(|word| number(word, "").is_err())
}
