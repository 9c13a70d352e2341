//! `[integrator]`: integration of the equations of motion.

use super::settings;
use crate::scene::check::{Bound, POSITIVE};
use crate::scene::keywords::SceneKind;
use crate::scene::value_kinds::{Angle, AngularRate, Choice, Count, Keyword, Number};

/// Integrator of the analytic model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    pub preset: Preset,
    pub method: Method,
    /// Relative tolerance of rates; angles have an absolute tolerance only.
    pub rtol: f64,
    pub atol_angle_rad: f64,
    pub atol_rate_rad_s: f64,
    /// Step budget; a run that needs more steps ends with an error, and its log is kept.
    pub max_steps: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    Engineering,
    Reference,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    Rodas5p,
    RadauIIa5,
}

/// Default step budget of both models.
pub const MAX_STEPS: u64 = 10_000_000;

/// Default relative tolerance of grippers. Impacts between two fingers and a moving object amplify errors by a factor
/// of 1e4: at 1e-5, the default of one finger, the error exceeded 1e-5 rad in 5 of 314 random grippers.
const GRIPPER_RTOL: f64 = 3e-6;

/// Smallest useful absolute tolerance of angles: the precision of an angle of 1 rad.
const FINEST_ATOL_RAD: f64 = 1e-14;
/// Smallest useful absolute tolerance of rates: the precision of a rate of 100 rad/s.
const FINEST_ATOL_RAD_S: f64 = 1e-9;

impl Integrator {
    /// Returns the settings of a preset.
    pub const fn preset(preset: Preset) -> Self {
        match preset {
            Preset::Engineering => Self {
                preset,
                method: Method::Rodas5p,
                rtol: 1e-5,
                atol_angle_rad: 1e-9,
                atol_rate_rad_s: 1e-5,
                max_steps: MAX_STEPS,
            },
            Preset::Reference => Self {
                preset,
                method: Method::RadauIIa5,
                rtol: 1e-11,
                atol_angle_rad: 1e-14,
                atol_rate_rad_s: 1e-9,
                max_steps: MAX_STEPS,
            },
        }
    }

    /// Returns the default settings of a kind of scene: the engineering preset, with a tighter tolerance for grippers.
    pub fn engineering_for(kind: SceneKind) -> Self {
        let defaults = Self::preset(Preset::Engineering);
        if kind == SceneKind::Gripper { defaults.with_rtol(GRIPPER_RTOL) } else { defaults }
    }

    /// The settings of another preset, within the same step budget.
    pub(in crate::scene) const fn with_preset(&self, preset: Preset) -> Self {
        Self { max_steps: self.max_steps, ..Self::preset(preset) }
    }

    /// Like [`Integrator::with_preset`], but unchanged if the preset is the same: its settings may depend on the kind
    /// of scene.
    fn changed_to(&self, preset: Preset) -> Self {
        if self.preset == preset { *self } else { self.with_preset(preset) }
    }

    /// Sets `rtol` and scales the absolute tolerances by the same factor, but not below 1e-14 rad and 1e-9 rad/s, the
    /// limit of double precision.
    pub fn with_rtol(&self, rtol: f64) -> Self {
        let factor = rtol / self.rtol;
        let scaled = |atol: f64, finest: f64| (factor * atol).max(finest.min(atol));
        Self {
            rtol,
            atol_angle_rad: scaled(self.atol_angle_rad, FINEST_ATOL_RAD),
            atol_rate_rad_s: scaled(self.atol_rate_rad_s, FINEST_ATOL_RAD_S),
            ..*self
        }
    }
}

impl Keyword for Preset {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("engineering", Preset::Engineering), ("reference", Preset::Reference)];
}

impl Keyword for Method {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("rodas5p", Method::Rodas5p), ("radau5", Method::RadauIIa5)];
}

const RTOL: Bound = Bound { allowed: |x| x > 0.0 && x < 1.0, text: "between 0 and 1, both excluded" };

settings! {
    /// Integration of the equations of motion. Defaults depend on the preset.
    Integrator = Self::preset(Preset::Engineering), i;
    /// "engineering" for general use (rtol 1e-5, in grippers 3e-6), "reference" for comparisons (rtol 1e-11).
    "preset": Choice<Preset> = Some(&mut i.preset), set_with(|i, preset| *i = i.changed_to(preset));
    /// Integration method: Rodas5P or Radau IIA of order 5.
    "method": Choice<Method> = Some(&mut i.method), derived();
    /// Relative tolerance of rates.
    "rtol": Number = Some(&mut i.rtol), set_with(|i, rtol| *i = i.with_rtol(rtol)), allowed(RTOL), derived();
    /// Absolute tolerance of angles; for positions of discs the same number in m.
    "atol_angle": Angle = Some(&mut i.atol_angle_rad), allowed(POSITIVE), derived();
    /// Absolute tolerance of rates; for velocities of discs the same number in m/s.
    "atol_rate": AngularRate = Some(&mut i.atol_rate_rad_s), allowed(POSITIVE), derived();
    /// Maximum number of steps of a run.
    "max_steps": Count = Some(&mut i.max_steps);
}
