//! Contacts of a mechanism: between surfaces, with the limits of joints, along tendons, and the friction of joints and cables.

use super::cable::Cable;
use super::nearest::{Face, PointOnFace};
use crate::law::{FrictionKind, FrictionLaw, NormalLaw};
use crate::mechanism::{Limit, Mechanism};
use std::cell::Cell;

/// The two surfaces of a contact, the limit of a joint, a tendon, or the friction of a joint or cable.
#[derive(Clone, Debug)]
pub(super) enum Surfaces {
    Point(PointOnFace),
    Limit(Limit),
    /// A cable with a spring or a damper, by its index: the depth is its elongation.
    Tendon(usize),
    /// Friction of a joint, by its index, under a normal force of 1.
    Friction(usize),
    /// Friction of a cable on a path element, by their indices, under a normal force of 1.
    Cable(usize, usize),
}

#[derive(Clone, Debug)]
pub(super) struct Contact {
    pub surfaces: Surfaces,
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Law of rolling resistance, for a contact between surfaces.
    pub rolling: Option<FrictionLaw>,
    /// Index of the internal state of friction among the rates; `None` if the law has no state.
    pub state: Option<usize>,
    /// See [`ContactPair::is_reported_on_face`](crate::mechanism::ContactPair::is_reported_on_face).
    pub is_reported_on_face: bool,
}

impl Contact {
    /// A contact without friction.
    fn frictionless(surfaces: Surfaces, normal: NormalLaw) -> Self {
        let (friction, rolling, state, is_reported_on_face) = (None, None, None, false);
        Self { surfaces, normal, friction, rolling, state, is_reported_on_face }
    }
}

/// Internal states of friction laws among the rates, in the order in which they are added.
pub(super) struct FrictionStates {
    first: usize,
    states: Vec<(usize, FrictionKind)>,
}

impl FrictionStates {
    /// Creates an empty list; `first` is the index of its first state among the rates.
    pub fn after(first: usize) -> Self {
        Self { first, states: Vec::new() }
    }

    /// Returns the index of the next state to be added.
    pub fn next(&self) -> usize {
        self.first + self.states.len()
    }

    /// Adds the state of a law and returns its index; `None` if the law has no state.
    pub fn add(&mut self, kind: Option<FrictionKind>) -> Option<usize> {
        let index = self.next();
        self.states.push((index, kind.filter(|kind| kind.states() > 0)?));
        Some(index)
    }

    /// All laws with the indices of their states.
    pub fn into_states(self) -> Vec<(usize, FrictionKind)> {
        self.states
    }
}

/// All contacts in the order of [`Mechanism::point_contacts`], of [`Mechanism::limits`], of the tendons, of friction in
/// joints, then of friction of cables. Adds the internal states of their friction, and the contacts of cables to these.
pub(super) fn contacts(mechanism: &Mechanism, cables: &mut [Cable], states: &mut FrictionStates) -> Vec<Contact> {
    let mut contacts = Vec::new();
    for point in mechanism.point_contacts() {
        let pair = &mechanism.contacts[point.pair];
        let surfaces = Surfaces::Point(PointOnFace {
            bodies: [point.body, pair.face.body],
            point: point.point,
            face: Face::new(&mechanism.outline(pair.face).shape),
            force_point: pair.force_point,
            nearest_before: Cell::new(None),
        });
        contacts.push(Contact {
            surfaces,
            normal: pair.law.normal,
            friction: pair.law.friction,
            rolling: pair.rolling,
            state: states.add(pair.law.friction.map(|law| law.kind)),
            is_reported_on_face: pair.is_reported_on_face,
        });
    }
    let limits = mechanism.limits().into_iter();
    contacts.extend(limits.map(|limit| Contact::frictionless(Surfaces::Limit(limit), limit.law)));
    for (index, normal) in elastic_tendons(mechanism) {
        cables[index].contact = Some(contacts.len());
        contacts.push(Contact::frictionless(Surfaces::Tendon(index), normal));
    }
    for (joint, law) in joint_frictions(mechanism) {
        let contact = Contact::frictionless(Surfaces::Friction(joint), NormalLaw::constant_force(1.0));
        contacts.push(Contact { friction: Some(law), state: states.add(Some(law.kind)), ..contact });
    }
    for (index, cable) in cables.iter_mut().enumerate().filter(|(_, cable)| cable.tendon.has_friction()) {
        for (element, of) in cable.tendon.path.iter().enumerate() {
            cable.frictions.push(of.friction.map(|_| contacts.len()));
            let contact = Contact::frictionless(Surfaces::Cable(index, element), NormalLaw::constant_force(1.0));
            contacts.extend(of.friction.map(|law| Contact {
                friction: Some(law),
                state: states.add(Some(law.kind)),
                ..contact
            }));
        }
    }
    contacts
}

/// Joints with friction, with their laws.
fn joint_frictions(mechanism: &Mechanism) -> impl Iterator<Item = (usize, FrictionLaw)> {
    mechanism.joints.iter().enumerate().filter_map(|(index, joint)| Some((index, joint.friction?)))
}

/// Tendons with a spring or a damper, with their laws.
fn elastic_tendons(mechanism: &Mechanism) -> impl Iterator<Item = (usize, NormalLaw)> {
    mechanism.tendons.iter().enumerate().filter_map(|(index, tendon)| Some((index, tendon.law()?)))
}
