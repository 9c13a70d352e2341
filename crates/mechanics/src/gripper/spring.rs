//! The spring that pulls the finger straight, and the joint it sits in.

/// The spring that pulls the finger back to the straight configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    pub kind: SpringKind,
    pub placement: Placement,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpringKind {
    /// Constant torque k_s.
    Constant { torque_n_m: f64 },
    /// Torque c_s (q_p + Δq_s): stiffness and preload angle, Δq_s from the straight configuration.
    Torsional { stiffness_n_m_per_rad: f64, preload_rad: f64 },
}

/// The coordinate q_s the spring acts on (thesis §3.3.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// q21 − q11.
    GroundLinks,
    /// q12.
    DrivenCoupler,
    /// q22 (default).
    Phalanges,
    /// q11 + q12 − (q21 + q22).
    CouplerDistal,
}

impl Placement {
    /// In the order of the thesis, §3.3.2.3.
    pub const ALL: [Placement; 4] =
        [Placement::GroundLinks, Placement::DrivenCoupler, Placement::Phalanges, Placement::CouplerDistal];

    /// The coordinate it acts on, as scenes and reports write it.
    pub const fn name(self) -> &'static str {
        match self {
            Placement::GroundLinks => "q21-q11",
            Placement::DrivenCoupler => "q12",
            Placement::Phalanges => "q22",
            Placement::CouplerDistal => "q11+q12-(q21+q22)",
        }
    }
}
