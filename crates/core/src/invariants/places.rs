//! What is watched of a run, by its scene and of every sample.

use super::measure::{Place, Reading};
use super::momentum::{Books, Free};
use super::{Invariant, Invariants, Tolerances};
use crate::law::{ContactLaw, FrictionLaw};
use crate::scene::{self, BodiesScene, GripperScene, ObjectMotion, Scene};
use crate::trace::{BodyState, ContactSample, Event, FingerState, Model, Sample, Simulated, Sink, SinkError, Site};

impl Invariants {
    /// For a run of `scene` with `model`, held to the tolerances of its settings.
    pub fn new<'a>(model: Model, scene: impl Into<Simulated<'a>>) -> Self {
        let scene = scene.into();
        let (places, loop_gap_m, free) = match scene {
            Simulated::Finger(scene) => (of_finger(scene), scene.bounds.loop_gap_m, None),
            // Discs have no joints that could open.
            Simulated::Discs(scene) => (of_discs(scene), 0.0, None),
            // In a frame that moves, momentum is not kept.
            Simulated::Gripper(scene) => {
                let free = object(scene).filter(|_| scene.palm_motion.is_none());
                (of_gripper(scene), scene.bounds.loop_gap_m, free)
            }
        };
        let tolerances = Tolerances::of(model, scene.integrator(), scene.engine(), loop_gap_m);
        // The engine's forces are means of its steps: what they gave between samples no sample says to these bounds.
        let free = free.filter(|_| model == Model::Analytic);
        let books = free.map(|(free, frictions)| Books::new(tolerances.energy, free, frictions));
        Self::watching(model, tolerances, places, books)
    }
}

fn of_finger(scene: &Scene) -> Vec<Place> {
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
    places
}

fn of_gripper(scene: &GripperScene) -> Vec<Place> {
    let place = |place: scene::Place| {
        let surface = |law: ContactLaw| (law.normal, law.friction, Invariant::Penetration, 1.0);
        let (law, friction, depth, reach_m) = match place {
            scene::Place::Finger(side, Site::Proximal) => surface(scene.finger(side).contact.proximal),
            scene::Place::Finger(side, Site::Distal) => surface(scene.finger(side).contact.distal),
            scene::Place::Finger(side, Site::Limit) => {
                let finger = scene.finger(side);
                (finger.limit?, None, Invariant::JointLimit, finger.finger.lengths.l22_m)
            }
            scene::Place::Palm => surface(scene.palm?),
            scene::Place::Table => surface(scene.table?.contact),
        };
        Some(Place { name: place.name(), law, friction, depth, reach_m })
    };
    scene::Place::ALL.into_iter().filter_map(place).collect()
}

/// An object that is free, and the friction of every contact.
fn object(scene: &GripperScene) -> Option<(Free, Vec<Option<FrictionLaw>>)> {
    let ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } = scene.object.motion else { return None };
    let frictions = scene::Place::ALL.map(|place| match place {
        scene::Place::Finger(side, Site::Proximal) => scene.finger(side).contact.proximal.friction,
        scene::Place::Finger(side, Site::Distal) => scene.finger(side).contact.distal.friction,
        scene::Place::Finger(_, Site::Limit) => None,
        scene::Place::Palm => scene.palm.and_then(|law| law.friction),
        scene::Place::Table => scene.table.and_then(|table| table.contact.friction),
    });
    Some((Free { mass_kg, inertia_kg_m2, gravity_m_s2: scene.gravity_m_s2 }, frictions.to_vec()))
}

fn of_discs(scene: &BodiesScene) -> Vec<Place> {
    let place = |pair| Place {
        name: scene.pair_name(pair),
        law: scene.contact.normal,
        friction: scene.contact.friction,
        depth: Invariant::Penetration,
        reach_m: 1.0,
    };
    scene.pairs().into_iter().map(place).collect()
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
