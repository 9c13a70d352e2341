//! Turns a state of the analytic model into a sample: what that is differs between its two kernels, and nothing else does.

mod finger;
mod multibody;

use std::ops::Index;

pub(super) use multibody::SystemReader;

use super::{ContactSample, Energy, Sample, Wants};
use crate::analytic::{Energies, SiteReading, SiteState};
use crate::integrator::State;

/// Reads the states of a model.
pub(super) trait Reader<const N: usize, const Z: usize> {
    /// Branches of the laws of all contacts.
    type Mode: Copy + Index<usize, Output = SiteState>;

    /// What is wanted of one state; `start` has the energies at the start of the run, from which works and losses count.
    fn read(&self, t: f64, state: &State<N, Z>, mode: &Self::Mode, start: &Energy, wants: Wants, sample: &mut Sample);

    /// Whether friction that holds slips at a contact: `None` where it is lost or has no bristle, and where the mode does not say.
    fn slips(&self, index: usize, mode: &Self::Mode) -> Option<bool>;

    /// One contact of it.
    fn contact(&self, state: &State<N, Z>, index: usize, mode: &Self::Mode) -> ContactSample;
}

/// Puts these in the place of what is there, without allocating where there is room.
fn refill<T>(parts: &mut Vec<T>, new: impl Iterator<Item = T>) {
    parts.clear();
    parts.extend(new);
}

/// Energies of a state as a sample has them.
fn stored(energies: &Energies) -> Energy {
    Energy {
        kinetic_j: energies.kinetic,
        gravity_j: energies.gravity,
        spring_j: energies.spring,
        elastic_j: energies.elastic,
        ..Energy::default()
    }
}

/// What is read of one contact; nothing where there is none.
fn contact_sample(reading: Option<SiteReading>, impulse_n_s: f64) -> ContactSample {
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
