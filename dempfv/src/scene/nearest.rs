//! Which known name did the user mean?

/// Number of single edits (insert, delete, replace, swap of neighbours) from one word to
/// another (optimal string alignment distance).
fn edits(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().collect();
    let b: Vec<char> = b.chars().collect();
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let replace = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replace.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = last;
        last = row;
    }
    last[b.len()]
}

/// The known name nearest to `word`, if one is near enough to be a slip of the keys: at
/// most one edit for every three letters, rounded up.
pub(super) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let reach = word.chars().count().div_ceil(3);
    known
        .iter()
        .map(|k| (edits(&word, k), *k))
        .filter(|(distance, _)| *distance <= reach)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, k)| k)
}

/// The second half of a message about an unknown name: the nearest one, or all of them.
pub(super) fn suggestion(word: &str, known: &[&str]) -> String {
    match nearest(word, known) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("known: {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_count_swaps_as_one() {
        assert_eq!(edits("viscosity", "viscosity"), 0);
        assert_eq!(edits("viscocity", "viscosity"), 1);
        assert_eq!(edits("sterss", "stress"), 1);
        assert_eq!(edits("", "dt"), 2);
        assert_eq!(edits("kitten", "sitting"), 3);
    }

    #[test]
    fn only_near_names_are_suggested() {
        let known = ["dt", "damping", "gravity"];
        assert_eq!(nearest("dampnig", &known), Some("damping"));
        assert_eq!(nearest("Gravity", &known), Some("gravity"));
        assert_eq!(nearest("mu", &known), None);
        assert_eq!(suggestion("mu", &known), "known: dt, damping, gravity");
    }
}
