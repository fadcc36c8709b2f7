//! Contact laws of ours as LAMMPS has them.

use std::f64::consts::PI;

use super::job::{Contacts, Material, Turning};

/// The input of LAMMPS, up to its steps.
pub const SETUP: &str = include_str!("../../../peers/contacts.lmp");
/// Distance of spheres beyond contact that LAMMPS keeps in its lists, in mean radii.
const SKIN: f64 = 0.1;
/// Tangential over normal damping, as LAMMPS has it by default.
const ACROSS: f64 = 0.5;
pub const TURNING: Turning = Turning { friction: 0.1, stiffness_ratio: 0.5, damping_ratio: 0.3 };
pub const POISSON_RATIO: f64 = 0.25;

/// A combination of effects, and LAMMPS's styles for it.
pub struct Effects {
    pub name: &'static str,
    pub contacts: Contacts,
    pub styles: &'static str,
    /// Whether LAMMPS's constants can be those of ours where all spheres are equal.
    pub same: bool,
}

const PLAIN: Contacts = Contacts { poisson_ratio: None, rolling: None, twisting: None };

pub const EFFECTS: [Effects; 5] = [
    Effects {
        name: "friction, rotation",
        contacts: PLAIN,
        styles: "`gran/hooke/history`",
        same: true,
    },
    Effects {
        name: "Hertz and Mindlin",
        contacts: Contacts { poisson_ratio: Some(POISSON_RATIO), ..PLAIN },
        styles: "`granular`: `hertz/material`, `mindlin_rescale/force`",
        same: true,
    },
    Effects {
        name: "rolling resistance",
        contacts: Contacts { rolling: Some(TURNING), ..PLAIN },
        styles: "`granular`: `hooke`, `linear_history`, `rolling sds`",
        same: true,
    },
    Effects {
        name: "twisting resistance",
        contacts: Contacts { twisting: Some(TURNING), ..PLAIN },
        styles: "`granular`: `hooke`, `linear_history`, `twisting sds`",
        same: true,
    },
    Effects {
        name: "Hertz and Mindlin, rolling, twisting",
        contacts: Contacts {
            poisson_ratio: Some(POISSON_RATIO),
            rolling: Some(TURNING),
            twisting: Some(TURNING),
        },
        styles: "`granular`: `hertz/material`, `mindlin_rescale/force`, `rolling sds`, `twisting sds`",
        same: false,
    },
];

impl Effects {
    /// Its name in those of files.
    pub fn slug(&self) -> String {
        self.name.replace(", ", "-").replace(' ', "-").to_lowercase()
    }
}

/// A law of ours as LAMMPS has it: one set of constants for all pairs, that of two mean spheres.
pub struct Law {
    style: String,
    pair: String,
    wall: String,
    skin: f64,
    dt: f64,
}

impl Law {
    pub fn new(radius: &[f64], material: &Material, contacts: &Contacts) -> Law {
        let Material { young, stiffness_ratio, friction_angle, density, damping, dt } = *material;
        let mean = radius.iter().sum::<f64>() / radius.len().max(1) as f64;
        let stiffness = young * mean;
        let mass = density * 4.0 / 3.0 * PI * mean.powi(3);
        // Local damping takes as much of a cycle as this share of critical viscous damping.
        let gamma = 2.0 * damping / PI * (stiffness / (0.5 * mass)).sqrt();
        let (shear, friction) = (stiffness_ratio * stiffness, friction_angle.tan());
        let skin = SKIN * mean;
        if *contacts == Contacts::default() {
            let springs = format!("{stiffness} {shear} {gamma} NULL");
            let style = format!("gran/hooke/history {springs} {friction} 1");
            let wall = format!("hooke/history {springs} 0 0");
            return Law { style, pair: String::new(), wall, skin, dt };
        }
        let normal = |on_wall: bool| match contacts.poisson_ratio {
            // At a wall LAMMPS of 2021 takes E / 2(1 − ν), elsewhere E / 2(1 − ν²).
            Some(ratio) => {
                let young = if on_wall { young / (1.0 + ratio) } else { young };
                format!("hertz/material {young} {gamma} {ratio}")
            }
            None => format!("hooke {stiffness} {gamma}"),
        };
        let tangential = match contacts.poisson_ratio {
            Some(_) => format!("mindlin_rescale/force NULL {ACROSS} {friction}"),
            None => format!("linear_history {shear} {ACROSS} {friction}"),
        };
        let whole = |normal: &str, tangential: &str, mass: f64, arm: f64| {
            let turning = contacts.turning(stiffness, mass, arm);
            format!("{normal} tangential {tangential}{turning} damping mass_velocity")
        };
        let wall = whole(&normal(true), "linear_nohistory 0 0", mass, mean);
        Law {
            style: "granular".to_owned(),
            pair: whole(&normal(false), &tangential, 0.5 * mass, 0.5 * mean),
            wall: format!("granular {wall}"),
            skin,
            dt,
        }
    }

    /// The variables of [`SETUP`].
    pub fn variables(&self) -> Vec<(&'static str, String)> {
        vec![
            ("style", self.style.clone()),
            ("pair", self.pair.clone()),
            ("wall", self.wall.clone()),
            ("skin", self.skin.to_string()),
            ("dt", self.dt.to_string()),
        ]
    }
}

impl Contacts {
    /// LAMMPS's words for resistances against turning, of a pair with this normal stiffness (N/m),
    /// reduced mass (kg) and reduced radius (m). Ours are forces on that radius; its twisting has
    /// moments and angles.
    fn turning(&self, stiffness: f64, mass: f64, arm: f64) -> String {
        let spring = |t: Turning| t.stiffness_ratio * stiffness;
        // Of a sphere that turns on the spring alone: I = 0.4 m r².
        let dashpot = |t: Turning| 2.0 * t.damping_ratio * (0.4 * mass * spring(t)).sqrt();
        let rolling = self.rolling.map_or(String::new(), |t| {
            format!(" rolling sds {} {} {}", spring(t), dashpot(t), t.friction)
        });
        let twisting = self.twisting.map_or(String::new(), |t| {
            let [spring, dashpot] = [spring(t), dashpot(t)].map(|x| x * arm * arm);
            format!(" twisting sds {spring} {dashpot} {}", t.friction * arm)
        });
        rolling + &twisting
    }
}
