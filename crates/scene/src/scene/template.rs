//! The common part of all designs of a study: a scene without the four design variables.

use crate::gripper::{Assembly, BodyOverride, Design, ProximalLength, disc};
use crate::sizing::{CLOSING_S, Rule, Task};

/// Default density of links and object.
pub const DENSITY_KG_M3: f64 = 1070.0;
/// Default depth of links and object, perpendicular to the plane.
pub const DEPTH_M: f64 = 0.040;

/// A gripper with the design variables base, l21, φ22 and r_l left open, and the task it is sized for.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    pub name: String,
    /// The design of the scene; a study replaces its base, l21, φ22 and r_l.
    pub design: Design,
    pub density_kg_m3: f64,
    pub depth_m: f64,
    /// Overrides of the mass properties of l11, l12, l21 and l22, common to all designs.
    pub overrides: [BodyOverride; 4],
    pub assembly: Assembly,
    /// q_0, the initial angle before the proximal contact.
    pub opening_rad: f64,
    pub gravity_m_s2: [f64; 2],
    /// Duration T of the test trajectory for the sizing of motor and spring.
    pub closing_s: f64,
    /// Sizing rule of the scene, if it has one.
    pub rule: Option<Rule>,
    /// μ_s of the proximal and the distal contact.
    pub mu_static: [f64; 2],
}

impl Template {
    /// Returns the gripper of the thesis (Table 3.2), without friction, with the design variables of design 95.
    pub fn thesis() -> Self {
        Self {
            name: "thesis".to_string(),
            design: Design::thesis(0.0155, ProximalLength::Fraction(1.0), 120f64.to_radians(), 0.5),
            density_kg_m3: DENSITY_KG_M3,
            depth_m: DEPTH_M,
            overrides: [BodyOverride::default(); 4],
            assembly: Assembly::Reference,
            opening_rad: 25f64.to_radians(),
            gravity_m_s2: [0.0, crate::units::G_M_S2],
            closing_s: CLOSING_S,
            rule: None,
            mu_static: [0.0; 2],
        }
    }

    /// Returns the sizing task of a design.
    pub fn task(&self, design: &Design) -> Task {
        let Self { opening_rad, gravity_m_s2, closing_s, .. } = *self;
        Task { object: disc(design), opening_rad, gravity_m_s2, closing_s }
    }
}
