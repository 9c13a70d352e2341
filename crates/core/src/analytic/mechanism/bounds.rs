//! Bounds of the motion of bodies and joints over a part of a step, from bounds of the coordinates: body by body in the order
//! of placement, with lengths of the links and the pose at one end of the part.

use super::assur::Assur;
use super::assur_bounds::AssurBounds;
use super::body_bounds::{Coordinates, MechanismBounds, length};
use super::dyad::{inner_bodies, transmission};
use super::group::{PlacedGroup, coupled_joints};
use super::joint::{arms, attached_body, joint_between};
use super::motion::Motions;
use crate::analytic::motion_bound::{MotionBound, PinnedPair, RateBound, sine_reach, smallest_sine};
use crate::integrator::{CoordinateBounds, Dynamic};
use crate::mechanism::structure::{Attachment, Placement, Source};
use crate::mechanism::{Joint, Mechanism};
use crate::numeric::plane::{Vector, sub};

impl PlacedGroup {
    /// Bounds the bodies and joints of the group; `motions` are those at one end of the part.
    pub fn bound(
        &self,
        mechanism: &Mechanism,
        (all, motions): (&CoordinateBounds<Dynamic>, &Motions<f64>),
        time: f64,
        bounds: &mut MechanismBounds,
    ) {
        let of_group = self.first..self.first + self.size();
        let coordinates = Coordinates {
            rate: &all.rate[of_group.clone()],
            acceleration: &all.acceleration[of_group],
            width: all.width,
        };
        for placement in &self.group.placements {
            match placement {
                Placement::Free { body, first, axes } => bounds.bodies[*body] = coordinates.free_body(*first, *axes),
                Placement::Prescribed { body } => {
                    // Time is the coordinate; the part extends to either side of the state.
                    let (step_s, span_s) = (coordinates.rate[0], coordinates.rate[0] * all.width);
                    let of = &mechanism.bodies[*body];
                    let [rate, acceleration] = self.largest_rates(of, [time - span_s, time + span_s]);
                    bounds.bodies[*body] = MotionBound {
                        speed: length([rate[0], rate[1]]) * step_s,
                        acceleration: length([acceleration[0], acceleration[1]]) * step_s * step_s,
                        spin: rate[2] * step_s,
                        spin_acceleration: acceleration[2] * step_s * step_s,
                    };
                }
                Placement::Joint { at, coordinate } => {
                    let (joint, base) = (&mechanism.joints[at.joint], *bounds.body(at.base));
                    let bound = match coordinate {
                        Source::Coordinate(index) => coordinates.bound(*index),
                        Source::Coupling(index) => coupled_joints(&mechanism.couplings[*index].on, at.joint)
                            .fold(RateBound::default(), |sum, (joint, ratio)| {
                                sum.plus(bounds.joints[joint].times(ratio))
                            }),
                        Source::Angle => base.turn(),
                    };
                    let turn = match coordinate {
                        Source::Angle => RateBound::default(),
                        _ => base.turn().plus(bound),
                    };
                    let slide = coordinates.largest(motions.joints[at.joint].coordinate, bound.rate);
                    bounds.joints[at.joint] = bound;
                    bounds.bodies[at.body] = attached_body(joint, at, &base, turn, (bound, slide))
                        .with_known_rates(motions.bodies[at.body].rate, (all.step_s, all.width));
                }
                Placement::Dyad { outer, inner } => {
                    let dyad = Dyad { mechanism, outer, inner: *inner, step_s: all.step_s, width: all.width };
                    dyad.bound(motions, bounds);
                }
                Placement::Assur { tree, known, closing } => {
                    let assur = Assur { mechanism, tree, known, closing };
                    AssurBounds { assur, step_s: all.step_s, width: all.width }.bound(&coordinates, motions, bounds);
                }
            }
        }
    }
}

/// A dyad over a part of a step of this width.
struct Dyad<'a> {
    mechanism: &'a Mechanism,
    outer: &'a [Attachment; 2],
    inner: usize,
    step_s: f64,
    width: f64,
}

/// Bounds of a slide that hold while it moves at most by this part of the reach of its bodies.
const SLIDE_MARGIN: f64 = 0.5;

impl Dyad<'_> {
    fn joint(&self, k: usize) -> &Joint {
        &self.mechanism.joints[self.outer[k].joint]
    }

    /// Bounds the bodies and joints of the dyad, and the part of the step in which it stays regular.
    fn bound(&self, motions: &Motions<f64>, bounds: &mut MechanismBounds) {
        let sine = transmission(self.mechanism, (self.outer, self.inner), motions).sine.abs();
        let inner = &self.mechanism.joints[self.inner];
        let slides = [0, 1].map(|k| !self.joint(k).kind.is_angle());
        let (bodies, angle_change) = match (inner.kind.is_angle(), slides) {
            (true, _) => self.pinned(sine, motions, bounds),
            (false, [false, false]) => self.slotted(sine, motions, bounds),
            (false, _) => self.guided(sine, motions, bounds),
        };
        // A reach that is not a number stays.
        let reach = sine_reach(sine, angle_change);
        if reach.is_nan() || reach < bounds.clearance_reach {
            bounds.clearance_reach = reach;
        }
        let bodies = bodies.unwrap_or([(MotionBound::NONE, RateBound::NONE); 2]);
        for (k, at) in self.outer.iter().enumerate() {
            let (body, slide) = bodies[k];
            let base = bounds.body(at.base).turn();
            let body = body.with_known_rates(motions.bodies[at.body].rate, (self.step_s, self.width));
            bounds.joints[at.joint] = if slides[k] { slide } else { base.plus(body.turn()) };
            bounds.bodies[at.body] = body;
        }
        let of = inner_bodies(inner, self.outer).map(|k| bounds.bodies[self.outer[k].body]);
        bounds.joints[self.inner] = joint_between(inner, of);
    }

    /// Distance of the point of the inner joint from that of outer joint `k`, in body `k`.
    fn inner_arm(&self, k: usize) -> f64 {
        length(sub(self.inner_point(k), self.joint(k).points_m[usize::from(self.outer[k].is_second)]))
    }

    /// Point of the inner joint in the frame of body `k`.
    fn inner_point(&self, k: usize) -> [f64; 2] {
        let inner = &self.mechanism.joints[self.inner];
        inner.points_m[usize::from(inner_bodies(inner, self.outer)[0] != k)]
    }

    /// Bound of the relative motion of two carried points, whose velocities at one end of the part are known.
    fn between(&self, points: [RateBound; 2], rates: [Vector<f64>; 2]) -> RateBound {
        points[0].plus(points[1]).with_known_rate(length(sub(rates[1], rates[0])) * self.step_s, self.width)
    }

    /// Velocity of a point that moves with the base of outer joint `k`: the pivot, or the point of the inner joint.
    fn carried_rate(&self, k: usize, of_inner: bool, motions: &Motions<f64>) -> Vector<f64> {
        let (at, base) = (&self.outer[k], motions.body(self.outer[k].base));
        let position = match of_inner {
            false => base.position(self.joint(k).points_m[usize::from(!at.is_second)]),
            true => motions.bodies[at.body].position(self.inner_point(k)),
        };
        base.rate_at(sub(position, base.origin))
    }

    /// Bounds of both bodies with their slides, and the K of their transmission angle; `None` where it may vanish.
    fn pinned(
        &self,
        sine: f64,
        motions: &Motions<f64>,
        bounds: &MechanismBounds,
    ) -> (Option<[(MotionBound, RateBound); 2]>, f64) {
        // A body at a slide does not turn against its base: the inner joint moves with the base, and along the axis.
        let slides = [0, 1].map(|k| !self.joint(k).kind.is_angle());
        let bases = [0, 1].map(|k| *bounds.body(self.outer[k].base));
        let coordinates = [0, 1].map(|k| motions.joints[self.outer[k].joint].coordinate.abs());
        let arms_of = [0, 1].map(|k| arms(self.joint(k), &self.outer[k]));
        let inner_arms = [0, 1].map(|k| self.inner_arm(k));
        let margin = SLIDE_MARGIN * (0..2).map(|k| arms_of[k][0] + coordinates[k] + inner_arms[k]).sum::<f64>();
        let reach = |k: usize| arms_of[k][0] + coordinates[k] + margin;
        let pivots = [0, 1].map(|k| match slides[k] {
            false => bases[k].point(arms_of[k][0]),
            true => bases[k].point(reach(k) + inner_arms[k]),
        });
        let mut total = self.between(pivots, [0, 1].map(|k| self.carried_rate(k, slides[k], motions)));
        if slides == [false, false] {
            let pair = PinnedPair { between: total, arms: inner_arms };
            let change = pair.angle_change();
            let sine = smallest_sine(sine, change, self.width);
            let is_regular = sine > 0.0;
            let turns = pair.turns(sine);
            let body = |k: usize| (MotionBound::about_pivot(pivots[k], turns[k], arms_of[k][1]), RateBound::default());
            return (is_regular.then(|| [body(0), body(1)]), change);
        }
        // The carried points of slides move on their bases, at most by the margin.
        let turned: f64 = (0..2).filter(|k| slides[*k]).map(|k| bases[k].spin * margin).sum();
        total.rate = (total.rate + turned).min(pivots[0].rate + pivots[1].rate);
        let change: f64 = (0..2).map(|k| if slides[k] { bases[k].spin } else { total.rate / inner_arms[k] }).sum();
        // Whether the slides stay within the margin until the sine may vanish.
        let holds = |k: usize| !slides[k] || bases[k].spin == 0.0 || total.rate * sine <= margin * change;
        let change = if holds(0) && holds(1) { change } else { f64::INFINITY };
        let sine = smallest_sine(sine, change, self.width);
        // The columns of the closure: an arm, or the unit vector of a slide.
        let columns = [0, 1].map(|k| if slides[k] { 1.0 } else { inner_arms[k] });
        let rates = columns.map(|column| total.rate / (column * sine));
        let turning = |k: usize| if slides[k] { 2.0 * bases[k].spin } else { columns[k] * rates[k] };
        let quadratic: f64 = (0..2).map(|k| turning(k) * rates[k]).sum();
        let body = |k: usize| {
            let own =
                RateBound { rate: rates[k], acceleration: (total.acceleration + quadratic) / (columns[k] * sine) };
            match slides[k] {
                true => (bases[k].sliding(own, reach(k) + arms_of[k][1]), own),
                false => (MotionBound::about_pivot(pivots[k], own, arms_of[k][1]), RateBound::default()),
            }
        };
        let is_near = |k: usize| !slides[k] || rates[k] * self.width <= margin;
        ((sine > 0.0 && is_near(0) && is_near(1)).then(|| [body(0), body(1)]), change)
    }

    /// Both outer joints turn, the inner one slides: the bodies turn together, by ω (u·D) = n·dD/dΘ with the slide u, its
    /// normal n, and the vector D between both pivots.
    fn slotted(
        &self,
        sine: f64,
        motions: &Motions<f64>,
        bounds: &MechanismBounds,
    ) -> (Option<[(MotionBound, RateBound); 2]>, f64) {
        let arms_of = [0, 1].map(|k| arms(self.joint(k), &self.outer[k]));
        let pivots = [0, 1].map(|k| bounds.body(self.outer[k].base).point(arms_of[k][0]));
        let positions = [0, 1].map(|k| {
            let at = &self.outer[k];
            motions.body(at.base).position(self.joint(k).points_m[usize::from(!at.is_second)])
        });
        let total = self.between(pivots, [0, 1].map(|k| self.carried_rate(k, false, motions)));
        let (distance, moved) = (length(sub(positions[1], positions[0])), total.rate * self.width);
        let (nearest, furthest) = (distance - moved, distance + moved);
        if nearest.is_nan() || nearest <= 0.0 {
            return (None, f64::INFINITY);
        }
        let change = 2.0 * total.rate / nearest;
        let sine = smallest_sine(sine, change, self.width);
        let rate = total.rate / (nearest * sine);
        let quadratic = rate * rate * furthest + 2.0 * rate * total.rate;
        let turn = RateBound { rate, acceleration: (total.acceleration + quadratic) / (nearest * sine) };
        let body = |k: usize| (MotionBound::about_pivot(pivots[k], turn, arms_of[k][1]), RateBound::default());
        ((sine > 0.0).then(|| [body(0), body(1)]), change)
    }

    /// The inner joint and one outer joint slide: both bodies turn with the base of that joint, and the angle between both
    /// slides is constant.
    fn guided(
        &self,
        sine: f64,
        motions: &Motions<f64>,
        bounds: &MechanismBounds,
    ) -> (Option<[(MotionBound, RateBound); 2]>, f64) {
        let slider = usize::from(self.joint(0).kind.is_angle());
        let pivoted = 1 - slider;
        if !self.joint(pivoted).kind.is_angle() {
            return (None, 0.0);
        }
        let [base, other] = [slider, pivoted].map(|k| *bounds.body(self.outer[k].base));
        let arms_of = [slider, pivoted].map(|k| arms(self.joint(k), &self.outer[k]));
        let inner_arms = [slider, pivoted].map(|k| self.inner_arm(k));
        let slide = motions.joints[self.outer[slider].joint].coordinate.abs();
        let inner_slide = motions.joints[self.inner].coordinate.abs();
        let lengths = arms_of[0][0] + arms_of[1][0] + slide + inner_slide + inner_arms[0] + inner_arms[1];
        let margin = SLIDE_MARGIN * lengths;
        let pivot = other.point(arms_of[1][0]);
        let reach = arms_of[0][0] + slide + margin;
        // The point of the pivoted body, the carried point of the other one, and the turning slide between them.
        let point = MotionBound::about_pivot(pivot, base.turn(), inner_arms[1]);
        let turning = base.turn().times(inner_slide + margin);
        let total = RateBound { rate: point.speed, acceleration: point.acceleration }
            .plus(base.point(reach + inner_arms[0]))
            .plus(turning);
        let rate = total.rate / sine;
        let inner_rate = total.rate + rate;
        let quadratic = base.spin * (2.0 * rate + 2.0 * inner_rate + base.spin * (inner_slide + margin));
        let own = RateBound { rate, acceleration: (total.acceleration + quadratic) / sine };
        let bodies = [
            (base.sliding(own, reach + arms_of[0][1]), own),
            (MotionBound::about_pivot(pivot, base.turn(), arms_of[1][1]), RateBound::default()),
        ];
        let is_near = (rate + inner_rate) * self.width <= margin;
        let bodies = if slider == 0 { bodies } else { [bodies[1], bodies[0]] };
        ((sine > 0.0 && is_near).then_some(bodies), 0.0)
    }
}
