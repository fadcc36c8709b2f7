//! Keys of `[fluid]` for forces between neighbours.

use super::keys::Keys;
use super::kind::{Flag, Maybe, number};
use super::table::Bound;
use super::wrong::Wrong;
use crate::Effect;
use crate::coupling::EdgeEffects;
use crate::coupling::effects::{
    NORMAL_LUBRICATION, PUMP_TORQUE, SHEAR_LUBRICATION, TWIST_TORQUE, VISCOUS_SHEAR,
};
use crate::input::InputError;

/// Passes over the keys.
pub(super) fn keys(keys: &mut Keys, edges: &mut EdgeEffects) -> Result<(), InputError> {
    keys.take("viscous_shear", &Flag, &mut edges.viscous_shear)?;
    keys.take("normal_lubrication", &Flag, &mut edges.normal_lubrication)?;
    keys.take("shear_lubrication", &Flag, &mut edges.shear_lubrication)?;
    keys.take("pump_torque", &Flag, &mut edges.pump_torque)?;
    keys.take("twist_torque", &Flag, &mut edges.twist_torque)?;
    if edges.lubricates() {
        keys.take("eps", &number("", Bound::BelowOne), &mut edges.roughness)?;
    } else {
        unused(
            keys,
            "eps",
            "nothing is lubricated",
            "add `normal_lubrication = true`, or another",
        )?;
    }
    let smooth = edges.needs_roughness() && edges.roughness == 0.0;
    keys.rule("eps", smooth.then(|| Wrong::new(SMOOTH, "give a roughness above 0, as 1e-3")))?;
    if edges.normal_lubrication {
        let modulus = Maybe(number("Pa", Bound::Positive));
        keys.take("lubrication_stiffness", &modulus, &mut edges.stiffness)
    } else {
        let what = "no film is squeezed";
        unused(keys, "lubrication_stiffness", what, "add `normal_lubrication = true`")
    }
}

const SMOOTH: &str = "is 0, but `shear_lubrication` and `pump_torque` resist smooth surfaces that touch \
                      without bound";

/// Refuses a key that nothing uses.
fn unused(keys: &Keys, key: &str, why: &str, remedy: &str) -> Result<(), InputError> {
    let Keys::Read(table) = keys else { return Ok(()) };
    match table.get(key) {
        Some(value) => {
            let remedy = format!("{remedy}, or leave it out");
            Err(value.error(&format!("is given, but {why}"), remedy))
        }
        None => Ok(()),
    }
}

/// What is wrong with forces between neighbours where no stage couples fluid and spheres, or where
/// these do not turn.
pub(super) fn wrong_in(edges: &EdgeEffects, is_coupled: bool, turns: bool) -> Option<Wrong> {
    let on = [
        ("viscous_shear", edges.viscous_shear, false),
        ("normal_lubrication", edges.normal_lubrication, false),
        ("shear_lubrication", edges.shear_lubrication, false),
        ("pump_torque", edges.pump_torque, true),
        ("twist_torque", edges.twist_torque, true),
    ];
    let (key, _, is_torque) = on.into_iter().find(|(_, on, torque)| {
        let useless = !is_coupled || (*torque && !turns);
        *on && useless
    })?;
    Some(if is_torque && is_coupled {
        let problem = format!("has `{key}`, but with `rotation = false` in [dem] no sphere turns");
        Wrong::new(problem, "let spheres rotate, or leave it out")
    } else {
        let problem = format!("has `{key}`, but no stage couples the fluid to spheres that move");
        Wrong::new(problem, "add a run stage with [dem], or leave it out")
    })
}

/// The effects of these keys, and whether a coupled fluid has them.
pub(super) fn described(edges: Option<&EdgeEffects>) -> [(&'static Effect, bool); 5] {
    let is = |holds: fn(&EdgeEffects) -> bool| edges.is_some_and(holds);
    [
        (&VISCOUS_SHEAR, is(|e| e.viscous_shear)),
        (&NORMAL_LUBRICATION, is(|e| e.normal_lubrication)),
        (&SHEAR_LUBRICATION, is(|e| e.shear_lubrication)),
        (&PUMP_TORQUE, is(|e| e.pump_torque)),
        (&TWIST_TORQUE, is(|e| e.twist_torque)),
    ]
}
