//! How fast a gripper may be accelerated before its contacts can no longer hold the object at rest in the hand.
//!
//! At rest in the palm's frame all forces balance: on the object, and on both coordinates of either finger. Contacts press within their
//! friction cones, motors give their torque, and what blocks them whatever it takes, up to what it holds. The accelerations that some such
//! forces balance are a convex set; its edge in a direction is a linear programme, with a motion that proves it. That forces exist does
//! not say that these come about: where friction leaves forces open, it depends on how the hand was closed, so that this is the most
//! that a grasp can bear without slipping.

use std::f64::consts::TAU;

use super::StaticsError;
use super::balance_exact as exact;
use super::balance_program::{Bound, Forces, Largest, Program, weigh};
use super::loads::{HandAtRest, Load, Loads, Pressing, ROWS, Spot, loads};
use crate::numeric::elementary::{hypot, sin_cos};

/// What forces and motion may differ by in what they say of the largest acceleration, relative to it or to what the fixed loads give.
const GAP: f64 = 1e-6;

/// Rates below this part of the largest are rounding.
const ROUNDING: f64 = 1e-7;

/// The largest acceleration of the palm in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Balance {
    /// Of length 1, in the palm's frame.
    pub direction: [f64; 2],
    pub largest: Balanced,
}

/// How large an acceleration can be balanced.
#[derive(Clone, Debug, PartialEq)]
pub enum Balanced {
    /// Not even a palm at rest: no forces within the cones balance weight, springs and motors.
    Nothing,
    UpTo(Limit),
    /// However large: forces that balance acceleration grow with it.
    Any,
}

impl Balanced {
    /// m/s²; `None` where there is no limit, and where nothing is balanced.
    pub fn acceleration_m_s2(&self) -> Option<f64> {
        match self {
            Balanced::UpTo(limit) => Some(limit.acceleration_m_s2),
            Balanced::Nothing | Balanced::Any => None,
        }
    }
}

/// The largest acceleration with what proves it.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    pub acceleration_m_s2: f64,
    /// Forces that balance it; where they are not the only ones, some.
    pub contacts: Vec<Held>,
    /// What each brake gives, N·m, and whether it slips.
    pub brakes: Vec<BrakeHeld>,
    /// The motion that a larger acceleration drives and no force within the cones hinders: the object at 1 mm/s (or, if it stays, the
    /// fastest joint at 1 rad/s).
    pub motion: HandMotion,
    /// How far apart forces and motion see the limit, relative to it or to what the fixed loads give.
    pub gap: f64,
}

/// A contact, or a joint limit, at the largest acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    pub spot: Spot,
    /// N; of a joint limit a torque, N·m.
    pub normal_n: f64,
    /// On phalanx or palm along t = (n_y, −n_x), N; mirrored on the left.
    pub tangential_n: f64,
    pub yields: Yields,
}

/// What a contact does in the motion, and so in all forces that balance the largest acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Yields {
    /// Its force is wherever in its cone.
    Holds,
    /// It is on one edge of the cone.
    Slips,
    /// There is none.
    Leaves,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakeHeld {
    pub torque_n_m: f64,
    pub slips: bool,
}

/// A motion of object and fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandMotion {
    pub object_m_s: [f64; 2],
    pub spin_rad_s: f64,
    /// (q̇11, q̇21) of right and left; of the left one those of its mirror image.
    pub fingers_rad_s: [[f64; 2]; 2],
}

/// The largest acceleration of the palm, which does not turn, along a direction that contact forces within their cones can balance.
///
/// # Errors
/// A direction without a length; a posture in which a loop does not close, or is singular; numbers out of range; a programme whose
/// forces and motion do not prove each other.
pub fn balanced_acceleration(hand: &HandAtRest<'_>, direction: [f64; 2]) -> Result<Balance, StaticsError> {
    largest(&loads(hand)?, direction)
}

/// The same in `count` directions, evenly around from x towards y of the palm's frame.
///
/// # Errors
/// Those of [`balanced_acceleration`].
pub fn balance_polar(hand: &HandAtRest<'_>, count: usize) -> Result<Vec<Balance>, StaticsError> {
    let loads = loads(hand)?;
    (0..count).map(|index| largest(&loads, heading(TAU * index as f64 / count as f64))).collect()
}

/// The unit vector at an angle; along an axis exactly.
fn heading(angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = sin_cos(angle_rad);
    [cos, sin].map(|part| if part.abs() < f64::EPSILON { 0.0 } else { part })
}

/// Columns with rows in N, what is fixed about 1, and so every other one; `unit` is what of it each is.
struct Scaled {
    program: Program,
    /// N, m/s², and of each column.
    force: f64,
    acceleration: f64,
    pressing: Vec<f64>,
    bounded: Vec<f64>,
    lengths: Load,
}

fn size(column: &Load) -> f64 {
    column.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()))
}

/// A column of size 1, and what it was.
fn unit(column: &Load) -> (Load, f64) {
    let size = Some(size(column)).filter(|size| *size > 0.0).unwrap_or(1.0);
    (column.map(|entry| entry / size), size)
}

/// Forces on the edges of a cone; without friction it has one.
fn edges(pressing: &Pressing) -> impl Iterator<Item = Load> {
    let ([normal, tangential], mu) = (pressing.columns, pressing.mu);
    let edge = move |mu: f64| std::array::from_fn(|row| normal[row] + mu * tangential[row]);
    [mu, -mu].into_iter().take(if mu > 0.0 { 2 } else { 1 }).map(edge)
}

fn scaled(loads: &Loads, [x, y]: [f64; 2]) -> Scaled {
    let r = loads.length_m;
    let lengths = [r, r, r, r, 1.0, 1.0, r];
    let in_newtons = |column: &Load| -> Load { std::array::from_fn(|row| column[row] / lengths[row]) };
    let fixed = in_newtons(&loads.fixed);
    let drives: Vec<(Load, f64, [f64; 2])> = loads
        .drives
        .iter()
        .map(|(column, bounds)| {
            let (column, size) = unit(&in_newtons(column));
            (column, size, *bounds)
        })
        .collect();
    let held = drives.iter().flat_map(|(_, size, bounds)| bounds.map(|bound| bound.abs() * size));
    let largest_held = held.filter(|bound| bound.is_finite()).fold(0.0, f64::max);
    let force = [size(&fixed), largest_held].into_iter().find(|force| *force > 0.0).unwrap_or(1.0);
    let driving: Load = std::array::from_fn(|row| x * loads.inertia[0][row] + y * loads.inertia[1][row]);
    let (driving, inertia) = unit(&in_newtons(&driving));
    let (pressing, sizes): (Vec<Load>, Vec<f64>) =
        loads.pressing.iter().flat_map(edges).map(|edge| unit(&in_newtons(&edge))).unzip();
    let bounded = drives.iter().map(|(column, size, bounds)| (*column, bounds.map(|bound| bound * size / force)));
    Scaled {
        program: Program { pressing, bounded: bounded.collect(), driving, fixed: fixed.map(|entry| entry / force) },
        force,
        acceleration: force / inertia,
        pressing: sizes,
        bounded: drives.iter().map(|(_, size, _)| *size).collect(),
        lengths,
    }
}

fn largest(loads: &Loads, direction: [f64; 2]) -> Result<Balance, StaticsError> {
    let length = hypot(direction[0], direction[1]);
    if !length.is_finite() || length <= 0.0 {
        let allowed = "must be finite, more than 0";
        return Err(StaticsError::Number { name: "the length of the direction", value: length, allowed });
    }
    let direction = direction.map(|part| part / length);
    let scaled = scaled(loads, direction);
    let largest = match scaled.program.largest()? {
        Largest::Nothing => Balanced::Nothing,
        Largest::Any => Balanced::Any,
        Largest::Finite(forces) => Balanced::UpTo(limit(loads, &scaled, forces)?),
    };
    Ok(Balance { direction, largest })
}

fn limit(loads: &Loads, scaled: &Scaled, forces: Forces) -> Result<Limit, StaticsError> {
    let Some(found) = scaled.program.bound()? else {
        return Err(StaticsError::Balance { reason: "no motion proves the limit".to_string() });
    };
    let forces = exact::forces(&scaled.program, forces);
    let Bound { bound, motion } = exact::motion(&scaled.program, &forces, found);
    let gap = (bound - forces.multiple).abs() / forces.multiple.max(1.0);
    if gap.is_nan() || gap > GAP {
        let reason = format!("forces reach {} of what motion says is {bound}", forces.multiple);
        return Err(StaticsError::Balance { reason });
    }
    let nothing = ROUNDING * size(&motion);
    let rate = |column: &Load| weigh(&motion, column);
    if let Some(taken) = scaled.program.pressing.iter().map(rate).find(|rate| *rate < -nothing) {
        return Err(StaticsError::Balance { reason: format!("a force takes power away, {taken}") });
    }
    let mut edges = scaled
        .program
        .pressing
        .iter()
        .zip(&scaled.pressing)
        .zip(&forces.pressing)
        .map(|((column, size), force)| (force * scaled.force / size, rate(column) > nothing));
    let mut held = |pressing: &Pressing| {
        let mut next = || edges.next().unwrap_or((0.0, true));
        let (first, gone) = next();
        let Pressing { spot, mu, .. } = *pressing;
        if mu <= 0.0 {
            let yields = if gone { Yields::Leaves } else { Yields::Holds };
            return Held { spot, normal_n: first, tangential_n: 0.0, yields };
        }
        let (second, other_gone) = next();
        let yields = match (gone, other_gone) {
            (false, false) => Yields::Holds,
            (true, true) => Yields::Leaves,
            _ => Yields::Slips,
        };
        Held { spot, normal_n: first + second, tangential_n: mu * (first - second), yields }
    };
    let contacts = loads.pressing.iter().map(&mut held).collect();
    let brakes = scaled.program.bounded.iter().zip(&scaled.bounded).zip(&forces.bounded).map(
        |(((column, bounds), size), torque)| BrakeHeld {
            torque_n_m: torque * scaled.force / size,
            slips: bounds[0] < bounds[1] && rate(column).abs() > nothing,
        },
    );
    Ok(Limit {
        acceleration_m_s2: forces.multiple * scaled.acceleration,
        contacts,
        brakes: brakes.collect(),
        motion: told(&motion, &scaled.lengths),
        gap,
    })
}

/// A motion of scaled rows in units that can be read.
fn told(motion: &Load, lengths: &Load) -> HandMotion {
    let nothing = ROUNDING * size(motion);
    let clean = |rate: f64| if rate.abs() <= nothing { 0.0 } else { rate };
    let rates: [f64; ROWS] = std::array::from_fn(|row| clean(motion[row]) / lengths[row]);
    let [q11_r, q21_r, q11_l, q21_l, x, y, spin] = rates;
    let speed = hypot(x, y);
    let fastest = [q11_r, q21_r, q11_l, q21_l, spin].into_iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
    let unit = if speed > 0.0 { speed * 1e3 } else { fastest.max(f64::MIN_POSITIVE) };
    HandMotion {
        object_m_s: [x / unit, y / unit],
        spin_rad_s: spin / unit,
        fingers_rad_s: [[q11_r, q21_r], [q11_l, q21_l]].map(|finger| finger.map(|rate| rate / unit)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gripper::Site;
    use crate::statics::Side;

    const R: f64 = 0.02;
    const N: f64 = 5.0;
    const M: f64 = 0.05;
    const G: f64 = 9.81;

    /// A disc between two contacts on x, each pressed by N and by what a brake adds; finger rows are nothing but that.
    fn antipodal(mu: f64, brake_n_m: [f64; 2]) -> Loads {
        let contact = |side: Side| {
            let mirror = side.mirror();
            let mut columns = [[0.0; ROWS]; 2];
            (columns[0][2 * side as usize], columns[0][4]) = (-R, -mirror);
            (columns[1][5], columns[1][6]) = (-1.0, -mirror * R);
            let (spot, point_m) = (Spot::Finger(side, Site::Proximal), Some([mirror * R, 0.0]));
            Pressing { spot, point_m, normal: [-mirror, 0.0], mu, columns }
        };
        let drive = |row: usize| {
            let mut column = [0.0; ROWS];
            column[row] = 1.0;
            (column, brake_n_m)
        };
        Loads {
            pressing: Side::BOTH.map(contact).to_vec(),
            drives: vec![drive(0), drive(2)],
            fixed: [N * R, 0.0, N * R, 0.0, 0.0, M * G, 0.0],
            inertia: [[0.0, 0.0, 0.0, 0.0, -M, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, -M, 0.0]],
            length_m: R,
        }
    }

    #[track_caller]
    fn limit(loads: &Loads, degrees: f64) -> Limit {
        match largest(loads, heading(degrees.to_radians())).expect("an answer").largest {
            Balanced::UpTo(limit) => limit,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_disc_between_two_fixed_forces_bears_what_their_friction_leaves() {
        for mu in [0.1, 0.3, 0.8] {
            let loads = antipodal(mu, [0.0; 2]);
            let most = 2.0 * mu * N / M;
            for (degrees, expected) in [(-90.0, most - G), (90.0, most + G), (0.0, 0.0), (180.0, 0.0), (40.0, 0.0)] {
                let found = limit(&loads, degrees);
                assert!((found.acceleration_m_s2 - expected).abs() < 1e-9 * most, "{mu} {degrees}: {found:?}");
                assert!(found.gap < 1e-12 && found.contacts.iter().all(|held| (held.normal_n - N).abs() < 1e-9));
            }
            // Upwards both contacts slip, and the object with them; the friction on the fingers points up.
            let up = limit(&loads, -90.0);
            assert!(up.contacts.iter().all(|held| held.yields == Yields::Slips), "{up:?}");
            assert!(up.contacts.iter().all(|held| (held.tangential_n - mu * N).abs() < 1e-9), "{up:?}");
            assert!((up.motion.object_m_s[1] - 1e-3).abs() < 1e-12 && up.motion.object_m_s[0].abs() < 1e-9, "{up:?}");
        }
        // Not even its weight: 2 μ N = 0.4 N of 0.49 N.
        let found = largest(&antipodal(0.04, [0.0; 2]), [0.0, -1.0]).expect("an answer");
        assert_eq!(found.largest, Balanced::Nothing);
        // The same without weight.
        let mut weightless = antipodal(0.04, [0.0; 2]);
        weightless.fixed[5] = 0.0;
        assert!((limit(&weightless, -90.0).acceleration_m_s2 - 2.0 * 0.04 * N / M).abs() < 1e-9);
    }

    /// With brakes that add up to T/r: m |a_x| ≤ T/r, and on the contact that is unloaded m |g − a_y|/2 ≤ μ (N + T/r − m |a_x|).
    #[test]
    fn brakes_that_only_press_on_have_their_polygon() {
        let (mu, torque) = (0.4, 0.06);
        let loads = antipodal(mu, [0.0, torque]);
        for degrees in (0..360).step_by(7).map(f64::from) {
            let [x, y] = heading(degrees.to_radians());
            let x = x.abs();
            let pressed = N + torque / R;
            // m (g − a y)/2 ≤ μ (pressed − m a x), either sign of the left side.
            let sinks = (mu * pressed - 0.5 * M * G) / (M * (mu * x - 0.5 * y));
            let rises = (mu * pressed + 0.5 * M * G) / (M * (mu * x + 0.5 * y));
            let moved = torque / R / (M * x);
            let most = [sinks, rises, moved].into_iter().filter(|a| *a > 0.0).fold(f64::INFINITY, f64::min);
            let found = limit(&loads, degrees);
            assert!(
                (found.acceleration_m_s2 - most).abs() < 1e-8 * most,
                "{degrees}: {} {most}",
                found.acceleration_m_s2
            );
        }
        // Blocked whatever it takes, nothing but friction's share limits: what presses on is free.
        let free = antipodal(mu, [0.0, f64::INFINITY]);
        assert_eq!(largest(&free, [0.3, -0.7]).expect("an answer").largest, Balanced::Any);
        // Brakes beyond what they hold slip, and motors do not.
        let sideways = limit(&loads, 0.0);
        assert!(sideways.brakes.iter().any(|brake| brake.slips), "{sideways:?}");
        assert!(limit(&antipodal(mu, [0.0; 2]), -90.0).brakes.iter().all(|brake| !brake.slips));
    }

    #[test]
    fn a_direction_has_a_length() {
        let loads = antipodal(0.4, [0.0; 2]);
        for direction in [[0.0, 0.0], [f64::NAN, 1.0]] {
            let error = largest(&loads, direction).expect_err("no direction");
            assert!(error.to_string().contains("length of the direction"), "{error}");
        }
    }
}
