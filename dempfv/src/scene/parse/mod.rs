//! TOML text to [`Plan`].

mod setup;
mod stages;

use std::path::Path;

use toml::de::DeTable;

use super::keys;
use super::plan::Plan;
use super::rules;
use super::table::{Source, Table};
use crate::error::Error;
use crate::input::InputError;

impl Plan {
    /// Reads a scene.
    ///
    /// `file` is named in errors, and a relative packing path is taken from its folder.
    /// The packing file must exist, but is not read.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and what would be right.
    ///
    /// ```
    /// let plan = dempfv::scene::Plan::from_toml(r#"
    ///     [box]
    ///     min = [0, 0, 0]
    ///     max = [1, 1, 1]
    ///     [particles]
    ///     cloud = { count = 100, porosity = 0.9 }
    ///     [dem]
    ///     [[stage]]
    ///     kind = "compact"
    ///     stress = 1e4
    /// "#, None).unwrap();
    /// assert!(plan.fluid.is_none());
    ///
    /// let error = dempfv::scene::Plan::from_toml("sede = 1", None).unwrap_err();
    /// assert_eq!(error.line, Some(1));
    /// assert_eq!(error.remedy, "did you mean `seed`?");
    /// ```
    pub fn from_toml(text: &str, file: Option<&Path>) -> Result<Plan, InputError> {
        let source = Source { text, file };
        let document = DeTable::parse(text).map_err(|e| {
            let at = e.span().map_or(0, |s| s.start);
            source.error(
                at,
                format!("not TOML: {}", e.message()),
                "correct the syntax of this line",
            )
        })?;
        let root = Table::new(&source, &keys::ROOT, document.get_ref(), 0)?;
        let plan = setup::read(&root)?;
        rules::check(&plan, &root)?;
        Ok(plan)
    }

    /// Reads a scene file; see [`Plan::from_toml`].
    ///
    /// # Errors
    /// [`Error::Input`] when the file is not there or cannot be read, or something in it is
    /// wrong.
    pub fn load(path: impl AsRef<Path>) -> Result<Plan, Error> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| {
            InputError::new(format!("cannot read the scene: {e}"), "name a scene file in TOML")
                .in_file(path)
        })?;
        Ok(Plan::from_toml(&text, Some(path))?)
    }
}
