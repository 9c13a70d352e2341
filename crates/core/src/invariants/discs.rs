//! Runs of discs.

use super::finger::{contact, numbers};
use super::measure::Place;
use super::{Invariant, Invariants, Tolerances};
use crate::scene::BodiesScene;
use crate::trace::bodies::{BodiesEvent, BodiesSample, DiscState};
use crate::trace::{Model, Sink, SinkError};

impl Invariants {
    /// For a run of a scene of discs with `model`, held to the tolerances of its settings.
    pub fn of_discs(model: Model, scene: &BodiesScene) -> Self {
        let place = |pair| Place {
            name: scene.pair_name(pair),
            law: scene.contact.normal,
            friction: scene.contact.friction,
            depth: Invariant::Penetration,
            reach_m: 1.0,
        };
        let places = scene.pairs().into_iter().map(place).collect();
        // Discs have no joints that could open.
        Self::watching(model, Tolerances::of(model, &scene.integrator, &scene.engine, 0.0), places)
    }
}

impl Sink<BodiesSample> for Invariants {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        let places = sample.discs.iter().flat_map(|disc| {
            let DiscState { centre_m: [x, y], angle_rad, velocity_m_s: [u, v], spin_rad_s } = *disc;
            [x, y, angle_rad, u, v, spin_rad_s]
        });
        let contacts = sample.contacts.iter().flat_map(numbers);
        let all = places.chain(contacts).chain(sample.energy.values_j()).chain([sample.time_s]);
        let strange = all.filter(|number| !number.is_finite()).count();
        self.look(sample.time_s, strange, &sample.energy, sample.contacts.iter().map(contact));
        Ok(())
    }

    fn event(&mut self, _: &BodiesEvent) -> Result<(), SinkError> {
        Ok(())
    }
}
