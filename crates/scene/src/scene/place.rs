//! Where something can touch in a gripper.

use crate::gripper::Site;
pub use crate::statics::Side;

/// Where something can touch: three sites of either finger, the object on the palm, and on the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Finger(Side, Site),
    Palm,
    Table,
}

impl Place {
    /// All places, in the order in which both models count them.
    pub const ALL: [Self; 8] = [
        Place::Finger(Side::Right, Site::Proximal),
        Place::Finger(Side::Right, Site::Distal),
        Place::Finger(Side::Right, Site::Limit),
        Place::Finger(Side::Left, Site::Proximal),
        Place::Finger(Side::Left, Site::Distal),
        Place::Finger(Side::Left, Site::Limit),
        Place::Palm,
        Place::Table,
    ];

    /// Whether it is the stop of a joint, whose gap is an angle.
    #[inline]
    pub fn is_stop(self) -> bool {
        matches!(self, Place::Finger(_, Site::Limit))
    }

    /// Where it is in [`Place::ALL`].
    #[inline(always)]
    pub fn index(self) -> usize {
        match self {
            Place::Finger(side, site) => Site::ALL.len() * side as usize + site as usize,
            Place::Palm => 6,
            Place::Table => 7,
        }
    }

    /// Those of so many fingers, in that order: none, one alone, or two with what they grasp between them.
    pub fn of_fingers(count: usize) -> &'static [Self] {
        &Self::ALL[..[0, Site::ALL.len(), Self::ALL.len()][count]]
    }

    /// Name in reports, keys and topics where there are so many fingers: `distal`; of two `right_distal`, `palm`.
    pub fn name_among(self, fingers: usize) -> String {
        match self {
            Place::Finger(_, site) if fingers == 1 => site.name().to_string(),
            place => place.name(),
        }
    }

    /// Name where there are two fingers.
    pub fn name(self) -> String {
        match self {
            Place::Finger(side, site) => format!("{}_{}", side.word(), site.name()),
            Place::Palm => "palm".to_string(),
            Place::Table => "table".to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_where_its_index_says() {
        for (index, place) in Place::ALL.into_iter().enumerate() {
            assert_eq!(place.index(), index, "{place:?}");
        }
    }
}
