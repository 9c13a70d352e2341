//! Runs the analytic model of a mechanism, and converts its states to samples.

use std::cell::RefCell;

use super::reading::{Reader, contact_sample, stored_energy};
use super::schema::{Schema, TendonState};
use super::simulate::simulate;
use super::{BodyState, ContactSample, Counts, Energy, JointState, Outcome, RequiredData, RunError, Sample, Sink};
use crate::analytic::mechanism::{MechanismMode, MechanismModel, MechanismSize};
use crate::integrator::State;
use crate::mechanism::structure::StructureError;
use crate::mechanism::{JointKind, Mechanism, assemble};
use crate::numeric::plane::nearest_equivalent_angle;
use crate::scene::Scene;

/// Sizes of mechanisms that the model is compiled for; the last one is the largest.
const SIZES: [MechanismSize; 3] = [
    MechanismSize { coordinates: 8, group: 3, contacts: 12, actuators: 8 },
    MechanismSize { coordinates: 8, group: 3, contacts: 32, actuators: 8 },
    MechanismSize { coordinates: 24, group: 12, contacts: 64, actuators: 8 },
];

/// Runs a scene of a mechanism.
pub(super) fn run_mechanism(scene: &Scene, mechanism: &Mechanism, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let rejected = |reason: String| RunError::rejected(reason, Outcome::default());
    let size = MechanismSize::new(mechanism).map_err(|error| rejected(error.to_string()))?;
    if size.fits(&SIZES[0]) {
        run_sized::<8, 3, 12, 14, 45>(scene, mechanism, sink)
    } else if size.fits(&SIZES[1]) {
        run_sized::<8, 3, 32, 34, 105>(scene, mechanism, sink)
    } else if size.fits(&SIZES[2]) {
        run_sized::<24, 12, 64, 66, 201>(scene, mechanism, sink)
    } else {
        let [.., largest] = SIZES;
        Err(rejected(format!(
            "the mechanism has {} coordinates ({} in its largest group of connected bodies), {} contacts and {} \
             actuators; the analytic model takes up to {} ({}), {} and {}: simplify it, or simulate with `--model engine`, \
             which takes any number",
            size.coordinates,
            size.group,
            size.contacts,
            size.actuators,
            largest.coordinates,
            largest.group,
            largest.contacts,
            largest.actuators
        )))
    }
}

/// Runs a mechanism with the model of one size.
fn run_sized<const N: usize, const K: usize, const C: usize, const Z: usize, const G: usize>(
    scene: &Scene,
    mechanism: &Mechanism,
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError> {
    let rejected = |reason: String| RunError::rejected(reason, Outcome::default());
    let start = assemble(mechanism).map_err(|error| rejected(error.to_string()))?;
    let model = MechanismModel::<N, K, C>::new(mechanism, (&start.poses, &start.rates))
        .map_err(|error: StructureError| rejected(error.to_string()))?;
    let reader = MechanismReader {
        model: &model,
        mechanism,
        counts: Schema::from_scene(scene).counts(),
        angles: RefCell::new(Angles { time_s: 0.0, values: Vec::new() }),
    };
    let start = model.start::<Z>();
    simulate::<_, _, N, Z, G>(&model, &reader, start, &scene.integrator, (scene, None), sink)
}

/// Angles and rates of all joints, then of all bodies, at the last reading.
struct Angles {
    time_s: f64,
    values: Vec<(f64, f64)>,
}

/// A model with its mechanism. Whole turns of dyads do not follow from a state; readings count them from one to the
/// next.
struct MechanismReader<'a, const N: usize, const K: usize, const C: usize> {
    model: &'a MechanismModel<N, K, C>,
    mechanism: &'a Mechanism,
    counts: Counts,
    angles: RefCell<Angles>,
}

impl<const N: usize, const K: usize, const C: usize> MechanismReader<'_, N, K, C> {
    /// Returns the angle that continues the last reading of this index, at the rate of both readings.
    fn continued(&self, index: usize, t: f64, angle: f64, rate: f64) -> f64 {
        let mut angles = self.angles.borrow_mut();
        let dt = t - angles.time_s;
        match angles.values.get_mut(index) {
            Some((last, last_rate)) => {
                let continued = nearest_equivalent_angle(angle, *last + 0.5 * dt * (*last_rate + rate));
                (*last, *last_rate) = (continued, rate);
                continued
            }
            None => {
                angles.values.push((angle, rate));
                angle
            }
        }
    }
}

impl<const N: usize, const K: usize, const C: usize, const Z: usize> Reader<N, Z> for MechanismReader<'_, N, K, C> {
    type Mode = MechanismMode<C>;

    fn read(
        &self,
        t: f64,
        state: &State<N, Z>,
        mode: &MechanismMode<C>,
        start: &Energy,
        required_data: RequiredData,
        sample: &mut Sample,
    ) {
        let (model, qv) = (self.model, (&state.q, &state.v));
        sample.prepare(t, self.counts);
        let forces = match required_data.joint_forces {
            true => model.joint_forces::<Z>(t, qv, mode),
            false => Vec::new(),
        };
        for (index, joint) in self.mechanism.joints.iter().enumerate() {
            let (coordinate, rate) = model.joint(qv, index);
            let continued = self.continued(index, t, coordinate, rate);
            let angle_rad = if joint.kind == JointKind::Revolute { continued } else { coordinate };
            let force = forces.get(index).copied().unwrap_or_default();
            let (force_n, moment_n_m) = (force.force_n, force.moment_n_m);
            sample.set_joint(index, &JointState { angle_rad, rate_rad_s: rate, force_n, moment_n_m });
        }
        for index in 0..self.counts.actuators {
            let effort = if required_data.passive { model.actuator(t, qv, mode, index) } else { 0.0 };
            sample.set_actuator(index, effort);
        }
        for index in 0..self.counts.tendons {
            let [length_m, rate_m_s, tension_n] = model.tendon(t, qv, mode, index);
            sample.set_tendon(index, &TendonState { length_m, rate_m_s, tension_n });
        }
        for body in 0..self.counts.bodies {
            let ([x, y, angle], [vx, vy, spin_rad_s]) = model.body(qv, body);
            let angle_rad = self.continued(self.counts.joints + body, t, angle, spin_rad_s);
            sample.set_body(body, &BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s });
        }
        self.angles.borrow_mut().time_s = t;
        (0..self.counts.contacts).for_each(|index| sample.set_contact(index, &self.contact(state, index, mode)));
        sample.set_energy(&match required_data.energies {
            true => stored_energy(&model.energies(qv)).relative_to(start, state.z[C], state.z[C + 1]),
            false => Energy::default(),
        });
    }

    fn is_slipping(&self, index: usize, mode: &MechanismMode<C>) -> Option<bool> {
        mode.contacts.is_slipping(index).filter(|_| self.model.has_stiction(index))
    }

    fn contact(&self, state: &State<N, Z>, index: usize, mode: &MechanismMode<C>) -> ContactSample {
        let reading = self.model.contact_reading((&state.q, &state.v), index, mode[index]);
        contact_sample(Some(&reading), state.z[index])
    }
}
