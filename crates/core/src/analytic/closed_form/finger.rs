//! The mechanics of one finger in its own frame: links, spring and laws. The motion of the object is prescribed by the
//! caller.

use crate::analytic::contact::Geometry;
use crate::analytic::motion_bound::{MotionBound, PinnedPair, RateBound, sine_reach, smallest_sine};
use crate::fivebar::dynamics::{Dynamics, Terms, absolute_rates, bias, gravity_energy, terms};
use crate::fivebar::joint_forces::{LinkLoads, LinkMotion, joint_forces};
use crate::fivebar::kinematics::{
    Capsule, ClosestPoints, Directions, PassiveBias, PassiveRates, PassiveTurns, SpringModel, closest_points,
    continued_angle, directions, passive_bias, passive_rates, reference_gamma,
};
use crate::gripper::{Assembly, Finger, FingerContact};
use crate::integrator::GapBound;
use crate::law::{FrictionLaw, NormalLaw};
use crate::numeric::Real;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{add, angle_between, cross, dot, perp, rotate, scale_by, sub};
use crate::scene::{FingerContactLaws, HandFinger};
use crate::shape::{PlacedShape, Support};

/// Pose of a finger with its passive rates.
pub(super) type FingerKinematics = (Directions<f64>, PassiveRates<f64>);

/// A finger with all constant terms precomputed.
#[derive(Clone, Debug)]
pub(super) struct FingerModel {
    pub(in crate::analytic) dynamics: Dynamics,
    pub(super) spring: Option<SpringModel>,
    pub(super) limit: Option<NormalLaw>,
    turns: PassiveTurns,
    pub(super) contacts: FingerContactLaws,
    distal: DistalShape,
    links: Finger,
    gravity_m_s2: [f64; 2],
}

impl FingerModel {
    /// Builds the model; the gravity is given in the finger's own frame.
    pub fn new(finger: &HandFinger, gravity_m_s2: [f64; 2]) -> Self {
        let HandFinger { linkage, spring, limit, contact, initial, .. } = finger;
        let lengths = linkage.lengths;
        let reference = reference_gamma(&lengths);
        let gamma = match linkage.assembly {
            Assembly::Reference => reference,
            Assembly::Other => -reference,
        };
        let (sin, cos) = sin_cos(lengths.phi22_rad);
        let start = directions(&lengths, gamma, [initial.q11_rad, initial.q21_rad]);
        Self {
            dynamics: Dynamics::new(linkage, gamma, gravity_m_s2),
            spring: spring.map(|s| SpringModel::new(&s, &lengths, gamma, &start)),
            limit: *limit,
            turns: PassiveTurns::new(&lengths, gamma, &start),
            contacts: *contact,
            distal: DistalShape { l21: lengths.l21_m, t22: lengths.t22_m, w: lengths.half_width_m, phi22: [cos, sin] },
            links: *linkage,
            gravity_m_s2,
        }
    }

    /// Position-dependent terms at q_a.
    #[inline(always)]
    pub(super) fn terms<T: Real>(&self, q: [T; 2]) -> Terms<T> {
        terms(&self.dynamics, directions(&self.dynamics.lengths, self.dynamics.gamma, q))
    }

    /// Link directions and passive rates at q_a, the part of [`FingerModel::terms`] that contact geometry needs.
    #[inline(always)]
    pub(super) fn kinematics(&self, q: [f64; 2]) -> FingerKinematics {
        let pose = directions(&self.dynamics.lengths, self.dynamics.gamma, q);
        let rates = passive_rates(&self.dynamics.lengths, &pose);
        (pose, rates)
    }

    /// Geometry of a phalanx against an object. For the joint limit, see [`FingerModel::limit_geometry`].
    #[inline(always)]
    pub(super) fn phalanx_geometry<T: Real>(
        &self,
        pose: &Directions<T>,
        rates: &PassiveRates<T>,
        contact: FingerContact,
        object: &PlacedShape<T>,
    ) -> Geometry<T> {
        match contact {
            FingerContact::Proximal => proximal(pose, self.distal.l21, self.distal.w, object),
            _ => distal(pose, rates, &self.distal, object),
        }
    }

    /// Geometry of the joint limit. Its gap is q22 + φ22, the angle from l21 to the tip phalanx.
    #[inline(always)]
    pub(super) fn limit_geometry<T: Real>(&self, pose: &Directions<T>, rates: &PassiveRates<T>) -> Geometry<T> {
        let gap = self.bend(pose);
        let row = [rates.a4[0], rates.a4[1] - 1.0];
        let none = [T::zero(); 2];
        Geometry { gap, normal_row: row, tangent_row: none, normal: none, point: none, support: Support::none() }
    }

    /// Bounds of the motion of the finger over a part of a step of this width, from those of q11 and q21 and the sine of the
    /// angle between l12 and l22 at one end of the part.
    #[inline(always)]
    pub(super) fn bounds(&self, sine: f64, [first, second]: [RateBound; 2], width: f64) -> FingerBounds {
        let lengths = &self.dynamics.lengths;
        let pivot = |turn: RateBound, length: f64| MotionBound::new(RateBound::default(), turn).point(length);
        let pivots = [pivot(first, lengths.l11_m), pivot(second, lengths.l21_m)];
        let pair = PinnedPair { between: pivots[0].plus(pivots[1]), arms: [lengths.l12_m, lengths.l22_m] };
        let change = pair.angle_change();
        let smallest = smallest_sine(sine, change, width);
        let turn = if smallest > 0.0 { pair.turns(smallest)[1] } else { RateBound::NONE };
        FingerBounds {
            proximal: MotionBound::new(RateBound::default(), second),
            distal: MotionBound::new(pivots[1], turn),
            limit: turn.plus(second),
            clearance_reach: sine_reach(sine, change),
        }
    }

    /// Bound of the gap between a phalanx and a disc, whose centre has this bound and is at most at this distance from the
    /// base of the finger.
    #[inline(always)]
    pub(super) fn phalanx_bound(
        &self,
        bounds: &FingerBounds,
        contact: FingerContact,
        (centre, distance): (RateBound, f64),
    ) -> GapBound {
        match contact {
            FingerContact::Proximal => bounds.proximal.seen(centre, distance).gap(),
            FingerContact::Distal => bounds.distal.seen(centre, distance + self.distal.l21).gap(),
            FingerContact::Limit => bounds.limit.gap(),
        }
    }

    /// q22 + φ22, measured from the straight line, so that rounding is smallest at the joint limit.
    #[inline(always)]
    fn bend<T: Real>(&self, pose: &Directions<T>) -> T {
        let principal = angle_between(pose.e2, rotate(pose.e4, self.distal.phi22));
        continued_angle(principal, self.turns.near_q22(pose.q_rad) + self.dynamics.lengths.phi22_rad)
    }

    #[inline(always)]
    pub(super) fn normal_law(&self, contact: FingerContact) -> Option<&NormalLaw> {
        match contact {
            FingerContact::Proximal => Some(&self.contacts.proximal.normal),
            FingerContact::Distal => Some(&self.contacts.distal.normal),
            FingerContact::Limit => self.limit.as_ref(),
        }
    }

    #[inline(always)]
    pub(super) fn friction_law(&self, contact: FingerContact) -> Option<&FrictionLaw> {
        match contact {
            FingerContact::Proximal => self.contacts.proximal.friction.as_ref(),
            FingerContact::Distal => self.contacts.distal.friction.as_ref(),
            FingerContact::Limit => None,
        }
    }

    /// τ − c of (2.24) without contacts: motor, spring, gravity and velocity-dependent inertial forces of the links.
    #[inline(always)]
    pub(super) fn load<T: Real>(&self, motor_torque: T, terms: &Terms<T>, v: [T; 2]) -> [T; 2] {
        let c = bias(terms, absolute_rates(&terms.rates, v));
        let load = [motor_torque - c[0], -c[1]];
        let Some(spring) = &self.spring else { return load };
        let force = spring.generalised_force(&terms.pose, &terms.rates);
        [load[0] + force[0], load[1] + force[1]]
    }

    /// Gravity and spring energy in a pose, J.
    pub(super) fn potential_energies(&self, pose: &Directions<f64>) -> [f64; 2] {
        [gravity_energy(&self.dynamics, pose), self.spring.as_ref().map_or(0.0, |spring| spring.energy(pose))]
    }

    /// Forces in the joints, in the order of [`joint_forces`], at these rates and accelerations of q11 and q21.
    /// `contact_forces` are the forces on both phalanges with their contact points.
    pub(super) fn joint_forces(
        &self,
        (pose, passive): (&Directions<f64>, &PassiveRates<f64>),
        [v, accelerations]: [[f64; 2]; 2],
        contact_forces: impl Iterator<Item = (FingerContact, [[f64; 2]; 2])>,
    ) -> [[f64; 2]; 5] {
        let rates = absolute_rates(passive, v);
        let PassiveBias { b3, b4 } = passive_bias(&self.dynamics.lengths, pose, passive);
        let squares = rates.map(|rate| rate * rate);
        let bias = |row: [f64; 4]| row.iter().zip(squares).map(|(factor, square)| factor * square).sum::<f64>();
        let [first, second] = accelerations;
        let absolute =
            [first, second, dot(passive.a3, accelerations) + bias(b3), dot(passive.a4, accelerations) + bias(b4)];
        let mut loads = LinkLoads {
            gravity_m_s2: self.gravity_m_s2,
            torques_n_m: self.spring.map_or([0.0; 2], |spring| spring.link_torques(pose)),
            ..LinkLoads::default()
        };
        let distal_joint = scale_by(pose.e2, self.dynamics.lengths.l21_m);
        for (contact, [force, point]) in contact_forces {
            match contact {
                FingerContact::Proximal => loads.proximal_n = add(loads.proximal_n, force),
                FingerContact::Distal => {
                    loads.distal_n = add(loads.distal_n, force);
                    loads.distal_moment_n_m += cross(sub(point, distal_joint), force);
                }
                // The torque of the joint limit.
                FingerContact::Limit => loads.torques_n_m[1] += force[0],
            }
        }
        joint_forces(&self.links, pose, &LinkMotion { rates, accelerations: absolute }, &loads)
    }

    /// Angles and rates of the passive joints (2.2), (2.8).
    pub(super) fn passive_joints(&self, (pose, rates): &FingerKinematics, q: [f64; 2], v: [f64; 2]) -> PassiveJoints {
        let [_, _, qd3, qd4] = absolute_rates(rates, v);
        let q12 = continued_angle(angle_between(pose.e1, pose.e3), self.turns.near_q12(pose.q_rad));
        let q22 = self.bend(pose) - self.dynamics.lengths.phi22_rad;
        PassiveJoints { q12, q22, q13: q[1] + q22, qd12: qd3 - v[0], qd22: qd4 - v[1] }
    }
}

/// Bounds of the motion of a finger over a part of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct FingerBounds {
    /// The proximal phalanx, with its origin at the base of the finger.
    proximal: MotionBound,
    /// The distal phalanx, with its origin at A22.
    distal: MotionBound,
    /// Bound of the gap of the joint limit.
    limit: RateBound,
    /// Part of the step over which the loop stays regular.
    pub clearance_reach: f64,
}

/// Angles and rates of the passive joints; q13 is the absolute orientation of l22.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassiveJoints {
    pub q12: f64,
    pub q22: f64,
    pub q13: f64,
    pub qd12: f64,
    pub qd22: f64,
}

/// Contact geometry of l21, which rotates about O at q̇21.
#[inline(always)]
pub fn proximal<T: Real>(pose: &Directions<T>, l21: f64, w: f64, object: &PlacedShape<T>) -> Geometry<T> {
    let capsule = Capsule { base: [T::zero(); 2], axis: pose.e2, length: l21, radius: w };
    let ClosestPoints { foot, normal, gap, support } = closest_points(&capsule, object);
    let point = sub(foot, scale_by(normal, w));
    let lever = |direction| dot(perp(point), direction);
    Geometry {
        gap,
        normal_row: [T::zero(), lever(normal)],
        tangent_row: [T::zero(), lever(perp(normal))],
        normal,
        point,
        support,
    }
}

/// Dimensions of the distal phalanx. The angle φ22 is given as (cos, sin).
#[derive(Clone, Copy, Debug)]
pub struct DistalShape {
    pub l21: f64,
    pub t22: f64,
    pub w: f64,
    pub phi22: [f64; 2],
}

/// Contact geometry of t22. A22 moves with l21, and the distal body rotates about A22 at θ̇4.
#[inline(always)]
pub fn distal<T: Real>(
    pose: &Directions<T>,
    rates: &PassiveRates<T>,
    shape: &DistalShape,
    object: &PlacedShape<T>,
) -> Geometry<T> {
    let base = scale_by(pose.e2, shape.l21);
    let capsule = Capsule { base, axis: rotate(pose.e4, shape.phi22), length: shape.t22, radius: shape.w };
    let ClosestPoints { foot, normal, gap, support } = closest_points(&capsule, object);
    let point = sub(foot, scale_by(normal, shape.w));
    let arm = perp(sub(point, base));
    let row = |direction| {
        let lever = dot(arm, direction);
        [lever * rates.a4[0], lever * rates.a4[1] + dot(perp(base), direction)]
    };
    Geometry { gap, normal_row: row(normal), tangent_row: row(perp(normal)), normal, point, support }
}
