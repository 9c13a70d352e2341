//! Contacts and values of a run that the invariants are measured on.

use super::measure::MonitoredContact;
use super::momentum::{FreeBody, MomentumBalance};
use super::{Invariant, Invariants, Tolerances};
use crate::law::{FrictionLaw, NormalLaw};
use crate::scene::{ContactId, DiscMotion, Scene, Side, System};
use crate::trace::{Channels, ContactSample, Model, Sample, Sink, SinkError};

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
        self.record(sample.time_s, non_finite, &sample.energy, existing);
        if non_finite == 0 {
            self.momentum(sample);
        }
        Ok(())
    }
}

/// Number of values that are not finite. An infinite gap belongs to a missing contact and does not count.
fn non_finite(sample: &Sample) -> usize {
    let fingers = sample.fingers.iter().flat_map(Channels::values);
    let bodies = sample.bodies.iter().flat_map(Channels::values);
    let contacts = sample.contacts.iter().flat_map(|contact| {
        let gap_m = if contact.gap_m == f64::INFINITY { 0.0 } else { contact.gap_m };
        ContactSample { gap_m, ..*contact }.values()
    });
    let all = fingers.chain(bodies).chain(contacts).chain(sample.energy.values()).chain([sample.time_s]);
    all.filter(|number| !number.is_finite()).count()
}
