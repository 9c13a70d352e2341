//! What holds when a scene does not say otherwise: thesis Table 3.2.

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
