//! Bounds of the gaps of contacts, limits and cables over a part of a step, from those of bodies and joints.

use super::body_bounds::{Coordinates, MechanismBounds, length};
use super::cable::Cable;
use super::contacts::Surfaces;
use super::model::MechanismModel;
use super::motion::Motions;
use super::nearest::PointOnFace;
use crate::analytic::motion_bound::{RateBound, nothing_known};
use crate::integrator::{CoordinateBounds, Dynamic, GapBound, GapBounds};
use crate::mechanism::tendon::{MAX_WRAP_RAD, neighbours, segment, strands, wraps};
use crate::mechanism::{MIN_DISTANCE_M, OutlinePoint, PathElement};
use crate::numeric::plane::sub;

/// Bounds of a segment of a cable: the relative speed of its ends and its smallest length.
fn segment_bound(
    elements: [&PathElement; 2],
    (step_s, width): (f64, f64),
    motions: &Motions<f64>,
    bounds: &MechanismBounds,
) -> (RateBound, f64) {
    let [a, b] = elements.map(|element| bounds.body(element.body).point(length(element.point_m)));
    let [from, to] = elements.map(|element| motions.body(element.body).position(element.point_m));
    let between = sub(to, from);
    let rates = elements.map(|element| {
        let body = motions.body(element.body);
        body.rate_at(body.rotated(element.point_m))
    });
    let ends = a.plus(b).with_known_rate(length(sub(rates[1], rates[0])) * step_s, width);
    // L² = d² − r², and d changes at most at the relative speed of the ends.
    let (straight, distance) = (segment(elements, between).length, length(between));
    let change = ends.rate * width;
    (ends, (straight * straight - change * (2.0 * distance + change)).max(0.0).sqrt())
}

/// Bound of the centre of a path element as seen from a body; 0 if the element is on it.
fn center_seen(
    element: &PathElement,
    body: Option<usize>,
    (step_s, width): (f64, f64),
    motions: &Motions<f64>,
    bounds: &MechanismBounds,
) -> RateBound {
    if element.body == body {
        return RateBound::default();
    }
    let (of_point, from) = (bounds.body(element.body).point(length(element.point_m)), motions.body(body));
    let center = motions.body(element.body).point(element.point_m);
    let offset = sub(center.position, from.origin);
    let distance = length(offset) + (of_point.rate + bounds.body(body).speed) * width;
    let relative = sub(center.rate, from.rate_at(offset));
    bounds.body(body).seen(of_point, distance).with_known_rate(length(relative) * step_s, width)
}

/// Bound of the angle of a segment whose ends move relative to each other within `ends`.
fn turn_bound(elements: [&PathElement; 2], ends: RateBound, width: f64, motions: &Motions<f64>) -> RateBound {
    if ends.rate == 0.0 {
        return RateBound::default();
    }
    let [from, to] = elements.map(|element| motions.body(element.body).position(element.point_m));
    let between = sub(to, from);
    let (straight, change) = (segment(elements, between).length, ends.rate * width);
    let shortest = (straight * straight - change * (2.0 * length(between) + change)).max(0.0).sqrt();
    let offset = (elements[1].signed_radius_m() - elements[0].signed_radius_m()).abs();
    let rate = ends.rate / shortest;
    RateBound { rate, acceleration: ends.acceleration / shortest + rate * rate * (2.0 + offset / shortest) }
}

impl MechanismModel {
    /// Bound of the event function of a path element: of its turn or its gap, as seen from its body.
    fn bound_path_event(
        &self,
        [cable, element]: [usize; 2],
        of_part: (f64, f64),
        motions: &Motions<f64>,
        bounds: &MechanismBounds,
    ) -> GapBound {
        let (path, bends) = (&self.cables[cable].tendon.path, self.cables[cable].bends(&motions.bends));
        let Some([before, after]) = neighbours(bends, element) else { return GapBound::NONE };
        let [before, of, after] = [before, element, after].map(|element| &path[element]);
        let [first, last] = [before, after].map(|end| center_seen(end, of.body, of_part, motions, bounds));
        if bends[element].is_on() {
            let turns = [([before, of], first), ([of, after], last)];
            let [first, last] = turns.map(|(pair, ends)| turn_bound(pair, ends, of_part.1, motions));
            return first.plus(last).gap();
        }
        let ends = first.plus(last);
        let turn = turn_bound([before, after], ends, of_part.1, motions);
        let center = |element: &PathElement| motions.body(element.body).position(element.point_m);
        let radii = before.radius_m + after.radius_m;
        let arm = length(sub(center(of), center(before))) + ends.rate * of_part.1 + radii;
        // The tangent points move along the segment as it turns; the distance from it changes by both motions.
        let turning = RateBound { rate: turn.rate, acceleration: turn.acceleration + turn.rate * turn.rate };
        let coriolis = RateBound { rate: 0.0, acceleration: 2.0 * turn.rate * ends.rate };
        ends.plus(turning.times(arm)).plus(coriolis).gap()
    }

    /// Bounds of all gaps, in the order of the contacts, and of the clearance.
    pub(super) fn bound_gaps(
        &self,
        coordinates: &CoordinateBounds<Dynamic>,
        (q, motions, clearance): (&[f64], &Motions<f64>, f64),
        bounds: &mut MechanismBounds,
        found: &mut GapBounds,
    ) {
        bounds.clearance_reach = f64::INFINITY;
        let CoordinateBounds { rate, acceleration, width, step_s } = coordinates;
        let all = Coordinates { rate, acceleration, width: *width };
        for free in &self.free_bodies {
            bounds.bodies[free.body] = all.free_body(free.first, free.axes);
        }
        let time = self.time_index.map_or(0.0, |time| q[time]);
        for group in &self.groups {
            group.bound(&self.mechanism, (coordinates, motions), time, bounds);
        }
        for cable in &self.cables {
            let gap = self.bound_cable(cable, (*step_s, *width, clearance), motions, bounds);
            cable.contact.into_iter().for_each(|contact| found.gaps[contact] = gap);
        }
        for cable in self.measured_distances() {
            self.bound_distance(cable, (*step_s, *width, clearance), motions, bounds);
        }
        found.clearance_reach = bounds.clearance_reach;
        let first = self.first_path_event();
        for (index, place) in self.monitored.iter().enumerate() {
            found.gaps[first + index] = self.bound_path_event(*place, (*step_s, *width), motions, bounds);
        }
        for (gap, contact) in found.gaps.iter_mut().zip(&self.contacts) {
            match &contact.surfaces {
                Surfaces::Point(pair) => *gap = point_gap(pair, *width, motions, bounds),
                Surfaces::Limit(limit) => {
                    let terms = self.mechanism.limited_terms(limit);
                    let terms = terms.map(|(joint, factor)| bounds.joints[joint].times(factor));
                    *gap = terms.fold(RateBound::default(), RateBound::plus).gap();
                }
                Surfaces::Tendon(_) | Surfaces::Friction(_) | Surfaces::Cable(..) => {}
            }
        }
    }

    /// Bound of the slack of a cable, which changes by the relative motion of the ends of its segments along them. Shortens the
    /// reach of the clearance to the part of the step in which no wrap is too large: a segment turns at most by the relative
    /// speed of its ends over its length.
    fn bound_cable(
        &self,
        cable: &Cable,
        (step_s, width, clearance): (f64, f64, f64),
        motions: &Motions<f64>,
        bounds: &mut MechanismBounds,
    ) -> GapBound {
        let (tendon, bends) = (&cable.tendon, cable.bends(&motions.bends));
        let spools = tendon.spools().map(|(joint, factor)| bounds.joints[*joint].times(*factor));
        let mut sum = spools.fold(RateBound::default(), RateBound::plus);
        // The largest turn of a pulley's cable: that of both segments.
        let (mut largest_turn, mut turn_before) = (0.0f64, 0.0);
        for pair in strands(bends).map(|pair| pair.map(|element| &tendon.path[element])) {
            let (ends, shortest) = segment_bound(pair, (step_s, width), motions, bounds);
            let turn = if ends.rate == 0.0 { 0.0 } else { ends.rate / shortest };
            sum = sum.plus(RateBound { acceleration: ends.acceleration + turn * ends.rate, ..ends });
            let both = turn_before + turn;
            if pair[0].is_pulley() && (both.is_nan() || both > largest_turn) {
                largest_turn = both;
            }
            turn_before = turn;
        }
        // The clearance is at most the margin of any wrap; the wraps themselves are evaluated where that does not suffice.
        let mut margin = clearance;
        if largest_turn * width > margin {
            let center = |element: &PathElement| motions.body(element.body).position(element.point_m);
            let margins = wraps(&tendon.path, bends, center).map(|(_, wrap)| MAX_WRAP_RAD - wrap);
            margin = margins
                .fold(f64::INFINITY, |least, margin| if least.is_nan() || least <= margin { least } else { margin });
        }
        let reach = match largest_turn > 0.0 {
            true if largest_turn.is_finite() => margin / largest_turn,
            false if largest_turn == 0.0 => f64::INFINITY,
            _ => nothing_known(margin),
        };
        if reach.is_nan() || reach < bounds.clearance_reach {
            bounds.clearance_reach = reach;
        }
        sum.gap()
    }
}

impl MechanismModel {
    /// Shortens the reach of the clearance to the part of the step in which two points stay apart.
    fn bound_distance(
        &self,
        cable: &Cable,
        (step_s, width, clearance): (f64, f64, f64),
        motions: &Motions<f64>,
        bounds: &mut MechanismBounds,
    ) {
        let ends = [&cable.tendon.path[0], &cable.tendon.path[1]];
        let (RateBound { rate, .. }, _) = segment_bound(ends, (step_s, width), motions, bounds);
        // The clearance is at most the margin of any distance.
        let margin = match rate * width > clearance {
            true => self.elongation(motions, cable).value - MIN_DISTANCE_M,
            false => clearance,
        };
        let reach = match rate > 0.0 {
            true if rate.is_finite() => margin / rate,
            false if rate == 0.0 => f64::INFINITY,
            _ => nothing_known(margin),
        };
        if reach.is_nan() || reach < bounds.clearance_reach {
            bounds.clearance_reach = reach;
        }
    }
}

/// Bound of the gap between a point outline and a face: the point moves in the frame of the convex face.
fn point_gap(pair: &PointOnFace, width: f64, motions: &Motions<f64>, bounds: &MechanismBounds) -> GapBound {
    let [of_point, of_face] = pair.bodies.map(|body| bounds.body(body));
    let center = match pair.point {
        OutlinePoint::Vertex { point_m, .. } => point_m,
        OutlinePoint::Ellipse { center_m, .. } => center_m,
    };
    let point = of_point.point(length(center));
    let offset = sub(motions.body(pair.bodies[0]).position(center), motions.body(pair.bodies[1]).origin);
    let distance = length(offset) + (point.rate + of_face.speed) * width;
    let seen = of_face.seen(point, distance);
    let OutlinePoint::Ellipse { semi_axes_m: [a, b], .. } = pair.point else { return seen.gap() };
    // The support function of the ellipse has slopes up to its larger axis and second derivatives up to its largest radius
    // of curvature.
    let turn = of_point.turn().plus(of_face.turn());
    let (long, short) = (a.max(b), a.min(b));
    let curving = long * turn.acceleration + long * long / short * turn.rate * turn.rate;
    GapBound { rate: seen.rate + long * turn.rate, curvature: seen.acceleration + curving }
}
