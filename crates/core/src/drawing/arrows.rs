//! Determines the length of force arrows.

use crate::law::ContactLaw;
use crate::numeric::elementary::{hypot, pow};
use crate::scene::{Actuation, DiscMotion, Pair, Partner, Side, System};
use crate::shape::max_radius;

/// Arrow length per newton, and the largest arrow length. The arrow of a usual force is about half as long as a
/// phalanx, or as a radius in scenes without fingers.
pub(super) fn arrow_scale(system: &System) -> (f64, f64) {
    let (typical_n, half_m, longest_m) = if system.fingers.is_empty() {
        let smallest_m = system.discs.iter().map(|disc| max_radius(&disc.shape)).fold(f64::INFINITY, f64::min);
        let impact = |pair| system.between_discs.map_or(0.0, |law| impact_n(system, &law, pair));
        let typical_n = system.pairs().into_iter().map(impact).fold(0.0, f64::max);
        (if typical_n.is_finite() { typical_n } else { 0.0 }, 0.5 * smallest_m, 2.0 * smallest_m)
    } else {
        let lengths = &system.finger(Side::Right).linkage.lengths;
        (largest_torque(system) / lengths.l11_m, 0.5 * lengths.l21_m, lengths.l21_m)
    };
    (half_m / if typical_n > 0.0 { typical_n } else { 1.0 }, longest_m)
}

/// Largest torque on a driven link.
fn largest_torque(system: &System) -> f64 {
    let motors = system.fingers.iter().map(|finger| peak_torque(&finger.motor.actuation));
    let input = system.differential.as_ref().map(|input| 0.5 * peak_torque(&input.motor.actuation));
    motors.chain(input).fold(0.0, f64::max)
}

/// Largest absolute motor torque.
fn peak_torque(actuation: &Actuation) -> f64 {
    match actuation {
        Actuation::Constant { torque_n_m }
        | Actuation::Ramp { torque_n_m, .. }
        | Actuation::HalfSine { torque_n_m, .. }
        | Actuation::Reversal { torque_n_m, .. } => torque_n_m.abs(),
        Actuation::Table { points, .. } => points.iter().map(|point| point.1.abs()).fold(0.0, f64::max),
    }
}

/// Largest force of an undamped impact at the initial speeds, k δᵉ with ½ m v² = k δ^(e+1)/(e+1), but at least the
/// weight.
fn impact_n(system: &System, law: &ContactLaw, pair: Pair) -> f64 {
    let velocity_and_mass = |index: usize| match system.discs[index].motion {
        DiscMotion::Fixed => ([0.0; 2], f64::INFINITY),
        DiscMotion::Driven { velocity_m_s, .. } => (velocity_m_s, f64::INFINITY),
        DiscMotion::Free { velocity_m_s, mass_kg, .. } => (velocity_m_s, mass_kg),
    };
    let (v1, m1) = velocity_and_mass(pair.disc);
    let (v2, m2) = match pair.partner {
        Partner::Disc(index) => velocity_and_mass(index),
        Partner::HalfPlane => ([0.0; 2], f64::INFINITY),
    };
    let mass = (m1.recip() + m2.recip()).recip();
    if !mass.is_finite() {
        return 0.0;
    }
    let speed = hypot(v1[0] - v2[0], v1[1] - v2[1]);
    let (k, e) = (law.normal.stiffness_n_per_m_e, law.normal.exponent);
    let energy = 0.5 * mass * speed * speed;
    let weight = mass * hypot(system.gravity_m_s2[0], system.gravity_m_s2[1]);
    if k > 0.0 { (k * pow((e + 1.0) * energy / k, e / (e + 1.0))).max(weight) } else { weight }
}
