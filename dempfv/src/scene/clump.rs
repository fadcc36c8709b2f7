//! `clump` in `[particles]`: the shape that takes the place of each sphere of a cloud.

use super::kind::Kind;
use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::dem::ClumpTemplate;
use crate::domain::Vec3;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

/// Members of a clump, in units of its sphere's radius.
pub(super) struct Members;

const FORM: &str = "an array of members [x, y, z, r] in units of the sphere's radius";

impl Kind<ClumpTemplate> for Members {
    fn read(&self, value: &Value) -> Result<ClumpTemplate> {
        let member = |item: &Value| match item.items(FORM)?.as_slice() {
            [x, y, z, r] => {
                let read = |v: &Value| v.number("sphere radii", Bound::Finite);
                let radius = r.number("sphere radii", Bound::Positive)?;
                Ok((Vec3::new(read(x)?, read(y)?, read(z)?), radius))
            }
            other => Err(item.error(
                &format!("has a member of {} numbers", other.len()),
                "give [x, y, z, r], as in [[0.5, 0, 0, 0.5], [-0.5, 0, 0, 0.5]]",
            )),
        };
        let members = value.items(FORM)?.iter().map(member).collect::<Result<_>>()?;
        let template = ClumpTemplate { members };
        self.wrong(&template).map_or(Ok(template), |wrong| Err(value.wrong(wrong)))
    }

    fn wrong(&self, template: &ClumpTemplate) -> Option<Wrong> {
        template.problem().map(|problem| {
            Wrong::new(problem, "as in [[0.5, 0, 0, 0.5], [-0.5, 0, 0, 0.5]], a dumb-bell")
        })
    }

    fn write(&self, template: &ClumpTemplate) -> Option<String> {
        let member = |(x, r): &(Vec3, f64)| format!("[{:?}, {:?}, {:?}, {r:?}]", x.x, x.y, x.z);
        let all: Vec<String> = template.members.iter().map(member).collect();
        Some(format!("[{}]", all.join(", ")))
    }
}
