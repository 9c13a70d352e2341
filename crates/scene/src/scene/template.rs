//! What all designs of a study have in common: a scene without its four free numbers.

use super::defaults;
use crate::gripper::{Assembly, BodyOverride, Design, ProximalLength, disc};
use crate::sizing::{CLOSING_S, Rule, Task};

/// A gripper of which base, l21, φ22 and r_l are still free, and what it is sized for.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    pub name: String,
    /// Base, l21, φ22 and r_l are those of the scene; a study puts others in their place.
    pub design: Design,
    pub density_kg_m3: f64,
    pub depth_m: f64,
    /// What is given of the bodies l11, l12, l21 and l22; it stays the same whatever the design.
    pub overrides: [BodyOverride; 4],
    pub assembly: Assembly,
    /// q_0, how far before the proximal contact the finger starts.
    pub opening_rad: f64,
    pub gravity_m_s2: [f64; 2],
    /// Length T of the test trajectory that motor and spring are sized for.
    pub closing_s: f64,
    /// The rule of the scene's own sizing, if it has one.
    pub rule: Option<Rule>,
    /// μ_s of the proximal and of the distal contact.
    pub mu_static: [f64; 2],
}

impl Template {
    /// The gripper of the thesis (Table 3.2), without friction; its free numbers are those of design 95.
    pub fn thesis() -> Self {
        Self {
            name: "thesis".to_string(),
            design: Design::thesis(0.0155, ProximalLength::Fraction(1.0), 120f64.to_radians(), 0.5),
            density_kg_m3: defaults::DENSITY_KG_M3,
            depth_m: defaults::DEPTH_M,
            overrides: [BodyOverride::default(); 4],
            assembly: Assembly::Reference,
            opening_rad: defaults::OFFSET_DEG.to_radians(),
            gravity_m_s2: defaults::GRAVITY_M_S2,
            closing_s: CLOSING_S,
            rule: None,
            mu_static: [0.0; 2],
        }
    }

    /// The task a design is sized for.
    pub fn task(&self, design: &Design) -> Task {
        let Self { opening_rad, gravity_m_s2, closing_s, .. } = *self;
        Task { object: disc(design), opening_rad, gravity_m_s2, closing_s }
    }
}
