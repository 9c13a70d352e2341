//! All possible contacts of a system, in the order of its samples.

use super::{GripperContact, Side, System};
use crate::gripper::FingerContact;
use crate::law::{FrictionLaw, NormalLaw};

/// Two surfaces that may come into contact, or the stop of a joint. Discs are identified by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactId {
    /// A phalanx and a disc.
    Phalanx(Side, FingerContact, usize),
    Stop(Side),
    /// Two discs; the first one moves.
    Discs(usize, usize),
    /// A disc on palm or ground.
    Palm(usize),
    Table(usize),
}

impl System {
    /// All pairs of discs, or of a disc and the half plane, with at least one that moves, in the order of both models: by
    /// the index of the first disc, then of the second, with the half plane last.
    pub fn pairs(&self) -> Vec<ContactId> {
        let mut pairs = Vec::new();
        for (i, first) in self.discs.iter().enumerate() {
            for (j, second) in self.discs.iter().enumerate().skip(i + 1) {
                match (first.motion.moves(), second.motion.moves()) {
                    (true, _) => pairs.push(ContactId::Discs(i, j)),
                    (false, true) => pairs.push(ContactId::Discs(j, i)),
                    (false, false) => {}
                }
            }
            if self.palm.is_some() && first.motion.moves() {
                pairs.push(ContactId::Palm(i));
            }
        }
        pairs
    }

    /// All possible contacts. With fingers: first [`System::gripper_contacts`] with the first disc, whether or not it
    /// exists; then the contacts of the other discs with the fingers; then pairs of discs. Without fingers: only pairs.
    pub fn contact_ids(&self) -> Vec<ContactId> {
        let pairs = self.pairs().into_iter();
        let table_contacts = |from: usize| {
            let moving = (from..self.discs.len()).filter(|disc| self.discs[*disc].motion.moves());
            moving.filter(|_| self.table.is_some()).map(ContactId::Table)
        };
        if self.fingers.is_empty() {
            return pairs.chain(table_contacts(0)).collect();
        }
        let mut all: Vec<ContactId> =
            self.gripper_contacts().iter().map(|gripper_contact| gripper_contact.contact_id(0)).collect();
        let finger_contacts = |(side, disc)| {
            [FingerContact::Proximal, FingerContact::Distal]
                .map(|finger_contact| ContactId::Phalanx(side, finger_contact, disc))
        };
        let others = (1..self.discs.len()).flat_map(|disc| self.fingers_by_side().map(move |(side, _)| (side, disc)));
        all.extend(others.flat_map(finger_contacts));
        // With two fingers, `gripper_contacts` includes the contacts of the first disc with palm and table.
        let is_included = |contact: &ContactId| self.fingers.len() > 1 && matches!(contact, ContactId::Palm(0));
        all.extend(pairs.filter(|contact| !is_included(contact)));
        all.extend(table_contacts(usize::from(self.fingers.len() > 1)));
        all
    }

    /// Name of a contact in reports, keys and topics: `distal`, `left_distal`, `hammer-anvil`, `hammer-plane`; with
    /// fingers, `ball-distal` for all discs except the first.
    pub fn contact_name(&self, contact: ContactId) -> String {
        let (disc, other) = match contact {
            ContactId::Phalanx(side, finger_contact, disc) => {
                (disc, GripperContact::Finger(side, finger_contact).name_for(self.fingers.len()))
            }
            ContactId::Stop(side) => {
                return GripperContact::Finger(side, FingerContact::Limit).name_for(self.fingers.len());
            }
            ContactId::Discs(disc, other) => (disc, self.discs[other].name.clone()),
            ContactId::Palm(disc) if self.fingers.is_empty() => (disc, "plane".to_string()),
            ContactId::Palm(disc) => (disc, GripperContact::Palm.name()),
            ContactId::Table(disc) => (disc, GripperContact::Table.name()),
        };
        let is_gripper_contact =
            self.gripper_contacts().iter().any(|gripper_contact| gripper_contact.contact_id(0) == contact);
        if is_gripper_contact { other } else { format!("{}-{other}", self.discs[disc].name) }
    }

    /// Laws of a contact; `None` if one of its surfaces does not exist.
    pub fn contact_laws(&self, contact: ContactId) -> Option<(NormalLaw, Option<FrictionLaw>)> {
        let law = match contact {
            ContactId::Stop(side) => return self.finger(side).limit.map(|normal| (normal, None)),
            ContactId::Phalanx(side, finger_contact, disc) => {
                self.discs.get(disc).and_then(|_| self.finger(side).law(finger_contact))
            }
            ContactId::Discs(..) => self.between_discs,
            ContactId::Palm(disc) => self.discs.get(disc).and(self.palm).and_then(|palm| palm.contact),
            ContactId::Table(disc) => self.discs.get(disc).and(self.table).and_then(|table| table.contact),
        };
        law.map(|law| (law.normal, law.friction))
    }

    /// Narrowest slip range of any friction law, m/s; infinite without friction.
    pub(crate) fn narrowest_slip_range_m_s(&self) -> f64 {
        let laws = self.contact_ids().into_iter().filter_map(|contact| self.contact_laws(contact)?.1);
        laws.map(|friction| friction.min_slip_scale_m_s()).fold(f64::INFINITY, f64::min)
    }
}

impl GripperContact {
    /// Returns the contact with a given disc.
    pub fn contact_id(self, disc: usize) -> ContactId {
        match self {
            GripperContact::Finger(side, FingerContact::Limit) => ContactId::Stop(side),
            GripperContact::Finger(side, finger_contact) => ContactId::Phalanx(side, finger_contact, disc),
            GripperContact::Palm => ContactId::Palm(disc),
            GripperContact::Table => ContactId::Table(disc),
        }
    }
}

impl ContactId {
    /// Whether the contact is a joint stop, whose gap is an angle.
    pub fn is_stop(self) -> bool {
        matches!(self, ContactId::Stop(_))
    }
}
