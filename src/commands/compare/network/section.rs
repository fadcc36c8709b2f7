use std::path::Path;
use super::Part;
use crate::commands::Error;
pub fn section(_: &Part, _: &Path) -> Result<String, Error> { Ok(String::new()) }
