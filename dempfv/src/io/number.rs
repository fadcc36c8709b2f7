//! Numbers in text files.

use crate::excerpt::excerpt;
use crate::input::InputError;

/// A finite number; Fortran writes exponents with D.
///
/// # Errors
/// It is none; `form` says what would be right.
pub(super) fn number(word: &str, form: &str) -> Result<f64, InputError> {
    let fortran = || word.replace(['d', 'D'], "e").parse();
    match word.parse::<f64>().or_else(|_| fortran()) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(InputError::new(format!("`{}` is not a finite number", excerpt(word)), form)),
        Err(_) if word.contains(['\u{2212}', '\u{2013}']) => {
            let what = format!("`{}` is not a number: its minus sign is another", excerpt(word));
            Err(InputError::new(what, "write -, as in -1.5"))
        }
        Err(_) => Err(InputError::new(format!("`{}` is not a number", excerpt(word)), form)),
    }
}
