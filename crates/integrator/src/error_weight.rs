//! Error weights of active contacts: step errors in quantities to which the contact laws are more sensitive than the
//! tolerances of coordinates and rates reflect.

use super::layout::{Layout, VectorOf};
use super::method::Attempt;
use super::{EventSet, Linearised, State, Tolerances, WeightedQuantity};

/// Fraction of its normal force that a sticking contact must retain in a step.
const MIN_REMAINING_FORCE: f64 = 0.25;
/// Depth error that is always allowed, rad or m.
const MIN_DEPTH_ERROR: f64 = 1e-14;
/// Rounding noise of a stiff contact's rate, relative to its coordinates: every stage of a step adds some.
const RATE_NOISE: f64 = 8.0 * f64::EPSILON;
/// Rounding error of a depth or slip, relative to the terms that it is the sum of.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Number of entries of a row up to the last one that is not 0: first-order states follow the coordinates, and a contact
/// depends on at most one of them. A row of a constant length is read whole, in an unrolled loop.
#[inline(always)]
fn entries_in_use<L: Layout>(row: &VectorOf<L>) -> usize {
    let row = row.as_ref();
    match L::IS_FIXED {
        true => row.len(),
        false => row.iter().rposition(|entry| *entry != 0.0).map_or(0, |last| last + 1),
    }
}

/// Raises the tolerance of rates above `noise_scale` times the rounding noise of the rate of a stiff contact.
#[inline(always)]
pub(crate) fn raise_above_noise<L: Layout>(
    tolerances: &mut Tolerances,
    events: &EventSet<L>,
    state: &State<L>,
    linearised: &Linearised<L>,
    noise_scale: f64,
) {
    for weight in events.weights() {
        // A damper that dominates the spring suppresses the noise.
        let WeightedQuantity::Depth { is_spring_dominated: true, .. } = weight.quantity else { continue };
        let row = &weight.row.as_ref()[..entries_in_use::<L>(&weight.row)];
        let (mut stiffness, mut norm_squared, mut magnitude) = (0.0, 0.0, 0.0);
        for (i, entry) in row.iter().enumerate().filter(|(_, entry)| **entry != 0.0) {
            for (other, by_q) in row.iter().zip(&linearised.a_q[i]).filter(|(other, _)| **other != 0.0) {
                stiffness -= entry * by_q * other;
            }
            norm_squared += entry * entry;
            magnitude += (entry * state.q[i]).abs();
        }
        // ω² = nᵀ M⁻¹ n ∂F/∂δ; a_q contains −M⁻¹ n nᵀ ∂F/∂δ.
        let noise = (stiffness.max(0.0) / norm_squared).sqrt() * RATE_NOISE * magnitude / norm_squared.sqrt();
        tolerances.atol_v = tolerances.atol_v.max(noise_scale * noise);
    }
}

/// Scaled error of a step, weighted by the sensitivity of the laws of active contacts.
///
/// A contact may be active at a depth below the tolerance of the coordinates. The linearised damper of the step may
/// then transmit a force, or even pull, where the law does not. Likewise, a sticking range may be narrower than the
/// tolerance of the rates.
#[inline(always)]
pub fn error<L: Layout>(events: &EventSet<L>, attempt: &Attempt<L>, from: &State<L>, tolerances: &Tolerances) -> f64 {
    let contact_tolerance = tolerances.contact_tolerance();
    let rebound_tolerances = tolerances.for_rebounds();
    let mut worst: f64 = 0.0;
    for weight in events.weights() {
        let (row, size) = (&weight.row, entries_in_use::<L>(&weight.row));
        let (mut error, mut scale, mut magnitude) = (0.0, 0.0, 0.0);
        let mut floor = 0.0;
        match weight.quantity {
            WeightedQuantity::Depth { depth, is_rebounding, .. } => {
                if is_rebounding {
                    worst = worst.max(rebound_tolerances.rate_error_along(row, &attempt.error_v, from, &attempt.end));
                }
                for n in 0..size {
                    error += row[n] * attempt.error_q[n];
                    scale -= row[n] * (attempt.end.q[n] - from.q[n]);
                    magnitude += (row[n] * from.q[n]).abs();
                }
                scale = (depth + scale).max(depth);
                floor = MIN_DEPTH_ERROR;
            }
            WeightedQuantity::Slip { slip_scale, .. } => {
                for n in 0..size {
                    error += row[n] * attempt.error_v[n];
                    magnitude += (row[n] * from.v[n]).abs();
                }
                scale = slip_scale;
            }
        }
        worst = worst.max(error.abs() / (contact_tolerance * scale).max(floor + ROUNDING * magnitude));
    }
    worst
}

/// Whether a sticking contact loses most of its normal force in a step and slips beyond the tolerance. Its creep is
/// inversely proportional to the force. The polynomial of a step cannot represent this, and its error estimate does not
/// reveal it.
#[inline(always)]
pub fn unloads<L: Layout>(
    start: &EventSet<L>,
    end: &EventSet<L>,
    attempt: &Attempt<L>,
    from: &State<L>,
    tolerances: &Tolerances,
) -> bool {
    for weight in start.weights() {
        let WeightedQuantity::Slip { slip_scale, normal_force } = weight.quantity else { continue };
        let remaining = match end.weight(weight.index) {
            Some(WeightedQuantity::Slip { normal_force, .. }) => *normal_force,
            _ => 0.0,
        };
        let (row, size) = (&weight.row, entries_in_use::<L>(&weight.row));
        let mut slip_change = 0.0;
        for n in 0..size {
            slip_change += row[n] * (attempt.end.v[n] - from.v[n]);
        }
        if remaining < MIN_REMAINING_FORCE * normal_force
            && slip_change.abs() > tolerances.contact_tolerance() * slip_scale
        {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Fixed;

    /// Returns an active contact with this normal force, whose slip is the rate of the second coordinate.
    fn sticking_contact(normal_force: f64) -> EventSet<Fixed<2, 0>> {
        let mut events = EventSet::new(Fixed, 1);
        *events.add_weight(0, WeightedQuantity::Slip { slip_scale: 1e-3, normal_force }) = [0.0, 1.0];
        events
    }

    fn unloads_to(after: EventSet<Fixed<2, 0>>, rate_change: [f64; 2]) -> bool {
        let tolerances = Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 };
        let from: State<Fixed<2, 0>> = State { q: [0.0; 2], v: [3.0, 0.1], z: [] };
        let mut attempt = Attempt::new(Fixed);
        attempt.end.v =
            [from.v[0] + rate_change[0], from.v[1] + rate_change[1] * tolerances.contact_tolerance() * 1e-3];
        unloads(&sticking_contact(10.0), &after, &attempt, &from, &tolerances)
    }

    #[test]
    fn a_contact_unloads_if_it_loses_its_force_and_slips_beyond_the_tolerance() {
        assert!(unloads_to(sticking_contact(2.4), [0.0, 1.1]), "most of the force is lost, and the contact slips");
        assert!(
            unloads_to(EventSet::new(Fixed, 1), [0.0, -1.1]),
            "a contact that is no longer active has lost its force"
        );
        assert!(!unloads_to(sticking_contact(2.6), [0.0, 1.1]), "more than a quarter of the force remains");
        assert!(!unloads_to(sticking_contact(2.4), [0.0, 0.9]), "the slip is below the tolerance");
        assert!(!unloads_to(sticking_contact(2.4), [5.0, 0.9]), "motion in another direction is not slip");
    }
}
