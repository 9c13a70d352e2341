//! What of pressing contacts a step may err by: quantities their laws are sensitive to, beyond what tolerances of coordinates and rates
//! know of.

use super::method::Attempt;
use super::{Guard, Linearised, State, Strain, Tolerances};

/// Part of its normal force that a contact which sticks has to keep in a step.
const LETTING_GO: f64 = 0.25;
/// Depth that any step may err by, rad or m.
const LEAST_DEPTH: f64 = 1e-14;
/// Noise of a stiff contact's rate, in last digits of its coordinates: every stage of a step adds some.
const NOISE_DIGITS: f64 = 8.0 * f64::EPSILON;
/// Part of the terms that make up a depth or slip below which it has no digits.
const DIGITS: f64 = 4.0 * f64::EPSILON;

/// Raises the tolerance of rates above so many times the noise that a stiff contact's rate has of the last digit of a coordinate.
#[inline(always)]
pub fn above_noise<const N: usize, const Z: usize, const S: usize>(
    tolerances: &mut Tolerances,
    guards: &[Guard<N>; S],
    state: &State<N, Z>,
    linearised: &Linearised<N, Z>,
    loudness: f64,
) {
    for guard in guards {
        // A damper that is stronger makes nothing of it.
        let Strain::Depth { row, springy: true, .. } = &guard.strain else { continue };
        let (mut stiffness, mut square, mut digits) = (0.0, 0.0, 0.0);
        for i in 0..N {
            for j in 0..N {
                stiffness -= row[i] * linearised.a_q[i][j] * row[j];
            }
            square += row[i] * row[i];
            digits += (row[i] * state.q[i]).abs();
        }
        // ω² = nᵀ M⁻¹ n ∂F/∂δ, of which a_q has M⁻¹ n nᵀ ∂F/∂δ.
        let noise = (stiffness.max(0.0) / square).sqrt() * NOISE_DIGITS * digits / square.sqrt();
        tolerances.atol_v = tolerances.atol_v.max(loudness * noise);
    }
}

/// Scaled error of a step in what the laws of pressing contacts are sensitive to.
///
/// The tolerance of the coordinates knows nothing of a contact that presses from less deep than that: there the step's
/// linearised damper may hold, or pull, what the law does not. Nor does that of the rates know of a sticking range that is
/// narrower.
#[inline(always)]
pub fn error<const N: usize, const Z: usize, const S: usize>(
    guards: &[Guard<N>; S],
    attempt: &Attempt<N, Z>,
    from: &State<N, Z>,
    tolerances: &Tolerances,
) -> f64 {
    let share = tolerances.share();
    let rebound = tolerances.of_rebounds();
    let mut worst: f64 = 0.0;
    for guard in guards {
        let (mut error, mut scale, mut digits) = (0.0, 0.0, 0.0);
        let mut floor = 0.0;
        match &guard.strain {
            Strain::None => continue,
            Strain::Depth { row, depth, rebounds, .. } => {
                if *rebounds {
                    worst = worst.max(rebound.rate_along(row, &attempt.error_v, from, &attempt.end));
                }
                for n in 0..N {
                    error += row[n] * attempt.error_q[n];
                    scale -= row[n] * (attempt.end.q[n] - from.q[n]);
                    digits += (row[n] * from.q[n]).abs();
                }
                scale = (depth + scale).max(*depth);
                floor = LEAST_DEPTH;
            }
            Strain::Slip { row, finest, .. } => {
                for n in 0..N {
                    error += row[n] * attempt.error_v[n];
                    digits += (row[n] * from.v[n]).abs();
                }
                scale = *finest;
            }
        }
        worst = worst.max(error.abs() / (share * scale).max(floor + DIGITS * digits));
    }
    worst
}

/// Whether a contact that sticks loses most of its normal force in a step, and slips by what it then does not hold: creep grows
/// with the reciprocal of the force, which no polynomial of a step follows, nor does the error of one tell.
#[inline(always)]
pub fn lets_go<const N: usize, const Z: usize, const S: usize>(
    start: &[Guard<N>; S],
    end: &[Guard<N>; S],
    attempt: &Attempt<N, Z>,
    from: &State<N, Z>,
    tolerances: &Tolerances,
) -> bool {
    for guard in 0..S {
        let Strain::Slip { row, finest, normal } = &start[guard].strain else { continue };
        let left = if let Strain::Slip { normal, .. } = &end[guard].strain { *normal } else { 0.0 };
        let mut gains = 0.0;
        for n in 0..N {
            gains += row[n] * (attempt.end.v[n] - from.v[n]);
        }
        if left < LETTING_GO * normal && gains.abs() > tolerances.share() * finest {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A contact that presses like this and gets its slip from the second coordinate.
    fn sticking(normal: f64) -> [Guard<2>; 1] {
        [Guard { strain: Strain::Slip { row: [0.0, 1.0], finest: 1e-3, normal }, ..Guard::QUIET }]
    }

    fn let_go(after: [Guard<2>; 1], gained: [f64; 2]) -> bool {
        let tolerances = Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 };
        let from = State { q: [0.0; 2], v: [3.0, 0.1], z: [] };
        let v = [from.v[0] + gained[0], from.v[1] + gained[1] * tolerances.share() * 1e-3];
        let attempt = Attempt { error: 0.5, rhs: 8, end: State { v, ..from }, error_q: [0.0; 2], error_v: [0.0; 2] };
        lets_go(&sticking(10.0), &after, &attempt, &from, &tolerances)
    }

    #[test]
    fn a_contact_lets_go_where_it_loses_its_force_and_slips_by_more_than_its_share() {
        assert!(let_go(sticking(2.4), [0.0, 1.1]), "most of its force is gone, and it slips");
        assert!(let_go([Guard::QUIET], [0.0, -1.1]), "so has one that is no contact any more");
        assert!(!let_go(sticking(2.6), [0.0, 1.1]), "it keeps more than a quarter");
        assert!(!let_go(sticking(2.4), [0.0, 0.9]), "it slips by less than a step may err by");
        assert!(!let_go(sticking(2.4), [5.0, 0.9]), "what moves across is no slip");
    }
}
