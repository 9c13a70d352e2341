//! Builds the analytic model of a mechanism, and converts its states to samples.

use super::reading::{Kernel, KernelUser, Start, contact_sample, stored_energy};
use super::schema::TendonState;
use super::{BodyState, ContactSample, Energy, Exit, JointState, Outcome, RequiredData, RunError, Sample};
use crate::analytic::mechanism::{JointForces, MechanismMode, MechanismModel, MechanismSize};
use crate::drive::Profile;
use crate::integrator::{State, System};
use crate::mechanism::structure::StructureError;
use crate::mechanism::{Mechanism, assemble};
use crate::scene::Scene;

/// Builds the model in the first size that fits, of coordinates, coordinates of a group, contacts and actuators.
macro_rules! build_fitting {
    ($size:ident, $arguments:tt, $([$n:literal, $k:literal, $c:literal, $a:literal]),+) => {
        $(if $size.fits(&MechanismSize { coordinates: $n, group: $k, contacts: $c, actuators: $a, counts: $c }) {
            return build_sized::<$n, $k, $c, { $c + 2 }, U> $arguments;
        })+
    };
}

/// Builds the model of a mechanism.
pub(super) fn build_mechanism<U: KernelUser>(
    scene: &Scene,
    mechanism: &Mechanism,
    user: U,
) -> Result<U::Output, RunError> {
    let rejected = |reason: String| RunError::rejected(reason, Outcome::default());
    let size = MechanismSize::new(mechanism).map_err(|error| rejected(error.to_string()))?;
    build_fitting!(
        size,
        (scene, mechanism, user),
        [3, 2, 5, 1],
        [8, 2, 8, 2],
        [9, 1, 8, 0],
        [14, 3, 12, 2],
        [9, 3, 32, 2],
        [16, 5, 12, 2],
        [24, 4, 24, 2],
        [48, 12, 64, 8]
    );
    Err(rejected(too_large(mechanism, &size)))
}

/// Largest model; also the last size of [`build_mechanism`].
const LARGEST: MechanismSize = MechanismSize { coordinates: 48, group: 12, contacts: 64, actuators: 8, counts: 64 };

/// Reason for the rejection of a mechanism that exceeds the largest model, with the remedies that help.
fn too_large(mechanism: &Mechanism, size: &MechanismSize) -> String {
    let MechanismSize { coordinates, group, contacts, actuators, counts } = *size;
    if counts > LARGEST.counts {
        return format!(
            "the mechanism has {counts} dyads; the analytic model counts the turns of up to {}: simulate with \
             `--model engine`, which takes any number",
            LARGEST.counts
        );
    }
    let has_bristles = mechanism.contacts.iter().any(|pair| pair.law.bristle().is_some());
    let remedies = [
        (coordinates > LARGEST.coordinates && has_bristles, "give some contacts a law of friction without bristles"),
        (contacts > LARGEST.contacts, "list fewer pairs of outlines"),
        (true, "simulate with `--model engine`, which takes any number"),
    ];
    let remedies: Vec<&str> = remedies.into_iter().filter(|(helps, _)| *helps).map(|(_, remedy)| remedy).collect();
    format!(
        "the mechanism has {coordinates} coordinates with those of time and bristles ({group} in its largest group of connected \
         bodies), {contacts} contacts and {actuators} actuators; the analytic model takes up to {} ({}), {} and {}: {}",
        LARGEST.coordinates,
        LARGEST.group,
        LARGEST.contacts,
        LARGEST.actuators,
        remedies.join(", or ")
    )
}

/// Builds the model of one size.
fn build_sized<const N: usize, const K: usize, const C: usize, const Z: usize, U: KernelUser>(
    scene: &Scene,
    mechanism: &Mechanism,
    user: U,
) -> Result<U::Output, RunError> {
    let rejected = |reason: String| RunError::rejected(reason, Outcome::default());
    let start = assemble(mechanism).map_err(|error| rejected(error.to_string()))?;
    let kernel = MechanismModel::<N, K, C>::new(mechanism, (&start.poses, &start.rates))
        .map_err(|error: StructureError| rejected(error.to_string()))?;
    let state = kernel.start::<Z>();
    let (settings, exit) = (scene.integrator, Exit::from_scene(scene));
    Ok(user.use_kernel::<_, N, Z>(Start { kernel, state, settings, exit }))
}

impl<const N: usize, const K: usize, const C: usize, const Z: usize> Kernel<N, Z> for MechanismModel<N, K, C>
where
    Self: System<N, Z, Mode = MechanismMode<C>>,
{
    type History = JointForces;

    fn read(
        &self,
        (state, mode): (&State<N, Z>, &MechanismMode<C>),
        start: &Energy,
        required_data: RequiredData,
        joint_forces: &mut Self::History,
        sample: &mut Sample,
    ) {
        let (model, t, counts, qv) = (self, sample.time_s, sample.counts(), (&state.q, &state.v));
        model.count_turns_as(mode);
        if required_data.joint_forces {
            model.joint_forces::<Z>(t, qv, mode, joint_forces);
        }
        for index in 0..counts.joints {
            let (angle_rad, rate_rad_s) = model.joint(qv, index);
            let force = joint_forces.forces.get(index).copied().unwrap_or_default();
            let (force_n, moment_n_m) = (force.force_n, force.moment_n_m);
            sample.set_joint(index, &JointState { angle_rad, rate_rad_s, force_n, moment_n_m });
        }
        for index in 0..counts.actuators {
            let effort = if required_data.passive { model.actuator(t, qv, mode, index) } else { 0.0 };
            sample.set_actuator(index, effort);
        }
        for index in 0..counts.tendons {
            let [length_m, rate_m_s, tension_n] = model.tendon(t, qv, mode, index);
            sample.set_tendon(index, &TendonState { length_m, rate_m_s, tension_n });
        }
        for (index, body) in model.reported_bodies().enumerate() {
            let ([x, y, angle_rad], [vx, vy, spin_rad_s]) = model.body(qv, body);
            sample.set_body(index, &BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s });
        }
        (0..counts.contacts).for_each(|index| sample.set_contact(index, &self.contact(state, index, mode)));
        sample.set_energy(&match required_data.energies {
            true => {
                let work = state.z[C + 1] + model.frame_work(qv);
                let gap = |index: usize| (index < counts.contacts).then(|| sample.contact(index).gap_m);
                stored_energy(&model.energies_at_gaps(qv, gap)).relative_to(start, state.z[C], work)
            }
            false => Energy::default(),
        });
    }

    fn is_slipping(&self, index: usize, mode: &MechanismMode<C>) -> Option<bool> {
        mode.contacts.is_slipping(index).filter(|_| self.has_stiction(index))
    }

    fn contact_count(&self) -> usize {
        C
    }

    fn contact(&self, state: &State<N, Z>, index: usize, mode: &MechanismMode<C>) -> ContactSample {
        self.count_turns_as(mode);
        let reading = self.contact_reading((&state.q, &state.v), index, mode[index]);
        contact_sample(Some(&reading), state.z[index])
    }

    fn set_input(
        &mut self,
        index: usize,
        input: Profile,
        t: f64,
        (state, mode): (&mut State<N, Z>, &mut MechanismMode<C>),
    ) {
        self.set_input(index, input, t, (&mut state.q, &mut state.v), mode);
    }

    fn conditioning(&self, state: &State<N, Z>, mode: &MechanismMode<C>) -> f64 {
        self.conditioning((&state.q, &state.v), mode)
    }

    fn exchanged(&self, state: &State<N, Z>, mode: &MechanismMode<C>) -> Option<(Self, State<N, Z>, MechanismMode<C>)> {
        let (kernel, (q, v), mode) = self.exchanged((&state.q, &state.v), mode)?;
        Some((kernel, State { q, v, ..*state }, mode))
    }

    fn has_coordinates_of(&self, other: &Self) -> bool {
        self.has_coordinates_of(other)
    }
}
