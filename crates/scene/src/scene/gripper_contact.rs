//! Possible contacts of a gripper.

use crate::gripper::FingerContact;
pub use crate::statics::Side;

/// A possible contact of a gripper: three at each finger, and the contacts of the object with palm and table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GripperContact {
    Finger(Side, FingerContact),
    Palm,
    Table,
}

impl GripperContact {
    /// All contacts, in the order of both models.
    pub const ALL: [Self; 8] = [
        GripperContact::Finger(Side::Right, FingerContact::Proximal),
        GripperContact::Finger(Side::Right, FingerContact::Distal),
        GripperContact::Finger(Side::Right, FingerContact::Limit),
        GripperContact::Finger(Side::Left, FingerContact::Proximal),
        GripperContact::Finger(Side::Left, FingerContact::Distal),
        GripperContact::Finger(Side::Left, FingerContact::Limit),
        GripperContact::Palm,
        GripperContact::Table,
    ];

    /// Whether the contact is a joint stop, whose gap is an angle.
    #[inline]
    pub fn is_stop(self) -> bool {
        matches!(self, GripperContact::Finger(_, FingerContact::Limit))
    }

    /// Index in [`GripperContact::ALL`].
    #[inline(always)]
    pub fn index(self) -> usize {
        match self {
            GripperContact::Finger(side, finger_contact) => {
                FingerContact::ALL.len() * side as usize + finger_contact as usize
            }
            GripperContact::Palm => 6,
            GripperContact::Table => 7,
        }
    }

    /// Returns the contacts of a system with this number of fingers, in the order of [`GripperContact::ALL`].
    pub fn for_fingers(count: usize) -> &'static [Self] {
        &Self::ALL[..[0, FingerContact::ALL.len(), Self::ALL.len()][count]]
    }

    /// Name in reports, keys and topics for a system with this number of fingers: `distal` with one, `right_distal`
    /// with two.
    pub fn name_for(self, fingers: usize) -> String {
        match self {
            GripperContact::Finger(_, finger_contact) if fingers == 1 => finger_contact.name().to_string(),
            contact => contact.name(),
        }
    }

    /// Name in a system with two fingers.
    pub fn name(self) -> String {
        match self {
            GripperContact::Finger(side, finger_contact) => format!("{}_{}", side.name(), finger_contact.name()),
            GripperContact::Palm => "palm".to_string(),
            GripperContact::Table => "table".to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_agrees_with_order_of_all() {
        for (index, contact) in GripperContact::ALL.into_iter().enumerate() {
            assert_eq!(contact.index(), index, "{contact:?}");
        }
    }
}
