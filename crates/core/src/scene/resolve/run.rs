//! How the simulation is run.

use super::super::check::{Bound, Checker, POSITIVE};
use super::super::raw::RawIntegrator;
use super::super::{Integrator, Preset};

const RTOL: Bound = Bound { allowed: |x| x > 0.0 && x < 1.0, text: "between 0 and 1, both excluded" };

/// Integrator: the preset, and what the scene sets otherwise.
pub fn integrator(c: &mut Checker<'_>, raw: &RawIntegrator) -> Integrator {
    let preset = c.or("integrator.preset", &raw.preset, Preset::Engineering);
    let base = Integrator::preset(preset);
    // Absolute tolerances that are not given follow the relative one.
    let base = base.with_rtol(c.number_or("integrator.rtol", &raw.rtol, RTOL, base.rtol));
    Integrator {
        method: c.or("integrator.method", &raw.method, base.method),
        atol_angle_rad: c.number_or("integrator.atol_angle", &raw.atol_angle, POSITIVE, base.atol_angle_rad),
        atol_rate_rad_s: c.number_or("integrator.atol_rate", &raw.atol_rate, POSITIVE, base.atol_rate_rad_s),
        max_steps: c.or("integrator.max_steps", &raw.max_steps, base.max_steps),
        ..base
    }
}
