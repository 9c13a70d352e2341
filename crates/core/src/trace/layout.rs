//! What the samples of a scene consist of, by name.

use crate::scene::words::SceneKind;
use crate::scene::{self, Disc, Side, System};

/// The fingers, bodies and contacts of a scene's samples, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// A finger that is alone has no name.
    pub fingers: Vec<String>,
    pub bodies: Vec<String>,
    pub contacts: Vec<Place>,
}

/// A place of contact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub name: String,
    /// Whether its gap is an angle, as that of a joint limit is: for m read rad, for N read N·m.
    pub angular: bool,
}

impl Layout {
    /// Of what is simulated: contacts in the order of [`System::touching`].
    pub fn of(system: &System) -> Self {
        let place = |of| Place { name: system.touching_name(of), angular: of.is_stop() };
        Self {
            bodies: system.told_discs().iter().map(|disc| disc.name.clone()).collect(),
            contacts: system.touching().into_iter().map(place).collect(),
            ..Self::of_fingers(system.fingers.len())
        }
    }

    /// Of a kind of scene, as far as that alone says it: not of discs, which have names.
    pub fn of_kind(kind: SceneKind) -> Self {
        match kind {
            SceneKind::Bodies => Self::default(),
            SceneKind::Finger => Self::of_fingers(1),
            SceneKind::Gripper => Self { bodies: vec![Disc::OBJECT.to_string()], ..Self::of_fingers(2) },
        }
    }

    fn of_fingers(count: usize) -> Self {
        let place = |of: &scene::Place| Place { name: of.name_among(count), angular: of.is_stop() };
        let sides = Side::BOTH.iter().take(count);
        Layout {
            fingers: sides.map(|side| if count == 1 { String::new() } else { side.word().to_string() }).collect(),
            bodies: Vec::new(),
            contacts: scene::Place::of_fingers(count).iter().map(place).collect(),
        }
    }

    /// The contacts between surfaces, by their index: all but the stops of joints.
    pub fn surfaces(&self) -> impl Iterator<Item = usize> + '_ {
        self.contacts.iter().enumerate().filter(|(_, place)| !place.angular).map(|(index, _)| index)
    }
}
