//! What differs between two scenes, key by key.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::input::InputError;

/// A key with another value in each of two scenes, or which only one of them has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Where it stands: `["fluid", "viscosity"]`, `["stage", "load", "walls", "y_max", "stress"]`.
    pub path: Vec<String>,
    /// Its value in the first scene, as TOML; `None` where it is absent.
    pub before: Option<String>,
    /// Its value in the second scene.
    pub now: Option<String>,
}

/// Tables that a scene may have several of, without names.
const LISTED: [&str; 3] = ["material", "motion", "pair"];

impl Difference {
    /// Whether it stands at these keys or below them.
    pub fn is_in(&self, keys: &[&str]) -> bool {
        self.path.len() >= keys.len() && self.path.iter().zip(keys).all(|(a, b)| a == b)
    }

    /// Whether it is that of `max_velocity` in `[walls]`, which a stage without a value of its own
    /// has taken over.
    pub(crate) fn is_inherited(&self, all: &[Difference]) -> bool {
        const KEY: &str = "max_velocity";
        let Some(default) = all.iter().find(|d| d.path == ["walls", KEY]) else { return false };
        // A servo's table stands as a whole where it has gained or lost the key.
        let without = |text: &Option<String>, value: &Option<String>| match (text, value) {
            (Some(text), Some(value)) => Some(text.replace(&format!(", {KEY} = {value}"), "")),
            (text, _) => text.clone(),
        };
        let (before, now) = (&self.before, &self.now);
        match &self.path[..] {
            [stage, _, .., key] if stage == "stage" && key == KEY => {
                (before, now) == (&default.before, &default.now)
            }
            [stage, _, walls, _] if stage == "stage" && walls == "walls" => {
                before.is_some() && without(before, &default.before) == without(now, &default.now)
            }
            _ => false,
        }
    }

    /// Name of the key in messages: `` `viscosity` in [fluid] ``.
    pub fn name(&self) -> String {
        match &self.path[..] {
            [stage, name] if stage == "stage" => format!("stage \"{name}\""),
            [stage, name, keys @ ..] if stage == "stage" => {
                format!("`{}` in stage \"{name}\"", keys.join("."))
            }
            [table, place] if LISTED.contains(&table.as_str()) => format!("[[{table}]] {place}"),
            [table, place, keys @ ..] if LISTED.contains(&table.as_str()) => {
                format!("`{}` in [[{table}]] {place}", keys.join("."))
            }
            [table, keys @ ..] if !keys.is_empty() => {
                format!("`{}` in [{table}]", keys.join("."))
            }
            [stage] if stage == "stage" => "the order of stages".to_owned(),
            [key] if ["title", "seed"].contains(&key.as_str()) => format!("`{key}`"),
            path => format!("[{}]", path.join(".")),
        }
    }
}

/// The keys that differ between two scenes as [`Plan::to_toml`](super::Plan::to_toml) writes
/// them, in alphabetical order. Stages are told apart by their names.
///
/// ```
/// use dempfv::scene::{Plan, differences};
/// let plan = Plan::default();
/// let other = Plan { seed: 2, ..Plan::default() };
/// let found = differences(&plan.to_toml(), &other.to_toml())?;
/// assert_eq!((found[0].name().as_str(), found.len()), ("`seed`", 1));
/// assert_eq!((found[0].before.as_deref(), found[0].now.as_deref()), (Some("1"), Some("2")));
/// # Ok::<(), dempfv::InputError>(())
/// ```
///
/// # Errors
/// One of the texts is no TOML.
pub fn differences(before: &str, now: &str) -> Result<Vec<Difference>, InputError> {
    let (first, second) = (parse(before)?, parse(now)?);
    let mut comparison = Comparison { texts: [before, now], path: vec![], found: vec![] };
    comparison.tables(first.get_ref(), second.get_ref());
    Ok(comparison.found)
}

/// Names of the stages of a scene as [`Plan::to_toml`](super::Plan::to_toml) writes it, in their
/// order.
///
/// # Errors
/// The text is no TOML.
pub(crate) fn stage_names(scene: &str) -> Result<Vec<String>, InputError> {
    let scene = parse(scene)?;
    let stages = items(scene.get_ref().get("stage"));
    Ok(stages.iter().filter_map(stage_name).map(str::to_owned).collect())
}

fn parse(text: &str) -> Result<Spanned<DeTable<'_>>, InputError> {
    DeTable::parse(text).map_err(|e| {
        InputError::new(format!("a scene is not TOML: {}", e.message()), "give a scene file")
    })
}

/// A value, where its key is there.
type Found<'v, 'a> = Option<&'v Spanned<DeValue<'a>>>;

struct Comparison<'t> {
    texts: [&'t str; 2],
    path: Vec<String>,
    found: Vec<Difference>,
}

impl Comparison<'_> {
    fn tables(&mut self, first: &DeTable, second: &DeTable) {
        for key in keys(first, second) {
            self.at(key, first.get(key), second.get(key));
        }
    }

    fn at(&mut self, key: &str, first: Found, second: Found) {
        self.path.push(key.to_owned());
        if self.path == ["stage"] {
            self.stages(first, second);
        } else if LISTED.contains(&key) && self.path.len() == 1 {
            self.listed(items(first), items(second));
        } else {
            self.values(first, second);
        }
        self.path.pop();
    }

    fn values(&mut self, first: Found, second: Found) {
        let none = DeTable::new();
        // Walls that a stage does not name stand still: each is told by itself.
        let absent =
            (self.path.len() > 2 && self.path.ends_with(&["walls".to_owned()])).then_some(&none);
        match (first.map_or(absent, table), second.map_or(absent, table)) {
            (Some(first), Some(second)) if !self.is_one_choice(first, second) => {
                self.tables(first, second);
            }
            _ => {
                let (before, now) = (self.text(0, first), self.text(1, second));
                if before != now {
                    self.found.push(Difference { path: self.path.clone(), before, now });
                }
            }
        }
    }

    /// A wall's control with other keys is another one as a whole.
    fn is_one_choice(&self, first: &DeTable, second: &DeTable) -> bool {
        let in_walls = self.path.len() > 2 && self.path[self.path.len() - 2] == "walls";
        in_walls && !first.keys().eq(second.keys())
    }

    /// Tables of an array, told apart by their places.
    fn listed(&mut self, first: &[Spanned<DeValue>], second: &[Spanned<DeValue>]) {
        for place in 0..first.len().max(second.len()) {
            self.path.push((place + 1).to_string());
            self.values(first.get(place), second.get(place));
            self.path.pop();
        }
    }

    fn stages(&mut self, first: Found, second: Found) {
        let (first, second) = (items(first), items(second));
        let (before, now) = (order(first, second), order(second, first));
        if before != now {
            let (before, now) = (Some(before), Some(now));
            self.found.push(Difference { path: self.path.clone(), before, now });
        }
        for stage in first {
            let Some(name) = stage_name(stage) else { continue };
            self.at(name, Some(stage), stage_named(second, name));
        }
        for stage in second {
            let Some(name) = stage_name(stage) else { continue };
            if stage_named(first, name).is_none() {
                self.at(name, None, Some(stage));
            }
        }
    }

    /// A value as its scene has it; of a table with a head of its own, in a word.
    fn text(&self, scene: usize, value: Found) -> Option<String> {
        let value = value?;
        let kind = table(value).and_then(|t| t.get("kind")?.get_ref().as_str());
        Some(match (self.path.len(), kind) {
            (1, _) if value.get_ref().is_table() => "given".to_owned(),
            (2, None) if LISTED.contains(&self.path[0].as_str()) => "given".to_owned(),
            (2, Some(kind)) => format!("a {kind} stage"),
            _ => self.texts[scene].get(value.span()).unwrap_or_default().to_owned(),
        })
    }
}

fn table<'v, 'a>(value: &'v Spanned<DeValue<'a>>) -> Option<&'v DeTable<'a>> {
    value.get_ref().as_table()
}

fn items<'v, 'a>(value: Found<'v, 'a>) -> &'v [Spanned<DeValue<'a>>] {
    value.and_then(|v| v.get_ref().as_array()).map_or(&[], |array| &array[..])
}

fn stage_named<'v, 'a>(stages: &'v [Spanned<DeValue<'a>>], name: &str) -> Found<'v, 'a> {
    stages.iter().find(|stage| stage_name(stage) == Some(name))
}

/// Names of the stages that others have too, in their order.
fn order(stages: &[Spanned<DeValue>], others: &[Spanned<DeValue>]) -> String {
    let names = stages.iter().filter_map(stage_name);
    names.filter(|name| stage_named(others, name).is_some()).collect::<Vec<_>>().join(", ")
}

/// The keys of either table, each once.
fn keys<'v>(first: &'v DeTable, second: &'v DeTable) -> Vec<&'v str> {
    let mut keys: Vec<&str> =
        first.keys().chain(second.keys()).map(|key| key.get_ref().as_ref()).collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}

fn stage_name<'v>(stage: &'v Spanned<DeValue>) -> Option<&'v str> {
    table(stage)?.get("name")?.get_ref().as_str()
}

#[cfg(test)]
mod tests {
    use super::differences;

    const SCENE: &str = r#"
        title = "a"
        [fluid]
        viscosity = 1.0
        pressure = { y_max = 0.0 }
        [[stage]]
        kind = "run"
        name = "load"
        steps = 10
        walls = { y_max = { stress = 1.0, max_velocity = 2.0 }, x_min = { velocity = 0.5 } }
        [[stage]]
        kind = "cycle"
        name = "b"
    "#;

    #[test]
    fn each_key_is_told_with_both_values() {
        assert_eq!(differences(SCENE, SCENE).unwrap(), []);
        for (old, new, expected) in [
            ("viscosity = 1.0", "viscosity = 2.0", "`viscosity` in [fluid]: 1.0 -> 2.0"),
            (
                "y_max = 0.0",
                "x_min = 3.0",
                "`pressure.x_min` in [fluid]: - -> 3.0, `pressure.y_max` in [fluid]: 0.0 -> -",
            ),
            ("\"a\"", "\"b\"", "`title`: \"a\" -> \"b\""),
            (
                "steps = 10",
                "time = 0.5",
                "`steps` in stage \"load\": 10 -> -, `time` in stage \"load\": - -> 0.5",
            ),
            ("stress = 1.0", "stress = 3.0", "`walls.y_max.stress` in stage \"load\": 1.0 -> 3.0"),
            (
                "{ velocity = 0.5 }",
                "{ stress = 1.0 }",
                "`walls.x_min` in stage \"load\": { velocity = 0.5 } -> { stress = 1.0 }",
            ),
            (
                ", x_min = { velocity = 0.5 }",
                "",
                "`walls.x_min` in stage \"load\": { velocity = 0.5 } -> -",
            ),
            (
                "name = \"b\"",
                "name = \"c\"",
                "stage \"b\": a cycle stage -> -, stage \"c\": - -> a cycle stage",
            ),
            (
                "[fluid]\n        viscosity = 1.0\n        pressure = { y_max = 0.0 }",
                "",
                "[fluid]: given -> -",
            ),
        ] {
            let found = differences(SCENE, &SCENE.replacen(old, new, 1)).unwrap();
            let or_none = |value: &Option<String>| value.clone().unwrap_or_else(|| "-".to_owned());
            let told: Vec<String> = found
                .iter()
                .map(|d| format!("{}: {} -> {}", d.name(), or_none(&d.before), or_none(&d.now)))
                .collect();
            assert_eq!(told.join(", "), expected, "{old} -> {new}");
        }
        let first = "[[stage]]\nkind = \"run\"\nname = \"a\"\n";
        let second = "[[stage]]\nkind = \"run\"\nname = \"b\"\n";
        let found = differences(&format!("{first}{second}"), &format!("{second}{first}")).unwrap();
        assert_eq!((found.len(), found[0].name().as_str()), (1, "the order of stages"));
        assert_eq!(found[0].now.as_deref(), Some("b, a"));
    }
}
