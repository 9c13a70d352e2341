//! Removal of contacts: what a body touches is taken away during a run.

use super::contacts::Surfaces;
use super::model::{MechanismMode, MechanismModel};
use super::nearest::Face;
use crate::analytic::contact::ContactMode;
use crate::mechanism::OutlineShape;

/// Distance of surfaces that are removed, m: farther than any motion.
const REMOVED_M: f64 = 1e4;

impl MechanismModel {
    /// Removes contacts between surfaces, from this state on, by moving their faces far away.
    pub fn remove_contacts(&mut self, contacts: &[usize], v: &mut [f64], mode: &mut MechanismMode) {
        let far = OutlineShape::HalfPlane { point_m: [0.0, -REMOVED_M], normal: [0.0, 1.0] };
        for &index in contacts {
            let contact = &mut self.contacts[index];
            let Surfaces::Point(pair) = &mut contact.surfaces else { continue };
            (pair.face, pair.bodies[1]) = (Face::new(&far), None);
            contact.state.into_iter().for_each(|state| v[state] = 0.0);
            mode.contacts.contacts[index] = ContactMode::FREE;
            mode.features[index] = None;
        }
    }
}
