//! The return spring of a finger and its placement.

/// The spring that returns the finger to the straight configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    pub kind: SpringKind,
    pub placement: Placement,
}

/// Characteristic of a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpringKind {
    /// Constant torque k_s.
    Constant { torque_n_m: f64 },
    /// Torque c_s (q_p + Δq_s), with stiffness c_s, preload angle q_p, and Δq_s relative to the straight configuration.
    Torsional { stiffness_n_m_per_rad: f64, preload_rad: f64 },
}

/// Links between which the spring acts; each variant names the spring angle q_s (thesis §3.3.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// q_s = q21 − q11.
    GroundLinks,
    /// q_s = q12.
    DrivenCoupler,
    /// q_s = q22 (default).
    Phalanges,
    /// q_s = q11 + q12 − (q21 + q22).
    CouplerDistal,
}

impl Placement {
    /// All placements in the order of the thesis, §3.3.2.3.
    pub const ALL: [Placement; 4] =
        [Placement::GroundLinks, Placement::DrivenCoupler, Placement::Phalanges, Placement::CouplerDistal];

    /// Name of the coordinate in scenes and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Placement::GroundLinks => "q21-q11",
            Placement::DrivenCoupler => "q12",
            Placement::Phalanges => "q22",
            Placement::CouplerDistal => "q11+q12-(q21+q22)",
        }
    }
}
