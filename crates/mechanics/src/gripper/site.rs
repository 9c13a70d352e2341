//! The places where a finger can meet something.

/// Where a unilateral contact can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Site {
    /// Proximal phalanx l21 against the object.
    Proximal,
    /// Distal phalanx t22 against the object.
    Distal,
    /// Joint limit q22 ≥ −φ22.
    Limit,
}

impl Site {
    pub const ALL: [Site; 3] = [Site::Proximal, Site::Distal, Site::Limit];

    /// Name in JSON keys and log topics.
    pub fn name(self) -> &'static str {
        match self {
            Site::Proximal => "proximal",
            Site::Distal => "distal",
            Site::Limit => "limit",
        }
    }
}
