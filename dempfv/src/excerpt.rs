//! Pieces of a user's files, as messages quote them.

use std::fmt;

/// Characters of a file that a message quotes at most.
const LENGTH: usize = 40;

/// A number as messages quote it: with an exponent where it has too many digits to be read.
pub(crate) struct Brief(pub f64);

/// Characters of a number that is written out.
const DIGITS: usize = 20;

impl fmt::Display for Brief {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = self.0.to_string();
        if plain.len() <= DIGITS { f.write_str(&plain) } else { write!(f, "{:e}", self.0) }
    }
}

/// A short piece of a text: its first characters, without any that a terminal would obey.
pub(crate) fn excerpt(text: &str) -> String {
    let mut characters = text.chars();
    let piece: String = characters.by_ref().take(LENGTH).collect();
    let end = if characters.next().is_some() { "…" } else { "" };
    harmless(&piece) + end
}

/// The text with control characters, and those that change the direction or hide, as escapes.
pub(crate) fn harmless(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}' => shown.extend(c.escape_unicode()),
            c if c.is_control() => shown.extend(c.escape_default()),
            c => shown.push(c),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::{Brief, excerpt, harmless};

    #[test]
    fn numbers_of_300_digits_are_not_written_out() {
        let shown = [1e300, -1e-300, 0.1 + 0.2, 1e6, f64::NAN].map(|x| Brief(x).to_string());
        assert_eq!(shown, ["1e300", "-1e-300", "0.30000000000000004", "1000000", "NaN"]);
    }

    #[test]
    fn nothing_is_left_for_a_terminal_to_obey() {
        assert_eq!(harmless("a\u{1b}[2J\n\u{9b}5m µ"), "a\\u{1b}[2J\\n\\u{9b}5m µ");
        assert_eq!(harmless("\u{202e}txt\u{feff}"), "\\u{202e}txt\\u{feff}");
        assert_eq!(excerpt("1.5x"), "1.5x");
        assert_eq!(excerpt(&"\0".repeat(1000)), "\\u{0}".repeat(40) + "…");
    }
}
