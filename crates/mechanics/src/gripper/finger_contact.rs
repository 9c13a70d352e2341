//! The contacts of a finger.

/// A unilateral contact of a finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FingerContact {
    /// Proximal phalanx l21 against the object.
    Proximal,
    /// Distal phalanx t22 against the object.
    Distal,
    /// Joint limit q22 ≥ −φ22.
    Limit,
}

impl FingerContact {
    pub const ALL: [FingerContact; 3] = [FingerContact::Proximal, FingerContact::Distal, FingerContact::Limit];

    /// Name in JSON keys and log topics.
    pub fn name(self) -> &'static str {
        match self {
            FingerContact::Proximal => "proximal",
            FingerContact::Distal => "distal",
            FingerContact::Limit => "limit",
        }
    }
}
