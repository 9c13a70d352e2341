//! Names of the parts of a scene's samples.

use crate::scene::keywords::SceneKind;
use crate::scene::{self, Disc, Side, System};

/// Names of the fingers, bodies and contacts of a scene's samples, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Names of the fingers; the name of a single finger is empty.
    pub fingers: Vec<String>,
    pub bodies: Vec<String>,
    pub contacts: Vec<ContactChannel>,
}

/// One contact of a sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContactChannel {
    pub name: String,
    /// Whether the gap is an angle, as for a joint limit: read rad for m and N·m for N.
    pub is_angular: bool,
}

impl Layout {
    /// Returns the layout of a system; contacts are in the order of [`System::contact_ids`].
    pub fn from_system(system: &System) -> Self {
        let channel = |id| ContactChannel { name: system.contact_name(id), is_angular: id.is_stop() };
        Self {
            bodies: system.reported_discs().iter().map(|disc| disc.name.clone()).collect(),
            contacts: system.contact_ids().into_iter().map(channel).collect(),
            ..Self::from_finger_count(system.fingers.len())
        }
    }

    /// Returns the layout implied by a kind of scene alone; discs, whose names come from the scene, are missing.
    pub fn from_kind(kind: SceneKind) -> Self {
        match kind {
            SceneKind::Bodies => Self::default(),
            SceneKind::Finger => Self::from_finger_count(1),
            SceneKind::Gripper => Self { bodies: vec![Disc::OBJECT.to_string()], ..Self::from_finger_count(2) },
        }
    }

    fn from_finger_count(count: usize) -> Self {
        let channel = |contact: &scene::GripperContact| ContactChannel {
            name: contact.name_for(count),
            is_angular: contact.is_stop(),
        };
        let sides = Side::BOTH.iter().take(count);
        Layout {
            fingers: sides.map(|side| if count == 1 { String::new() } else { side.name().to_string() }).collect(),
            bodies: Vec::new(),
            contacts: scene::GripperContact::for_fingers(count).iter().map(channel).collect(),
        }
    }

    /// Indices of the contacts between surfaces, that is all except joint limits.
    pub fn surfaces(&self) -> impl Iterator<Item = usize> + '_ {
        self.contacts.iter().enumerate().filter(|(_, channel)| !channel.is_angular).map(|(index, _)| index)
    }
}
