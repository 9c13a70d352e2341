//! `[integrator]`: how the equations of motion are integrated.

use super::lines;
use crate::scene::check::{Bound, POSITIVE};
use crate::scene::kinds::{Angle, AngularRate, Choice, Count, Number, Words};
use crate::scene::words::SceneKind;

/// Integrator of the analytic model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    pub preset: Preset,
    pub method: Method,
    /// Relative tolerance (of rates only: angles have an absolute tolerance).
    pub rtol: f64,
    pub atol_angle_rad: f64,
    pub atol_rate_rad_s: f64,
    /// Step budget; a run that needs more ends with an error and keeps its log.
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

/// Of either model.
pub const MAX_STEPS: u64 = 10_000_000;

/// Impacts between two fingers and what they throw about multiply errors ten-thousandfold: at the 1e-5 of one finger five of
/// 314 random grippers were off by more than 1e-5 rad.
const GRIPPER_RTOL: f64 = 3e-6;

/// Absolute tolerances below which angles of 1 rad and rates of 100 rad/s have no digits.
const FINEST_ATOL_RAD: f64 = 1e-14;
const FINEST_ATOL_RAD_S: f64 = 1e-9;

impl Integrator {
    /// The settings a preset stands for.
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

    /// What scenes of a kind are integrated with where nothing is said.
    pub fn everyday(kind: SceneKind) -> Self {
        let usual = Self::preset(Preset::Engineering);
        if kind == SceneKind::Gripper { usual.with_rtol(GRIPPER_RTOL) } else { usual }
    }

    /// The settings of another preset, within the same step budget.
    pub(in crate::scene) const fn with_preset(&self, preset: Preset) -> Self {
        Self { max_steps: self.max_steps, ..Self::preset(preset) }
    }

    /// The same where that is the preset already: kinds have everyday settings of their own.
    fn changed_to(&self, preset: Preset) -> Self {
        if self.preset == preset { *self } else { self.with_preset(preset) }
    }

    /// The same with another `rtol`, and with the absolute tolerances scaled along: all of what counts as tolerance is as much
    /// tighter or looser, but not below 1e-14 rad and 1e-9 rad/s: there are no digits left to ask for.
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

impl Words for Preset {
    const WORDS: &'static [(&'static str, Self)] =
        &[("engineering", Preset::Engineering), ("reference", Preset::Reference)];
}

impl Words for Method {
    const WORDS: &'static [(&'static str, Self)] = &[("rodas5p", Method::Rodas5p), ("radau5", Method::RadauIIa5)];
}

const RTOL: Bound = Bound { allowed: |x| x > 0.0 && x < 1.0, text: "between 0 and 1, both excluded" };

lines! {
    /// How the equations of motion are integrated. Keys left out follow the preset.
    Integrator = Self::preset(Preset::Engineering), i;
    /// "engineering" for everyday runs (rtol 1e-5, in grippers 3e-6), "reference" for comparisons (1e-11).
    "preset": Choice<Preset> = Some(&mut i.preset), put(|i, preset| *i = i.changed_to(preset));
    "method": Choice<Method> = Some(&mut i.method), follows();
    /// Relative tolerance of rates.
    "rtol": Number = Some(&mut i.rtol), put(|i, rtol| *i = i.with_rtol(rtol)), allowed(RTOL), follows();
    /// Absolute tolerance of angles; of places of discs the same number in m.
    "atol_angle": Angle = Some(&mut i.atol_angle_rad), allowed(POSITIVE), follows();
    /// Absolute tolerance of rates; of velocities of discs the same number in m/s.
    "atol_rate": AngularRate = Some(&mut i.atol_rate_rad_s), allowed(POSITIVE), follows();
    /// Steps after which a run is given up.
    "max_steps": Count = Some(&mut i.max_steps);
}
