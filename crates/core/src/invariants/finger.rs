//! Runs of a finger.

use super::measure::{Place, Reading};
use super::{Invariant, Invariants, Tolerances};
use crate::scene::Scene;
use crate::trace::{ContactSample, Event, Model, Sample, Sink, SinkError};

impl Invariants {
    /// For a run of `scene` with `model`, held to the tolerances of its settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let mut places = Vec::new();
        if scene.object.is_some() {
            for (name, law) in [("proximal", scene.contact.proximal), ("distal", scene.contact.distal)] {
                let (normal, friction) = (law.normal, law.friction);
                places.push(Place {
                    name: name.to_string(),
                    law: normal,
                    friction,
                    depth: Invariant::Penetration,
                    reach_m: 1.0,
                });
            }
        }
        if let Some(law) = scene.limit {
            let depth = Invariant::JointLimit;
            let reach_m = scene.finger.lengths.l22_m;
            places.push(Place { name: "limit".to_string(), law, friction: None, depth, reach_m });
        }
        let tolerances = Tolerances::of(model, &scene.integrator, &scene.engine, scene.bounds.loop_gap_m);
        Self::watching(model, tolerances, places)
    }
}

impl Sink for Invariants {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let Sample { proximal, distal, limit, .. } = sample;
        // A gap to nothing is infinite: that place is not watched.
        let there = |gap: f64| gap != f64::INFINITY;
        let contacts = [proximal, distal, limit].into_iter().filter(|contact| there(contact.gap_m)).map(contact);
        self.look(sample.time_s, strange(sample), &sample.energy, contacts);
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

pub(super) fn contact(contact: &ContactSample) -> Reading {
    let ContactSample { gap_m, gap_rate_m_s, normal_n, tangential_n, slip_m_s, impulse_n_s, .. } = *contact;
    Reading { gap_m, gap_rate_m_s, normal_n, tangential_n, slip_m_s, impulse_n_s }
}

/// How many numbers are none.
fn strange(sample: &Sample) -> usize {
    let Sample { proximal, distal, limit, energy, .. } = sample;
    let angles = [sample.q11_rad, sample.q21_rad, sample.q12_rad, sample.q22_rad, sample.q13_rad];
    let rates = [sample.qd11_rad_s, sample.qd21_rad_s, sample.qd12_rad_s, sample.qd22_rad_s];
    let plain = [sample.time_s, sample.motor_torque_n_m].into_iter().chain(angles).chain(rates);
    let contacts = [proximal, distal, limit].into_iter().flat_map(numbers);
    plain.chain(energy.values_j()).chain(contacts).filter(|number| !number.is_finite()).count()
}

/// All numbers of a contact; an infinite gap is one to nothing and is left out.
pub(super) fn numbers(contact: &ContactSample) -> impl Iterator<Item = f64> {
    let ContactSample { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal } =
        *contact;
    let scalars = [gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s];
    scalars.into_iter().chain(point_m).chain(normal).chain(Some(gap_m).filter(|gap| *gap != f64::INFINITY))
}
