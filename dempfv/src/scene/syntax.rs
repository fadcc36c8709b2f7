//! What a user meant who wrote what is no TOML.

/// What would be right instead of the line that holds a byte of the text.
pub(super) fn remedy(text: &str, at: usize) -> String {
    let before = text.as_bytes()[..at.min(text.len())].iter();
    let line = text.lines().nth(before.filter(|&&b| b == b'\n').count()).unwrap_or("");
    let value = line.split_once('=').map_or("", |(_, value)| value);
    let value = value.split_once('#').map_or(value, |(value, _)| value).trim();
    number(value)
        .map(|right| format!("write the number as {right}"))
        .or_else(|| {
            text_without_quotes(value).then(|| format!("put the text in quotes: \"{value}\""))
        })
        .unwrap_or_else(|| "correct the syntax of this line".to_owned())
}

/// A number that TOML wants written in another way: digits stand on both sides of a point,
/// none but a lone 0 comes first.
fn number(value: &str) -> Option<String> {
    let plain = value.replace(['d', 'D'], "e");
    let number: f64 = plain.parse().ok().filter(|x: &f64| x.is_finite())?;
    let digits = plain.trim_start_matches(['+', '-']);
    let odd = plain != value
        || digits.starts_with('.')
        || digits.ends_with('.')
        || digits.contains(".e")
        || digits.contains(".E")
        || digits.len() > 1 && digits.starts_with('0') && !digits.starts_with("0.");
    odd.then(|| format!("{number:?}"))
}

/// Whether a text stands there that lacks its quotes.
fn text_without_quotes(value: &str) -> bool {
    let mut letters = value.chars();
    letters.next().is_some_and(|c| c.is_alphabetic() || "./~".contains(c))
        && letters.all(|c| c.is_alphanumeric() || "./~_- ".contains(c))
        && value.chars().any(char::is_alphabetic)
        && !["true", "false", "inf", "nan"].contains(&value)
}

#[cfg(test)]
mod tests {
    use super::remedy;

    #[test]
    fn what_was_meant_is_said() {
        for (line, expected) in [
            ("viscosity = .001  # water", "write the number as 0.001"),
            ("x = -.5", "write the number as -0.5"),
            ("x = 1.", "write the number as 1.0"),
            ("x = 1.e3", "write the number as 1000.0"),
            ("x = 1.5d-3", "write the number as 0.0015"),
            ("x = 007", "write the number as 7.0"),
            ("packing = ../a.txt", "put the text in quotes: \"../a.txt\""),
            ("kind = compact", "put the text in quotes: \"compact\""),
            ("seed = ", "correct the syntax of this line"),
            ("[fluid", "correct the syntax of this line"),
            ("min = [0, 0", "correct the syntax of this line"),
        ] {
            assert_eq!(remedy(&format!("a = 1\n{line}\nb = 2"), 8), expected, "{line}");
        }
    }
}
