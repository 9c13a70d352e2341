//! Stiffness of a contact from materials and radii (thesis (2.33), (2.34), errata 6).

use crate::numeric::elementary::powi;

/// Elastic constants of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    pub youngs_modulus_pa: f64,
    pub poisson_ratio: f64,
}

/// k = (4/3) E* √R of F = k δ^{3/2}, in N/m^{3/2}, with 1/E* = Σ (1 − ν²)/E and 1/R = 1/R₁ + 1/R₂.
///
/// A flat face has an infinite radius.
pub fn hertz_stiffness(materials: [Material; 2], radii_m: [f64; 2]) -> f64 {
    let compliance: f64 = materials.iter().map(|m| (1.0 - powi(m.poisson_ratio, 2)) / m.youngs_modulus_pa).sum();
    let curvature: f64 = radii_m.iter().map(|r| r.recip()).sum();
    4.0 / 3.0 / compliance / curvature.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steel sphere of 10 mm on a steel flat: δ = (9 F²/(16 E*² R))^{1/3} (Johnson, Contact Mechanics, (4.23)).
    #[test]
    fn errata_06_stiffness_agrees_with_johnson() {
        let steel = Material { youngs_modulus_pa: 210e9, poisson_ratio: 0.3 };
        let e_star = 210e9 / (2.0 * (1.0 - 0.09));
        let force: f64 = 100.0;
        let delta = (9.0 * force * force / (16.0 * e_star * e_star * 0.01)).cbrt();
        let k = hertz_stiffness([steel, steel], [0.01, f64::INFINITY]);
        assert!((k * delta.powf(1.5) / force - 1.0).abs() < 1e-12);
    }
}
