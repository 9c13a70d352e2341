//! What the samples of a scene consist of, by name.

use super::Site;
use crate::scene::words::SceneKind;
use crate::scene::{self, Side};

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
    /// Of a kind of scene, as far as that alone says it: not of discs, which have names.
    pub fn of(kind: SceneKind) -> Self {
        match kind {
            SceneKind::Finger => Layout::finger(),
            SceneKind::Bodies => Layout::default(),
            SceneKind::Gripper => Layout::gripper(),
        }
    }

    /// Of one finger: its contacts in the order of [`Site::ALL`].
    pub fn finger() -> Self {
        let place = |site: Site| Place { name: site.name().to_string(), angular: site == Site::Limit };
        Layout { fingers: vec![String::new()], bodies: Vec::new(), contacts: Site::ALL.map(place).to_vec() }
    }

    /// Of discs and pairs of these names.
    pub fn discs(bodies: Vec<String>, pairs: Vec<String>) -> Self {
        let contacts = pairs.into_iter().map(|name| Place { name, angular: false }).collect();
        Layout { fingers: Vec::new(), bodies, contacts }
    }

    /// Of a gripper: its contacts in the order of [`scene::Place::ALL`](crate::scene::Place::ALL).
    pub fn gripper() -> Self {
        let place = |place: scene::Place| Place { name: place.name(), angular: place.is_stop() };
        Layout {
            fingers: Side::BOTH.map(|side| side.word().to_string()).to_vec(),
            bodies: vec!["object".to_string()],
            contacts: scene::Place::ALL.map(place).to_vec(),
        }
    }

    /// The contacts between surfaces, by their index: all but the stops of joints.
    pub fn surfaces(&self) -> impl Iterator<Item = usize> + '_ {
        self.contacts.iter().enumerate().filter(|(_, place)| !place.angular).map(|(index, _)| index)
    }
}
