//! What holds when a scene does not say otherwise: thesis Table 3.2, and the settings of the integrator.

use super::{BodiesBounds, Bounds, Construction, Engine, Integrator, Method, Preset, Response, Stepping};
use crate::law::NormalLaw;

pub const DURATION_S: f64 = 0.020;
/// The gripper hangs upside down: gravity pulls the object out of it.
pub const GRAVITY_M_S2: [f64; 2] = [0.0, 9.81];
pub const L11_M: f64 = 0.015;
pub const HALF_WIDTH_M: f64 = 0.0025;
pub const DENSITY_KG_M3: f64 = 1070.0;
pub const DEPTH_M: f64 = 0.040;
pub const OBJECT_RADIUS_M: f64 = 0.020;
pub const V_STATIC_M_S: f64 = 0.1;
pub const V_DYNAMIC_M_S: f64 = 0.2;
/// q_0: how far before the proximal contact the finger starts, in degrees.
pub const OFFSET_DEG: f64 = 25.0;
pub const NUMERIC_RATE_HZ: f64 = 10e3;
pub const PICTURE_RATE_HZ: f64 = 5e3;
pub const MAX_STEPS: u64 = 10_000_000;
pub const ENGINE_TOLERANCE_M: f64 = 1e-7;
pub const ENGINE_MAX_STEP_S: f64 = 6e-5;
/// Joint sweeps with the contact laws: the engine hands rapier the reactions, the sweeps only confirm them…
pub const ENGINE_ITERATIONS: u32 = 2;
/// …and with rapier's own contact, whose impulses the sweeps must carry through the linkage.
pub const ENGINE_ITERATIONS_RIGID: u32 = 50;

/// μ_d = 0.7 μ_s; 0.56 for 0.8, to the last bit.
pub fn mu_dynamic(mu_static: f64) -> f64 {
    7.0 * mu_static / 10.0
}

/// Law of the object's contacts.
pub const CONTACT: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };

/// Law of the joint limit, in rad for m.
pub const LIMIT: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e11, exponent: 2.2, damping_max_n_s_per_m: 1e9, transition_m: 1e-5 };

impl Engine {
    pub const DEFAULT: Self = Self {
        construction: Construction::Maximal,
        response: Response::Laws,
        stepping: Stepping::Adaptive { tolerance_m: ENGINE_TOLERANCE_M, max_step_s: ENGINE_MAX_STEP_S },
        iterations: ENGINE_ITERATIONS,
        max_steps: MAX_STEPS,
    };

    /// Joint sweeps unless the scene says otherwise: they depend on what answers to contact.
    pub const fn usual_iterations(response: Response) -> u32 {
        match response {
            Response::Laws => ENGINE_ITERATIONS,
            Response::Rapier { .. } => ENGINE_ITERATIONS_RIGID,
        }
    }
}

impl Bounds {
    /// What every scene is held to unless it says otherwise.
    pub const fn over(duration_s: f64) -> Self {
        Self {
            angle_rad: 2e-5,
            contact_time_s: 5e-7,
            final_force: 1e-4,
            impulse: 5e-3,
            loop_gap_m: 1e-7,
            until_s: duration_s,
        }
    }
}

impl BodiesBounds {
    /// What every scene of discs is held to unless it says otherwise.
    pub const fn over(duration_s: f64) -> Self {
        Self { position_m: 1e-6, contact_time_s: 5e-7, impulse: 5e-3, peak_force: 1e-2, until_s: duration_s }
    }
}

/// Absolute tolerances below which angles of 1 rad and rates of 100 rad/s have no digits.
const FINEST_ATOL_RAD: f64 = 1e-14;
const FINEST_ATOL_RAD_S: f64 = 1e-9;

impl Integrator {
    /// The settings of another preset, within the same step budget.
    pub const fn with_preset(&self, preset: Preset) -> Self {
        Self { max_steps: self.max_steps, ..Self::preset(preset) }
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
}
