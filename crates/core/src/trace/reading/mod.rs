//! Converts states of the analytic model to samples; the conversion is the only part of a run that differs between its
//! two kernels.

mod finger;
mod multibody;

use std::ops::Index;

pub(super) use multibody::SystemReader;

use super::{ContactSample, Energy, RequiredData, Sample};
use crate::analytic::{ContactReading, ContactState, Energies};
use crate::integrator::State;

/// Converts the states of a model to samples.
pub(super) trait Reader<const N: usize, const Z: usize> {
    /// Branches of all contact laws.
    type Mode: Copy + Index<usize, Output = ContactState>;

    /// Reads the required data of one state; `start` contains the energies at the start of the run, the reference for
    /// work and dissipation.
    fn read(
        &self,
        t: f64,
        state: &State<N, Z>,
        mode: &Self::Mode,
        start: &Energy,
        required_data: RequiredData,
        sample: &mut Sample,
    );

    /// Whether bristle friction slips at a contact; `None` if the contact is inactive, has no bristle, or the mode does
    /// not record it.
    fn is_slipping(&self, index: usize, mode: &Self::Mode) -> Option<bool>;

    /// Reads one contact of a state.
    fn contact(&self, state: &State<N, Z>, index: usize, mode: &Self::Mode) -> ContactSample;
}

/// Replaces the elements of a vector, reusing its allocation.
fn refill<T>(items: &mut Vec<T>, new: impl Iterator<Item = T>) {
    items.clear();
    items.extend(new);
}

/// Converts the energies of a state to those of a sample.
fn stored_energy(energies: &Energies) -> Energy {
    Energy {
        kinetic_j: energies.kinetic,
        gravity_j: energies.gravity,
        spring_j: energies.spring,
        elastic_j: energies.elastic,
        ..Energy::default()
    }
}

/// Converts a contact reading to a sample; `None` is a contact that does not exist.
fn contact_sample(reading: Option<ContactReading>, impulse_n_s: f64) -> ContactSample {
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
