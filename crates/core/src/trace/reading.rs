//! Converts states of the analytic model to samples, and changes its inputs: the only parts of a run that differ between
//! its kernels.

use std::ops::Index;

use super::{ContactSample, Energy, Exit, FingerContact, FingerState, RequiredData, Sample};
use crate::analytic::{ContactReading, ContactState, Energies, FingerMode, FingerMotion, PassiveJoints};
use crate::drive::Profile;
use crate::integrator::{Hybrid, State, System};
use crate::scene::Integrator;

/// A kernel of the analytic model, as runs use it: its states become samples, and its inputs can change.
pub(crate) trait Kernel:
    System<Mode: Index<usize, Output = ContactState> + PartialEq + Send> + Clone + Send + 'static
{
    /// What a sample needs of earlier ones.
    type History: Clone + Default + Send;

    /// Reads the required data of one state into a sample, which is prepared for it; `start` contains the energies at
    /// the start of the run, the reference for work and dissipation.
    fn read(
        &self,
        state: (&State<Self::Layout>, &Self::Mode),
        start: &Energy,
        required_data: RequiredData,
        history: &mut Self::History,
        sample: &mut Sample,
    );

    /// Index of a contact of a sample among the contacts of the mode and the quadratures.
    fn contact_index(&self, contact: usize) -> usize {
        contact
    }

    /// Contact with an index among the `contacts` of a sample; `None` if samples do not contain it.
    fn sample_contact(&self, index: usize, contacts: usize) -> Option<usize> {
        (0..contacts).find(|contact| self.contact_index(*contact) == index)
    }

    /// Whether friction with stiction slips at a contact; `None` if the contact is inactive, has no stiction, or the mode does
    /// not record it.
    fn is_slipping(&self, index: usize, mode: &Self::Mode) -> Option<bool>;

    /// Number of contacts of the mode.
    fn contact_count(&self) -> usize;

    /// Reads one contact of a state.
    fn contact(&self, state: &State<Self::Layout>, index: usize, mode: &Self::Mode) -> ContactSample;

    /// Replaces the input of an actuator from time `t` on; state and mode follow where they depend on inputs.
    fn set_input(&mut self, index: usize, input: Profile, t: f64, state: (&mut State<Self::Layout>, &mut Self::Mode));

    /// Removes contacts between surfaces, by their indices among those of samples; state and mode follow. A finger has none that
    /// can be removed.
    fn remove_contacts(&mut self, _contacts: &[usize], _state: (&mut State<Self::Layout>, &mut Self::Mode)) {}

    /// How well the coordinates are conditioned in a state: at most 1, and 0 where they fail. At least the clearance of the
    /// integrator.
    fn conditioning(&self, _state: &State<Self::Layout>, _mode: &Self::Mode) -> f64 {
        f64::INFINITY
    }

    /// The kernel in coordinates that are much better conditioned in a state, with this state and its mode; `None` if there
    /// are none.
    fn exchanged(
        &self,
        _state: &State<Self::Layout>,
        _mode: &Self::Mode,
    ) -> Option<(Self, State<Self::Layout>, Self::Mode)> {
        None
    }

    /// This kernel in the coordinates of another one of the same structure, with a state and its mode in these; `None` if it has
    /// these coordinates.
    fn in_coordinates_of(
        &self,
        _other: &Self,
        _state: &State<Self::Layout>,
        _mode: &Self::Mode,
    ) -> Option<(Self, State<Self::Layout>, Self::Mode)> {
        None
    }

    /// Whether the states of another kernel of the same type have the same coordinates.
    fn has_coordinates_of(&self, _other: &Self) -> bool {
        true
    }
}

/// A scene in its kernel of the analytic model, at its start.
pub(crate) struct Start<M: System> {
    pub kernel: M,
    pub state: State<M::Layout>,
    pub settings: Integrator,
    pub exit: Option<Exit>,
}

/// A use of the kernel of a scene, whose type depends on the scene.
pub(crate) trait KernelUser {
    type Output;

    fn use_kernel<M: Kernel + Hybrid>(self, start: Start<M>) -> Self::Output;
}

/// Converts the energies of a state to those of a sample.
pub(super) fn stored_energy(energies: &Energies) -> Energy {
    Energy {
        kinetic_j: energies.kinetic,
        gravity_j: energies.gravity,
        spring_j: energies.spring,
        elastic_j: energies.elastic,
        ..Energy::default()
    }
}

/// Converts a contact reading to a sample; `None` is a contact that does not exist.
pub(super) fn contact_sample(reading: Option<&ContactReading>, impulse_n_s: f64) -> ContactSample {
    reading.map_or(ContactSample::NONE, |r| ContactSample {
        gap_m: -r.delta,
        gap_rate_m_s: -r.delta_rate,
        slip_m_s: r.slip,
        normal_n: r.normal,
        tangential_n: r.tangential,
        impulse_n_s,
        point_m: r.geometry.point,
        normal: r.geometry.normal,
    })
}

impl<const N: usize, const W: usize> Kernel for FingerMotion<N, W> {
    type History = ();

    fn read(
        &self,
        (state, mode): (&State<Self::Layout>, &FingerMode),
        start: &Energy,
        required_data: RequiredData,
        (): &mut (),
        sample: &mut Sample,
    ) {
        let (t, State { q, v, z }) = (sample.time_s, state);
        let terms = (required_data.energies || required_data.joint_forces).then(|| self.terms(q));
        let kinematics = match &terms {
            Some(terms) => (terms.pose, terms.rates),
            None => self.kinematics(q),
        };
        let contacts = self.contact_readings(&kinematics, v, mode);
        let passive = match required_data.passive {
            true => self.passive_joints(&kinematics, q, v),
            false => PassiveJoints::default(),
        };
        let finger = FingerState {
            q11_rad: q[0],
            q21_rad: q[1],
            q12_rad: passive.q12,
            q22_rad: passive.q22,
            q13_rad: passive.q13,
            qd11_rad_s: v[0],
            qd21_rad_s: v[1],
            qd12_rad_s: passive.qd12,
            qd22_rad_s: passive.qd22,
        };
        sample.set_finger(0, &finger);
        sample.set_actuator(0, if required_data.passive { self.motor_torque(t) } else { 0.0 });
        for contact in 0..sample.counts().contacts {
            let index = self.contact_index(contact);
            sample.set_contact(contact, &contact_sample(contacts[index].as_ref(), z[index]));
        }
        let joint_forces = terms.as_ref().filter(|_| required_data.joint_forces);
        let joint_forces = joint_forces.map(|terms| self.joint_forces(t, v, mode, terms, &contacts));
        sample.set_joint_forces(0, &joint_forces.unwrap_or_default());
        let [.., contact_work, motor_work] = *z;
        let energies = terms.as_ref().filter(|_| required_data.energies);
        let energies = energies.map(|terms| stored_energy(&self.energies(v, terms, &contacts)));
        let relative = |energy: Energy| energy.relative_to(start, contact_work, motor_work);
        sample.set_energy(&energies.map_or_else(Energy::default, relative));
    }

    fn contact_index(&self, contact: usize) -> usize {
        self.contact_of_sample(contact)
    }

    fn is_slipping(&self, index: usize, mode: &FingerMode) -> Option<bool> {
        mode.is_slipping(index).filter(|_| self.has_stiction(FingerContact::ALL[index]))
    }

    fn contact_count(&self) -> usize {
        FingerContact::ALL.len()
    }

    fn contact(&self, state: &State<Self::Layout>, index: usize, mode: &FingerMode) -> ContactSample {
        let reading = self.contact_reading(state.q, state.v, FingerContact::ALL[index], mode[index]);
        contact_sample(reading.as_ref(), state.z[index])
    }

    fn set_input(&mut self, _: usize, input: Profile, _: f64, _: (&mut State<Self::Layout>, &mut FingerMode)) {
        self.set_actuation(input);
    }
}
