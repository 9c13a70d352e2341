//! What is watched of a run, by its scene and of every sample.

use super::measure::{Place, Reading};
use super::momentum::{Books, Free};
use super::{Invariant, Invariants, Tolerances};
use crate::law::{FrictionLaw, NormalLaw};
use crate::scene::{DiscMotion, Scene, Side, System, Touching};
use crate::trace::{BodyState, ContactSample, Event, FingerState, Model, Sample, Sink, SinkError};

impl Invariants {
    /// For a run of `scene` with `model`, held to the tolerances of its settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let system = &scene.system;
        // Discs have no joints that could open.
        let loop_gap_m = if system.fingers.is_empty() { 0.0 } else { scene.bounds.loop_gap_m };
        let tolerances = Tolerances::of(model, &scene.integrator, &scene.engine, loop_gap_m);
        // In a frame that moves, momentum is not kept. The engine's forces are means of its steps: what they gave between samples no
        // sample says to these bounds.
        let free = object(system).filter(|_| system.palm_motion.is_none() && model == Model::Analytic);
        let books = free.map(|(free, frictions)| Books::new(tolerances.energy, free, frictions));
        Self::watching(model, tolerances, places(system), books)
    }
}

/// Every place at which something can press.
fn places(system: &System) -> Vec<Place> {
    let surface = |name: String, (law, friction): (NormalLaw, Option<FrictionLaw>)| Place {
        name,
        law,
        friction,
        depth: Invariant::Penetration,
        reach_m: 1.0,
    };
    let stop = |name: String, side: Side| {
        let (law, reach_m) = (system.finger(side).limit?, system.finger(side).linkage.lengths.l22_m);
        Some(Place { name, law, friction: None, depth: Invariant::JointLimit, reach_m })
    };
    let place = |touching| match touching {
        Touching::Stop(side) => stop(system.touching_name(touching), side),
        _ => system.laws(touching).map(|law| surface(system.touching_name(touching), law)),
    };
    system.touching().into_iter().filter_map(place).collect()
}

/// An object that is free and alone, and the friction of every contact.
fn object(system: &System) -> Option<(Free, Vec<Option<FrictionLaw>>)> {
    let object = system.object().filter(|_| system.discs.len() == 1)?;
    let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } = object.motion else {
        return None;
    };
    let frictions =
        system.touching().into_iter().map(|touching| system.laws(touching).and_then(|(_, friction)| friction));
    Some((Free { mass_kg, inertia_kg_m2, gravity_m_s2: system.gravity_m_s2 }, frictions.collect()))
}

impl Sink for Invariants {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        // A gap to nothing is infinite: that place is not watched.
        let there = sample.contacts.iter().filter(|contact| contact.gap_m != f64::INFINITY);
        let strange = strange(sample);
        self.look(sample.time_s, strange, &sample.energy, there.map(reading));
        if strange == 0 {
            self.momentum(sample);
        }
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

fn reading(contact: &ContactSample) -> Reading {
    let ContactSample { gap_m, gap_rate_m_s, normal_n, tangential_n, slip_m_s, impulse_n_s, .. } = *contact;
    Reading { gap_m, gap_rate_m_s, normal_n, tangential_n, slip_m_s, impulse_n_s }
}

/// How many numbers are none.
fn strange(sample: &Sample) -> usize {
    let fingers = sample.fingers.iter().flat_map(|finger| {
        let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, motor_torque_n_m, .. } = *finger;
        let FingerState { qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, .. } = *finger;
        let angles = [q11_rad, q21_rad, q12_rad, q22_rad, q13_rad];
        angles.into_iter().chain([qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, motor_torque_n_m])
    });
    let bodies = sample.bodies.iter().flat_map(|body| {
        let BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [u, v], spin_rad_s } = *body;
        [x, y, angle_rad, u, v, spin_rad_s]
    });
    let contacts = sample.contacts.iter().flat_map(numbers);
    let all = fingers.chain(bodies).chain(contacts).chain(sample.energy.values_j()).chain([sample.time_s]);
    all.filter(|number| !number.is_finite()).count()
}

/// All numbers of a contact; an infinite gap is one to nothing and is left out.
fn numbers(contact: &ContactSample) -> impl Iterator<Item = f64> {
    let ContactSample { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal } =
        *contact;
    let scalars = [gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s];
    scalars.into_iter().chain(point_m).chain(normal).chain(Some(gap_m).filter(|gap| *gap != f64::INFINITY))
}
