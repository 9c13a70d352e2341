//! Contacts and values of a run that the invariants are measured on.

use super::measure::{ContactValues, MonitoredContact};
use super::momentum::{FreeBody, MomentumBalance};
use super::{Invariant, Invariants, Tolerances};
use crate::law::{FrictionLaw, NormalLaw};
use crate::scene::{ContactId, DiscMotion, Scene, Side, System};
use crate::trace::{BodyState, ContactSample, Event, FingerState, Model, Sample, Sink, SinkError};

impl Invariants {
    /// Measures a run of `scene` with `model`, with the tolerances of its settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let system = &scene.system;
        // Discs have no joints that could open.
        let loop_gap_m = if system.fingers.is_empty() { 0.0 } else { scene.bounds.loop_gap_m };
        let tolerances = Tolerances::for_settings(model, &scene.integrator, &scene.engine, loop_gap_m);
        // Momentum is not conserved in a moving frame. The engine's forces are averages over steps, so their impulses
        // between samples are not known accurately enough.
        let free_object = object(system).filter(|_| system.palm_motion.is_none() && model == Model::Analytic);
        let momentum_balance =
            free_object.map(|(body, friction_laws)| MomentumBalance::new(tolerances.energy, body, friction_laws));
        Self::with_contacts(model, tolerances, monitored_contacts(system), momentum_balance)
    }
}

/// All contacts of a system.
fn monitored_contacts(system: &System) -> Vec<MonitoredContact> {
    let surface = |name: String, (law, friction): (NormalLaw, Option<FrictionLaw>)| MonitoredContact {
        name,
        law,
        friction,
        depth: Invariant::Penetration,
        reach_m: 1.0,
    };
    let stop = |name: String, side: Side| {
        let (law, reach_m) = (system.finger(side).limit?, system.finger(side).linkage.lengths.l22_m);
        Some(MonitoredContact { name, law, friction: None, depth: Invariant::JointLimit, reach_m })
    };
    let monitored = |contact| match contact {
        ContactId::Stop(side) => stop(system.contact_name(contact), side),
        _ => system.contact_laws(contact).map(|law| surface(system.contact_name(contact), law)),
    };
    system.contact_ids().into_iter().filter_map(monitored).collect()
}

/// Returns a free object that is the only disc, and the friction law of every contact.
fn object(system: &System) -> Option<(FreeBody, Vec<Option<FrictionLaw>>)> {
    let object = system.object().filter(|_| system.discs.len() == 1)?;
    let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } = object.motion else {
        return None;
    };
    let friction_laws = system
        .contact_ids()
        .into_iter()
        .map(|touching| system.contact_laws(touching).and_then(|(_, friction)| friction));
    Some((FreeBody { mass_kg, inertia_kg_m2, gravity_m_s2: system.gravity_m_s2 }, friction_laws.collect()))
}

impl Sink for Invariants {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        // An infinite gap belongs to a contact that the scene does not have.
        let existing = sample.contacts.iter().filter(|contact| contact.gap_m != f64::INFINITY);
        let non_finite = non_finite(sample);
        self.record(sample.time_s, non_finite, &sample.energy, existing.map(contact_values));
        if non_finite == 0 {
            self.momentum(sample);
        }
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

fn contact_values(contact: &ContactSample) -> ContactValues {
    let ContactSample { gap_m, gap_rate_m_s, normal_n, tangential_n, slip_m_s, impulse_n_s, .. } = *contact;
    ContactValues { gap_m, gap_rate_m_s, normal_n, tangential_n, slip_m_s, impulse_n_s }
}

/// Number of values that are not finite.
fn non_finite(sample: &Sample) -> usize {
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

/// All numbers of a contact. An infinite gap belongs to a missing contact and is omitted.
fn numbers(contact: &ContactSample) -> impl Iterator<Item = f64> {
    let ContactSample { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal } =
        *contact;
    let scalars = [gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s];
    scalars.into_iter().chain(point_m).chain(normal).chain(Some(gap_m).filter(|gap| *gap != f64::INFINITY))
}
