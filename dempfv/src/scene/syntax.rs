//! What a user meant who wrote what is no TOML.

/// What would be right instead of the line that holds a byte of the text.
pub(super) fn remedy(text: &str, at: usize) -> String {
    let before = text.as_bytes()[..at.min(text.len())].iter();
    let line = text.lines().nth(before.filter(|&&b| b == b'\n').count()).unwrap_or("");
    let value = line.split_once('=').map_or("", |(_, value)| value);
    let words = words(value);
    let found = |what: fn(&str) -> Option<String>| words.iter().find_map(|word| what(word));
    decimal_comma(without_comment(value))
        .or_else(|| found(number))
        .or_else(|| found(unit))
        .or_else(|| found(truth))
        .or_else(|| path(without_comment(value)))
        .or_else(|| found(text_without_quotes))
        .unwrap_or_else(|| "correct the syntax of this line".to_owned())
}

/// What stands in a value outside of quotes: numbers, names, but for those that are keys, up to
/// a comment.
fn words(value: &str) -> Vec<&str> {
    // Every other piece is inside of quotes.
    let plain = value.split('"').step_by(2);
    let plain = plain.flat_map(|piece| piece.split('#').next());
    let words = plain.flat_map(|piece| piece.split([',', '[', ']', '{', '}']));
    words.map(|word| word.rsplit('=').next().unwrap_or(word).trim()).collect()
}

fn without_comment(value: &str) -> &str {
    value.split('#').next().unwrap_or(value).trim()
}

/// A number that TOML wants written in another way: digits stand on both sides of a point,
/// none but a lone 0 comes first, a minus sign is that of the keyboard.
fn number(word: &str) -> Option<String> {
    let plain = plain(word);
    let number = finite(&plain)?;
    let digits = plain.trim_start_matches(['+', '-']);
    let odd = plain != word
        || digits.starts_with('.')
        || digits.ends_with('.')
        || digits.contains(".e")
        || digits.contains(".E")
        || digits.len() > 1 && digits.starts_with('0') && !digits.starts_with("0.");
    odd.then(|| format!("write the number as {number:?}"))
}

/// A number as this program reads it: the exponents of Fortran, the minus signs of typesetters.
fn plain(word: &str) -> String {
    word.replace(['d', 'D'], "e").replace(['\u{2212}', '\u{2013}'], "-")
}

fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|x: &f64| x.is_finite())
}

/// A number with a unit behind it.
fn unit(word: &str) -> Option<String> {
    let (_, unit) = number_and_unit(word)?;
    Some(format!("write the number without `{unit}`: {UNITS}"))
}

/// What numbers are in.
const UNITS: &str = "it is in the SI unit of its key, an angle in degrees";

/// The number that a word begins with, and the unit that it ends with.
fn number_and_unit(word: &str) -> Option<(f64, &str)> {
    let is_unit = |end: &str| {
        end.starts_with(|c: char| c.is_alphabetic() || "%°".contains(c))
            && end.chars().all(|c| c.is_alphanumeric() || "%°/^*·-⁻²³ ".contains(c))
            && !end.starts_with(['e', 'E'])
    };
    let cuts = word.char_indices().map(|(at, _)| word.split_at(at)).rev();
    cuts.map(|(number, unit)| (finite(&plain(number.trim_end())), unit))
        .find_map(|(number, unit)| Some((number?, unit)).filter(|_| is_unit(unit)))
}

/// What would be right instead of a text that should be a number; `None` where it is none.
pub(super) fn number_in_quotes(text: &str) -> Option<String> {
    match (finite(&plain(text.trim())), number_and_unit(text.trim())) {
        (Some(number), _) => Some(format!("without quotes: {number:?}")),
        (None, Some((_, unit))) => Some(format!("without quotes and without `{unit}`: {UNITS}")),
        (None, None) => None,
    }
}

/// A number with a comma for its point, or between thousands.
fn decimal_comma(value: &str) -> Option<String> {
    let digits = value.trim_start_matches(['+', '-']);
    let is_number = digits.contains(',')
        && digits.split(',').all(|part| {
            part.starts_with(|c: char| c.is_ascii_digit())
                && part.replace(['e', 'E', '.', '-', '+'], "").chars().all(|c| c.is_ascii_digit())
        });
    is_number.then(|| "write the number with a point and without commas, as in 0.5".to_owned())
}

/// True and false are written small.
fn truth(word: &str) -> Option<String> {
    let small = word.to_ascii_lowercase();
    let meant = ["true", "false"].contains(&small.as_str()) && small != word;
    meant.then(|| format!("write {small}"))
}

/// A text that lacks its quotes: the whole value.
fn path(value: &str) -> Option<String> {
    let mut letters = value.chars();
    let is_text = letters.next().is_some_and(|c| c.is_alphabetic() || "./~".contains(c))
        && letters.all(|c| c.is_alphanumeric() || "./~_- ".contains(c))
        && value.chars().any(char::is_alphabetic)
        && !is_keyword(value);
    is_text.then(|| format!("put the text in quotes: \"{value}\""))
}

/// A text that lacks its quotes: a name in an array or a table.
fn text_without_quotes(word: &str) -> Option<String> {
    path(word).filter(|_| !word.contains(' '))
}

fn is_keyword(word: &str) -> bool {
    ["true", "false", "inf", "nan"].contains(&word)
}

#[cfg(test)]
mod tests {
    use super::{number_in_quotes, remedy};

    const UNIT_S: &str =
        "write the number without `s`: it is in the SI unit of its key, an angle in degrees";

    #[test]
    fn what_was_meant_is_said() {
        for (line, expected) in [
            ("viscosity = .001  # water", "write the number as 0.001"),
            ("x = -.5", "write the number as -0.5"),
            ("x = +.5", "write the number as 0.5"),
            ("x = 1.", "write the number as 1.0"),
            ("x = 1.e3", "write the number as 1000.0"),
            ("x = 1.5d-3", "write the number as 0.0015"),
            ("x = 1d-3", "write the number as 0.001"),
            ("x = 007", "write the number as 7.0"),
            ("pressure = { y_max = .5 }", "write the number as 0.5"),
            ("gravity = [0, 0, -9.]", "write the number as -9.0"),
            ("gravity = [0, 0, −9.81]", "write the number as -9.81"),
            ("x = 1e–5", "write the number as 1e-5"),
            ("dt = 1e-5s", UNIT_S),
            ("dt = 1e-5 s  # short", UNIT_S),
            ("dt = −1e-5s", UNIT_S),
            ("x = 0,001", "write the number with a point and without commas, as in 0.5"),
            ("x = True", "write true"),
            ("packing = ../a.txt", "put the text in quotes: \"../a.txt\""),
            ("packing = my file.txt", "put the text in quotes: \"my file.txt\""),
            ("kind = compact", "put the text in quotes: \"compact\""),
            ("no_flow = [\"x_min\", x_max]", "put the text in quotes: \"x_max\""),
            ("walls = { y_max = fixed }", "put the text in quotes: \"fixed\""),
            ("seed = ", "correct the syntax of this line"),
            ("[fluid", "correct the syntax of this line"),
            ("min = [0, 0", "correct the syntax of this line"),
        ] {
            assert_eq!(remedy(&format!("a = 1\n{line}\nb = 2"), 8), expected, "{line}");
        }
    }

    #[test]
    fn numbers_in_quotes_are_numbers() {
        for (text, expected) in [
            ("1e-5", "without quotes: 1e-5"),
            (" −3 ", "without quotes: -3.0"),
            ("5 kPa", "without quotes and without `kPa`: "),
            ("9.81 m/s²", "without quotes and without `m/s²`: "),
        ] {
            let remedy = number_in_quotes(text).unwrap();
            assert!(remedy.starts_with(expected), "{text}: {remedy}");
        }
        for text in ["auto", "fixed", "", "inf", "nan", "a1", "1e", "2/3", "1 2"] {
            assert_eq!(number_in_quotes(text), None, "{text}");
        }
    }
}
