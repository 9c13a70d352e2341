//! Direct geometric and kinematic models of the five-bar (thesis (2.1)–(2.16)).
//!
//! Directions of the links are stored as unit vectors, so that only q11 and q21 need a sine and a cosine.
//! Index 1 is l11, 2 is l21, 3 is l12 (absolute angle q11 + q12), 4 is l22 (absolute angle q21 + q22 = q13).

use crate::gripper::{Lengths, Placement, Spring, SpringKind};
use crate::numeric::elementary::{atan2, cos, powi, sin, sin_cos};
use crate::numeric::plane::{
    Vector, add, angle_between, cross, dot, nearest_equivalent_angle, opening_angle, perp, rotate, scale, scale_by, sub,
};
use crate::numeric::{Real, map_array};
use crate::shape::{PlacedShape, Support, normal_towards, support};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Singularity of the closed form of the loop.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Singularity {
    #[error(
        "l12 and l22 are in line, stretched: the distance of A12 and A22 is {distance_m:.6e} m, l12 + l22 = {reach_m:.6e} m"
    )]
    Stretched { distance_m: f64, reach_m: f64 },
    #[error(
        "l12 and l22 are in line, folded: the distance of A12 and A22 is {distance_m:.6e} m, |l12 − l22| = {reach_m:.6e} m"
    )]
    Folded { distance_m: f64, reach_m: f64 },
    #[error("A12 and A22 coincide: the direction of l12 is undetermined")]
    Coincident,
}

/// Smallest |sin| of the angle between l12 and l22 in a regular configuration: 0.06° from the fold. Passive rates are a
/// thousand times the driven rates there, and the finger cannot return in its assembly mode.
pub const SINGULAR_SINE: f64 = 1e-3;

/// Unit vectors along the four links. The angles of the two ground links are stored as well, because directions do not
/// count whole turns.
#[derive(Clone, Copy, Debug)]
pub struct Directions<T> {
    pub e1: Vector<T>,
    pub e2: Vector<T>,
    pub e3: Vector<T>,
    pub e4: Vector<T>,
    /// q11 and q21.
    pub q_rad: [f64; 2],
}

impl<T: Copy> Directions<T> {
    /// Converts every number. For example, derivatives with respect to two angles become derivatives with respect to
    /// more coordinates.
    #[inline(always)]
    pub fn map<U: Copy + Default>(&self, f: impl Fn(T) -> U + Copy) -> Directions<U> {
        let Directions { e1, e2, e3, e4, q_rad } = *self;
        Directions { e1: map_array(e1, f), e2: map_array(e2, f), e3: map_array(e3, f), e4: map_array(e4, f), q_rad }
    }
}

/// Direct geometric model (2.1), (2.2): link directions at q_a = (q11, q21) in assembly mode γ = ±1.
///
/// If the loop cannot close, the result is NaN; [`nearest_singularity`] reports the cause.
#[inline(always)]
pub fn directions<T: Real>(lengths: &Lengths, gamma: f64, q: Vector<T>) -> Directions<T> {
    let (s1, c1) = q[0].sin_cos();
    let (s2, c2) = q[1].sin_cos();
    let (e1, e2) = ([c1, s1], [c2, s2]);
    let (l12, l22) = (lengths.l12_m, lengths.l22_m);
    let a12 = scale_by(e1, lengths.l11_m);
    let a22 = scale_by(e2, lengths.l21_m);
    let d = sub(a22, a12);
    let inverse = dot(d, d).recip();
    // A13 = A12 + α d + β d⊥ with α = (|d|² + l12² − l22²)/(2 |d|²) and α² + β² = l12²/|d|².
    let alpha = inverse * (0.5 * (l12 * l12 - l22 * l22)) + 0.5;
    let beta = (inverse * (l12 * l12) - alpha.squared()).sqrt() * gamma;
    let a12_to_a13 = add(scale(d, alpha), scale(perp(d), beta));
    let e3 = scale_by(a12_to_a13, 1.0 / l12);
    let e4 = scale_by(sub(a12_to_a13, d), 1.0 / l22);
    Directions { e1, e2, e3, e4, q_rad: [q[0].value(), q[1].value()] }
}

/// Returns the singularity that is nearest to `q`.
pub fn nearest_singularity(lengths: &Lengths, q: [f64; 2]) -> Singularity {
    let e = |angle: f64| [cos(angle), sin(angle)];
    let d = sub(scale_by(e(q[1]), lengths.l21_m), scale_by(e(q[0]), lengths.l11_m));
    let distance_m = dot(d, d).sqrt();
    if distance_m < SINGULAR_SINE * lengths.l12_m {
        return Singularity::Coincident;
    }
    let (long, short) = (lengths.l12_m + lengths.l22_m, (lengths.l12_m - lengths.l22_m).abs());
    if (distance_m - long).abs() <= (distance_m - short).abs() {
        Singularity::Stretched { distance_m, reach_m: long }
    } else {
        Singularity::Folded { distance_m, reach_m: short }
    }
}

/// Returns the straight configuration in which l21 is at 90°: l22 is at 90° − φ22, and the directions of l12 and l11
/// follow from the loop closure.
///
/// If l12 satisfies (B.7), this is the reference configuration, in which l11 lies on the palm.
pub fn straight_directions(lengths: &Lengths) -> Directions<f64> {
    let (sin, cos) = sin_cos(lengths.phi22_rad);
    let (e2, e4) = ([0.0, 1.0], [sin, cos]);
    let a13 = add(scale_by(e2, lengths.l21_m), scale_by(e4, lengths.l22_m));
    // A12 is to the right of the line O–A13: α along the line, β across it.
    let distance_squared = dot(a13, a13);
    let alpha = (distance_squared + powi(lengths.l11_m, 2) - powi(lengths.l12_m, 2)) / (2.0 * distance_squared);
    let beta = (powi(lengths.l11_m, 2) / distance_squared - alpha * alpha).max(0.0).sqrt();
    let a12 = sub(scale_by(a13, alpha), scale_by(perp(a13), beta));
    Directions {
        e1: scale_by(a12, 1.0 / lengths.l11_m),
        e2,
        e3: scale_by(sub(a13, a12), 1.0 / lengths.l12_m),
        e4,
        q_rad: [atan2(a12[1], a12[0]), FRAC_PI_2],
    }
}

/// γ of (2.1) in the straight configuration: the side of the line A12→A22 on which the joint A13 lies.
pub fn reference_gamma(lengths: &Lengths) -> f64 {
    let pose = straight_directions(lengths);
    let d = sub(scale_by(pose.e2, lengths.l21_m), scale_by(pose.e1, lengths.l11_m));
    cross(d, pose.e3).signum()
}

/// First-order kinematics (2.8): θ̇3 = a3·q̇_a and θ̇4 = a4·q̇_a, the absolute rates of l12 and l22.
///
/// q̇12 = θ̇3 − q̇11 and q̇22 = θ̇4 − q̇21 are the rows of J_da.
#[derive(Clone, Copy, Debug)]
pub struct PassiveRates<T> {
    pub a3: [T; 2],
    pub a4: [T; 2],
    /// 1 / sin of the angle from l12 to l22; infinite at a singularity.
    pub inverse_sine: T,
}

impl<T: Copy> PassiveRates<T> {
    /// Converts every number, as [`Directions::map`].
    #[inline(always)]
    pub fn map<U: Copy + Default>(&self, f: impl Fn(T) -> U + Copy) -> PassiveRates<U> {
        let PassiveRates { a3, a4, inverse_sine } = *self;
        PassiveRates { a3: map_array(a3, f), a4: map_array(a4, f), inverse_sine: f(inverse_sine) }
    }
}

/// Solves the rate of the loop closure (2.4) for the passive links, by projection on l22 and on l12.
#[inline(always)]
pub fn passive_rates<T: Real>(lengths: &Lengths, pose: &Directions<T>) -> PassiveRates<T> {
    let Directions { e1, e2, e3, e4, .. } = *pose;
    let inverse_sine = cross(e3, e4).recip();
    let over3 = inverse_sine * (1.0 / lengths.l12_m);
    let over4 = inverse_sine * (1.0 / lengths.l22_m);
    PassiveRates {
        a3: [cross(e1, e4) * over3 * -lengths.l11_m, cross(e2, e4) * over3 * lengths.l21_m],
        a4: [cross(e1, e3) * over4 * -lengths.l11_m, cross(e2, e3) * over4 * lengths.l21_m],
        inverse_sine,
    }
}

/// Second-order kinematics (2.14)–(2.16): with q̈_a = 0, θ̈3 = b3·w and θ̈4 = b4·w, where w = (θ̇1², θ̇2², θ̇3², θ̇4²).
#[derive(Clone, Copy, Debug)]
pub struct PassiveBias<T> {
    pub b3: [T; 4],
    pub b4: [T; 4],
}

/// Coefficients of the second-order kinematics.
#[inline(always)]
pub fn passive_bias<T: Real>(lengths: &Lengths, pose: &Directions<T>, rates: &PassiveRates<T>) -> PassiveBias<T> {
    let Directions { e1, e2, e3, e4, .. } = *pose;
    let Lengths { l11_m: l11, l12_m: l12, l21_m: l21, l22_m: l22, .. } = *lengths;
    let i = rates.inverse_sine;
    let cos34 = dot(e3, e4);
    PassiveBias {
        b3: [dot(e1, e4) * i * (l11 / l12), dot(e2, e4) * i * (-l21 / l12), cos34 * i, i * (-l22 / l12)],
        b4: [dot(e1, e3) * i * (l11 / l22), dot(e2, e3) * i * (-l21 / l22), i * (l12 / l22), cos34 * -i],
    }
}

/// Whole turns of the passive links, counted from a start pose, so that their angles are continuous functions of q11
/// and q21.
///
/// A13 stays on one side of the line A12→A22, so that l12 and l22 are less than a quarter of a turn from the normal on
/// this side. The line itself is less than a quarter of a turn from the longer ground link (from l21, or from the
/// reverse of l11). Each angle is therefore less than half a turn from an angle that follows from the longer ground
/// link.
#[derive(Clone, Copy, Debug)]
pub struct PassiveTurns {
    /// The longer ground link, as an index of q_a.
    longer: usize,
    /// Angle of the normal at the zero of the longer ground link, if the line is along it.
    normal_rad: f64,
    /// Whole turns of q12 and q22.
    turns_rad: [f64; 2],
}

impl PassiveTurns {
    /// Counts turns from the pose `start`. In it, |q12| is at most half a turn, and q22 + φ22 lies between −90° (before
    /// the stop) and 270° (beyond it).
    pub fn new(lengths: &Lengths, gamma: f64, start: &Directions<f64>) -> Self {
        let longer = usize::from(lengths.l21_m >= lengths.l11_m);
        let normal_rad = gamma * FRAC_PI_2 + if longer == 0 { PI } else { 0.0 };
        let turns = Self { longer, normal_rad, turns_rad: [0.0; 2] };
        let [q12_rad, q22_rad] = start_angles(lengths, start);
        let missing = |angle: f64, near: f64| {
            if angle.is_finite() { angle - nearest_equivalent_angle(angle, near) } else { 0.0 }
        };
        let turns_rad = [missing(q12_rad, turns.near_q12(start.q_rad)), missing(q22_rad, turns.near_q22(start.q_rad))];
        Self { turns_rad, ..turns }
    }

    /// Returns an angle that is less than half a turn from q12, rad.
    #[inline(always)]
    pub fn near_q12(&self, q_rad: [f64; 2]) -> f64 {
        q_rad[self.longer] - q_rad[0] + (self.normal_rad + self.turns_rad[0])
    }

    /// Returns an angle that is less than half a turn from q22, rad.
    #[inline(always)]
    pub fn near_q22(&self, q_rad: [f64; 2]) -> f64 {
        q_rad[self.longer] - q_rad[1] + (self.normal_rad + self.turns_rad[1])
    }

    /// An angle that is less than half a turn from that of l12 relative to l22.
    #[inline(always)]
    fn near_loop(&self) -> f64 {
        self.turns_rad[0] - self.turns_rad[1]
    }
}

/// q12 and q22 at the start of a run.
fn start_angles(lengths: &Lengths, pose: &Directions<f64>) -> [f64; 2] {
    let (sin, cos) = sin_cos(lengths.phi22_rad);
    [angle_between(pose.e1, pose.e3), opening_angle(pose.e2, rotate(pose.e4, [cos, sin])) - lengths.phi22_rad]
}

/// The angle plus the number of whole turns that brings it nearest to `near_rad`.
#[inline(always)]
pub fn continued_angle<T: Real>(angle: T, near_rad: f64) -> T {
    let off = angle.value() - near_rad;
    if off.abs() <= PI { angle } else { angle + -TAU * (off / TAU).round() }
}

/// The return spring (thesis (2.30), §3.3.2.3, errata 4) with its reference angle in the straight configuration.
#[derive(Clone, Copy, Debug)]
pub struct SpringModel {
    kind: SpringKind,
    placement: Placement,
    /// s: +1 if q_s increases as the tip closes, −1 otherwise: −s k_s acts towards the straight configuration.
    closing_sign: f64,
    /// (cos, sin) of −q_s in the straight configuration.
    straight: [f64; 2],
    /// q_s in the straight configuration.
    straight_rad: f64,
    turns: PassiveTurns,
}

/// Returns the two directions that enclose the angle q_s.
#[inline(always)]
fn directions_of<T: Real>(placement: Placement, pose: &Directions<T>) -> [[T; 2]; 2] {
    match placement {
        Placement::GroundLinks => [pose.e1, pose.e2],
        Placement::DrivenCoupler => [pose.e1, pose.e3],
        Placement::Phalanges => [pose.e2, pose.e4],
        Placement::CouplerDistal => [pose.e4, pose.e3],
    }
}

/// Gradient ∂q_s/∂q_a of the spring angle.
#[inline(always)]
pub fn gradient<T: Real>(placement: Placement, rates: &PassiveRates<T>) -> [T; 2] {
    let (a3, a4) = (rates.a3, rates.a4);
    match placement {
        Placement::GroundLinks => [T::constant(-1.0), T::constant(1.0)],
        Placement::DrivenCoupler => [a3[0] - 1.0, a3[1]],
        Placement::Phalanges => [a4[0], a4[1] - 1.0],
        Placement::CouplerDistal => [a3[0] - a4[0], a3[1] - a4[1]],
    }
}

impl SpringModel {
    /// Returns the spring in assembly mode γ for a run from the pose `start`. Its angle is zero in the straight
    /// configuration.
    pub fn new(spring: &Spring, lengths: &Lengths, gamma: f64, start: &Directions<f64>) -> Self {
        let pose = straight_directions(lengths);
        let [from, to] = directions_of(spring.placement, &pose);
        let q_s: f64 = angle_between(from, to);
        let closing = gradient(spring.placement, &passive_rates(lengths, &pose))[0];
        let ([q12_rad, q22_rad], [q11_rad, q21_rad]) = (start_angles(lengths, &pose), pose.q_rad);
        let straight_rad = match spring.placement {
            Placement::GroundLinks => q21_rad - q11_rad,
            Placement::DrivenCoupler => q12_rad,
            Placement::Phalanges => q22_rad,
            Placement::CouplerDistal => q11_rad + q12_rad - (q21_rad + q22_rad),
        };
        Self {
            kind: spring.kind,
            placement: spring.placement,
            closing_sign: closing.signum(),
            straight: [cos(q_s), -sin(q_s)],
            straight_rad,
            turns: PassiveTurns::new(lengths, gamma, start),
        }
    }

    /// An angle that is less than half a turn from q_s.
    #[inline(always)]
    fn near_angle(&self, q_rad: [f64; 2]) -> f64 {
        match self.placement {
            Placement::GroundLinks => q_rad[1] - q_rad[0],
            Placement::DrivenCoupler => self.turns.near_q12(q_rad),
            Placement::Phalanges => self.turns.near_q22(q_rad),
            Placement::CouplerDistal => self.turns.near_loop(),
        }
    }

    /// Δq_s, in rad: deviation of q_s from the straight configuration; ≥ 0 in closing, and continuous along a run.
    #[inline(always)]
    pub fn extension<T: Real>(&self, pose: &Directions<T>) -> T {
        let [from, to] = directions_of(self.placement, pose);
        let to = rotate(to, self.straight);
        let principal = if self.closing_sign > 0.0 { angle_between(from, to) } else { angle_between(to, from) };
        continued_angle(principal, self.closing_sign * (self.near_angle(pose.q_rad) - self.straight_rad))
    }

    /// Generalised force τ_s (2.30): −(∂q_s/∂q_a)ᵀ s T with T = k_s, or c_s (q_p + Δq_s).
    #[inline(always)]
    pub fn generalised_force<T: Real>(&self, pose: &Directions<T>, rates: &PassiveRates<T>) -> [T; 2] {
        let [g0, g1] = gradient(self.placement, rates);
        match self.kind {
            SpringKind::Constant { torque_n_m } => {
                let t = -self.closing_sign * torque_n_m;
                [g0 * t, g1 * t]
            }
            SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                let t = (self.extension(pose) + preload_rad) * (-self.closing_sign * stiffness_n_m_per_rad);
                [g0 * t, g1 * t]
            }
        }
    }

    /// Torques on l12 and l22, N·m.
    pub fn link_torques(&self, pose: &Directions<f64>) -> [f64; 2] {
        let torque = -self.closing_sign
            * match self.kind {
                SpringKind::Constant { torque_n_m } => torque_n_m,
                SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                    (self.extension(pose) + preload_rad) * stiffness_n_m_per_rad
                }
            };
        match self.placement {
            Placement::GroundLinks => [0.0; 2],
            Placement::DrivenCoupler => [torque, 0.0],
            Placement::Phalanges => [0.0, torque],
            Placement::CouplerDistal => [torque, -torque],
        }
    }

    /// Stored energy in J, zero in the straight configuration.
    pub fn energy(&self, pose: &Directions<f64>) -> f64 {
        let extension = self.extension(pose);
        match self.kind {
            SpringKind::Constant { torque_n_m } => torque_n_m * extension,
            SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                stiffness_n_m_per_rad * extension * (preload_rad + 0.5 * extension)
            }
        }
    }
}

/// A phalanx: the segment from `base` along the unit vector `axis`, with a radius.
#[derive(Clone, Copy, Debug)]
pub struct Capsule<T> {
    pub base: Vector<T>,
    pub axis: Vector<T>,
    pub length: f64,
    pub radius: f64,
}

impl Capsule<f64> {
    /// Returns the capsule around the segment between two points.
    pub fn between(from: Vector<f64>, to: Vector<f64>, radius: f64) -> Self {
        let along = sub(to, from);
        let length = dot(along, along).sqrt();
        Capsule { base: from, axis: scale(along, 1.0 / length), length, radius }
    }
}

/// Closest points of a phalanx and a shape (thesis (B.1)–(B.2)).
#[derive(Clone, Copy, Debug)]
pub struct ClosestPoints<T> {
    /// Point on the centre line of the phalanx.
    pub foot: Vector<T>,
    /// Unit normal from the shape to the phalanx.
    pub normal: Vector<T>,
    pub gap: T,
    /// Support value of the shape along the normal.
    pub support: Support<T>,
}

/// Finds the closest points. On the face the normal is ± the axis rotated by 90°; beyond an end it points from the
/// shape to that end (the slip to the tip of (2.29)).
#[inline(always)]
pub fn closest_points<T: Real>(capsule: &Capsule<T>, placed: &PlacedShape<T>) -> ClosestPoints<T> {
    let to_centre = sub(placed.centre_m, capsule.base);
    let offset = cross(capsule.axis, to_centre);
    let side = if offset.value() >= 0.0 { -1.0 } else { 1.0 };
    let normal = scale_by(perp(capsule.axis), side);
    let face_support = support(placed, normal);
    // The normal rotated by 90° is −side times the axis.
    let along = dot(to_centre, capsule.axis) - face_support.slope * side;
    let s = along.value();
    if s > 0.0 && s < capsule.length {
        let gap = offset * -side - (face_support.distance + capsule.radius);
        return ClosestPoints {
            foot: add(capsule.base, scale(capsule.axis, along)),
            normal,
            gap,
            support: face_support,
        };
    }
    let end = if s <= 0.0 { capsule.base } else { add(capsule.base, scale_by(capsule.axis, capsule.length)) };
    let (normal, distance) = normal_towards(placed, end);
    let support = support(placed, normal);
    ClosestPoints { foot: end, normal, gap: distance - (support.distance + capsule.radius), support }
}
