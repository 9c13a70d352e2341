//! Bounds of the motion of an Assur group beyond dyads over a part of a step.
//!
//! Bounds without evaluations, as those of dyads, need a bound of the rate of the sine, which the lengths of the links give
//! only many times too large. Instead, steps are limited: in a valid step the sine and all coordinates of the group change by
//! at most a part of the sine (`Assur::max_step` and `Assur::is_valid`), so that the sine stays above half of its value at
//! either end of the step, and the group stays regular.

use super::assur::Assur;
use super::body_bounds::{Coordinates, MechanismBounds, length};
use super::joint::{attached_body, joint_between};
use super::motion::Motions;
use crate::analytic::motion_bound::RateBound;
use crate::numeric::plane::{Vector, sub};

/// Smallest sine in a valid step, as a part of that at one end.
const SMALLEST_SINE: f64 = 0.5;
/// Largest change of a slide in a valid step, as a part of the length of the bodies.
const SLIDE_MARGIN: f64 = 0.5;

/// An Assur group over a part of a step of this width.
pub(super) struct AssurBounds<'a> {
    pub assur: Assur<'a>,
    pub step_s: f64,
    pub width: f64,
}

impl AssurBounds<'_> {
    /// Bounds the bodies and joints of the group.
    pub fn bound(&self, coordinates: &Coordinates<'_>, motions: &Motions<f64>, bounds: &mut MechanismBounds) {
        let Assur { mechanism, tree, known, closing } = self.assur;
        let sine = self.assur.sine(motions);
        if sine.is_nan() {
            bounds.clearance_reach = f64::NAN;
        }
        let smallest = SMALLEST_SINE * sine;
        let scales = self.assur.scales();
        let slide_margin = SLIDE_MARGIN * self.assur.length();
        let is_slide = |k: usize| !mechanism.joints[tree[k].joint].kind.is_angle();
        // How far the joints of bodies are apart at most, along the whole tree.
        let slides = (0..tree.len()).filter(|k| is_slide(*k)).map(|k| tree[k].joint);
        let slides = slides.chain(closing.iter().copied().filter(|joint| !mechanism.joints[*joint].kind.is_angle()));
        let slid: Vec<f64> = slides.map(|joint| motions.joints[joint].coordinate.abs() + slide_margin).collect();
        let links = tree.len() as f64 * self.assur.length();
        let extent = links + slid.iter().sum::<f64>();
        let lever = if slid.is_empty() { self.assur.length() } else { extent };
        // The base from which each body is reached.
        let mut roots: Vec<Option<usize>> = Vec::with_capacity(tree.len());
        for at in tree {
            roots.push(self.assur.member(at.base).map_or(at.base, |k| roots[k]));
        }
        let root_of = |body: Option<usize>| self.assur.member(body).map_or(body, |k| roots[k]);
        // Turns and slides of the joints with known coordinates, all along one path.
        let (mut known_turn, mut known_slide) = (RateBound::default(), RateBound::default());
        for (k, index) in known.iter().enumerate().filter_map(|(k, index)| Some((k, (*index)?))) {
            let sum = if is_slide(k) { &mut known_slide } else { &mut known_turn };
            *sum = sum.plus(coordinates.bound(index));
        }
        // The misfit that the motion of the bases and these joints leave, with the other bodies carried along.
        let (mut misfit, mut largest_spin) = (RateBound::default(), 0.0f64);
        for joint in closing.iter().map(|joint| &mechanism.joints[*joint]) {
            let bases = joint.bodies.map(root_of);
            let moved = known_slide.plus(known_turn.times(2.0 * extent));
            misfit = misfit.plus(moved.times(2.0));
            if !joint.kind.is_angle() {
                misfit = misfit.plus(known_turn.times(2.0 * self.assur.length()));
            }
            if bases[0] == bases[1] {
                largest_spin = largest_spin.max(bounds.body(bases[0]).spin);
                continue;
            }
            let position = |side: usize| motions.body(joint.bodies[side]).position(joint.points_m[side]);
            let carried = |side: usize| -> (RateBound, Vector<f64>) {
                let (bound, base) = (bounds.body(bases[side]), motions.body(bases[side]));
                let arm = sub(position(side), base.origin);
                largest_spin = largest_spin.max(bound.spin);
                (bound.point(length(arm) + 2.0 * extent), base.rate_at(arm))
            };
            let [(first, first_rate), (second, second_rate)] = [0, 1].map(carried);
            let known = length(sub(second_rate, first_rate)) * self.step_s;
            misfit = misfit.plus(first.plus(second).with_known_rate(known, self.width));
            if !joint.kind.is_angle() {
                let turns = bounds.body(bases[0]).turn().plus(bounds.body(bases[1]).turn());
                misfit = misfit.plus(turns.times(self.assur.length()));
            }
        }
        largest_spin += known_turn.rate;
        let rate = misfit.rate / smallest;
        let spins: Vec<f64> = (0..tree.len()).map(|k| largest_spin + rate / scales[k]).collect();
        let spin = (0..tree.len()).filter(|k| !is_slide(*k)).map(|k| spins[k]).fold(largest_spin, f64::max);
        // Centripetal and Coriolis terms of every body, once for each side of each closing joint.
        let slide_rate = rate + known_slide.rate;
        let turning = |k: usize| if is_slide(k) { 2.0 * spin * slide_rate } else { lever * spins[k] * spins[k] };
        let mut quadratic = closing.len() as f64 * (0..tree.len()).map(turning).sum::<f64>();
        if !slid.is_empty() {
            let speed = misfit.rate + 2.0 * (tree.len() as f64 * (lever * spin + slide_rate));
            quadratic += closing.len() as f64 * (2.0 * spin * speed + spin * spin * extent);
        }
        let acceleration = (misfit.acceleration + quadratic) / smallest;
        for (k, at) in tree.iter().enumerate() {
            let (joint, base, root) = (&mechanism.joints[at.joint], *bounds.body(at.base), *bounds.body(roots[k]));
            let own = RateBound { rate: rate / scales[k], acceleration: acceleration / scales[k] };
            let own = known[k].filter(|_| is_slide(k)).map_or(own, |index| coordinates.bound(index));
            let turn = root.turn().plus(known_turn).plus(own);
            let slide = motions.joints[at.joint].coordinate.abs() + slide_margin;
            let body = attached_body(joint, at, &base, turn, (own, slide));
            let body = body.with_known_rates(motions.bodies[at.body].rate, (self.step_s, self.width));
            bounds.joints[at.joint] = if is_slide(k) { own } else { base.turn().plus(body.turn()) };
            bounds.bodies[at.body] = body;
        }
        for &joint in closing {
            let joint_of = &mechanism.joints[joint];
            bounds.joints[joint] = joint_between(joint_of, joint_of.bodies.map(|body| *bounds.body(body)));
        }
    }
}
