//! Overlaps of gripper links with the palm, the table or links of the other finger. The models have no contacts for
//! these pairs, so the links pass through each other.

use super::segments::Hermite;
use crate::gripper::Lengths;
use crate::numeric::elementary::{cos, sin, sin_cos};
use crate::numeric::plane::rotate;
use crate::scene::{PalmMotion, Scene, Side};
use crate::trace::{FingerState, RequiredData, Sample, Sink, SinkError};

/// A link, given by its finger and its name: `l11`, `l12` or `l21`, or `l22` or `t22` for the parts of the distal body.
pub type Link = (Side, &'static str);

/// Body that a link overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// The palm between both ground joints.
    Palm,
    Table,
    Link(Link),
}

/// An overlap of a link with an obstacle during a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkOverlap {
    pub link: Link,
    pub obstacle: Obstacle,
    /// Time of the first overlap, s.
    pub from_s: f64,
    pub depth_m: f64,
    /// Time of the largest depth, s.
    pub deepest_s: f64,
}

impl LinkOverlap {
    /// Returns the overlap as a sentence without a full stop.
    pub fn sentence(&self) -> String {
        let name = |(side, link): Link| format!("{link} of the {} finger", side.name());
        let obstacle = match self.obstacle {
            Obstacle::Palm => "the palm".to_string(),
            Obstacle::Table => "the table".to_string(),
            Obstacle::Link(link) => name(link),
        };
        format!(
            "{} overlaps {obstacle} by up to {:.3} mm at {:.3} ms (first at {:.3} ms); the models have no contact between them",
            name(self.link),
            self.depth_m * 1e3,
            self.deepest_s * 1e3,
            self.from_s * 1e3,
        )
    }
}

/// Approximate number of overlap checks per run.
const CHECKS_PER_RUN: f64 = 256.0;
/// Fraction of the half width of a link below which an overlap is rounding error or creep of a contact.
const MIN_DEPTH_FRACTION: f64 = 0.01;

/// A [`Sink`] that finds the deepest overlap of each finger with each obstacle during a run of a gripper.
#[derive(Clone, Debug)]
pub struct LinkOverlaps {
    lengths: [Lengths; 2],
    palm_width_m: f64,
    has_palm: bool,
    table_m: Option<f64>,
    palm_motion: Option<PalmMotion>,
    interval_s: f64,
    next_check_s: f64,
    /// Time and fingers of the last sample.
    last: Option<(f64, [FingerState; 2])>,
    overlaps: Vec<LinkOverlap>,
}

/// The axis of a link in the palm frame.
struct Axis {
    name: &'static str,
    from: [f64; 2],
    to: [f64; 2],
}

impl LinkOverlaps {
    /// Creates the check for runs of a gripper; `None` for other kinds of scene.
    pub fn for_scene(scene: &Scene) -> Option<Self> {
        let hand = &scene.hand;
        (hand.fingers.len() == 2).then(|| LinkOverlaps {
            lengths: Side::BOTH.map(|side| hand.finger(side).linkage.lengths),
            palm_width_m: hand.palm_width_m,
            has_palm: hand.palm.is_some(),
            table_m: hand.table.map(|table| table.level_m),
            palm_motion: hand.palm_motion.clone(),
            interval_s: scene.duration_s / CHECKS_PER_RUN,
            next_check_s: 0.0,
            last: None,
            overlaps: Vec::new(),
        })
    }

    /// Returns the overlaps up to the last sample.
    pub fn overlaps(&self) -> Vec<LinkOverlap> {
        let mut all = self.clone();
        if let Some((time_s, fingers)) = &self.last {
            all.check(*time_s, fingers);
        }
        all.overlaps
    }

    fn check(&mut self, time_s: f64, [right, left]: &[FingerState; 2]) {
        let axes = [self.axes(Side::Right, right), self.axes(Side::Left, left)];
        let pose = self.palm_motion.as_ref().map(|motion| motion.pose(time_s).position).unwrap_or_default();
        for (side, axes) in Side::BOTH.into_iter().zip(&axes) {
            let half_width_m = self.lengths[side as usize].half_width_m;
            for axis in axes {
                let table = self.table_m.map(|level_m| half_width_m - distance_to_table(axis, pose, level_m));
                // A link whose distal end is not above the palm does not overlap it.
                let [x, height_m] = axis.to;
                let is_above_palm = self.has_palm && x.abs() < 0.5 * self.palm_width_m;
                let palm = is_above_palm.then_some(half_width_m - height_m);
                self.record_overlap(time_s, (side, axis.name), Obstacle::Table, table);
                self.record_overlap(time_s, (side, axis.name), Obstacle::Palm, palm);
            }
        }
        let [right, left] = &axes;
        let both_m = self.lengths[0].half_width_m + self.lengths[1].half_width_m;
        let leftmost = right.iter().flat_map(|axis| [axis.from[0], axis.to[0]]).fold(f64::INFINITY, f64::min);
        let rightmost = left.iter().flat_map(|axis| [axis.from[0], axis.to[0]]).fold(f64::NEG_INFINITY, f64::max);
        if leftmost - rightmost >= both_m {
            return;
        }
        for a in right {
            for b in left {
                let depth_m = both_m - distance(a, b);
                let obstacle = Obstacle::Link((Side::Left, b.name));
                self.record_overlap(time_s, (Side::Right, a.name), obstacle, Some(depth_m));
            }
        }
    }

    fn record_overlap(&mut self, time_s: f64, link: Link, obstacle: Obstacle, depth_m: Option<f64>) {
        let min_depth_m = MIN_DEPTH_FRACTION * self.lengths[link.0 as usize].half_width_m;
        let Some(depth_m) = depth_m.filter(|depth_m| *depth_m > min_depth_m) else { return };
        let is_same_kind = |recorded: &&mut LinkOverlap| {
            recorded.link.0 == link.0
                && match (recorded.obstacle, obstacle) {
                    (Obstacle::Link(_), Obstacle::Link(_)) => true,
                    (recorded, now) => recorded == now,
                }
        };
        match self.overlaps.iter_mut().find(is_same_kind) {
            None => self.overlaps.push(LinkOverlap { link, obstacle, from_s: time_s, depth_m, deepest_s: time_s }),
            Some(recorded) if depth_m > recorded.depth_m => {
                *recorded = LinkOverlap { link, obstacle, from_s: recorded.from_s, depth_m, deepest_s: time_s };
            }
            Some(_) => {}
        }
    }

    fn axes(&self, side: Side, finger: &FingerState) -> [Axis; 5] {
        let Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, .. } = self.lengths[side as usize];
        let half_palm_width_m = 0.5 * self.palm_width_m;
        let to_palm_frame = |[x, y]: [f64; 2]| [side.mirror() * (half_palm_width_m + x), y];
        let link_end = |[x, y]: [f64; 2], length: f64, angle: f64| [x + length * cos(angle), y + length * sin(angle)];
        let joint = [0.0; 2];
        let a12 = link_end(joint, l11_m, finger.q11_rad);
        let a22 = link_end(joint, l21_m, finger.q21_rad);
        let axis = |name, from, to| Axis { name, from: to_palm_frame(from), to: to_palm_frame(to) };
        [
            axis("l11", joint, a12),
            axis("l12", a12, link_end(a12, l12_m, finger.q11_rad + finger.q12_rad)),
            axis("l21", joint, a22),
            axis("l22", a22, link_end(a22, l22_m, finger.q13_rad)),
            axis("t22", a22, link_end(a22, t22_m, finger.q13_rad + phi22_rad)),
        ]
    }
}

/// Returns the distance of the axis of a link from the table, m.
fn distance_to_table(axis: &Axis, [_, height, angle]: [f64; 3], level_m: f64) -> f64 {
    let (sin, cos) = sin_cos(angle);
    let heights = [axis.from, axis.to].map(|point| height + rotate(point, [cos, sin])[1]);
    level_m - heights[0].max(heights[1])
}

/// Returns the distance between two line segments.
fn distance(a: &Axis, b: &Axis) -> f64 {
    let side =
        |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [px, py]: [f64; 2]| (bx - ax) * (py - ay) - (by - ay) * (px - ax);
    let crosses = |a: &Axis, b: &Axis| side(a.from, a.to, b.from) * side(a.from, a.to, b.to) < 0.0;
    if crosses(a, b) && crosses(b, a) {
        return 0.0;
    }
    let to_segment = |axis: &Axis, [px, py]: [f64; 2]| {
        let ([ax, ay], [bx, by]) = (axis.from, axis.to);
        let (dx, dy) = (bx - ax, by - ay);
        let fraction = (((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        let (ex, ey) = (px - ax - fraction * dx, py - ay - fraction * dy);
        ex * ex + ey * ey
    };
    let ends = [to_segment(a, b.from), to_segment(a, b.to), to_segment(b, a.from), to_segment(b, a.to)];
    ends.into_iter().fold(f64::INFINITY, f64::min).sqrt()
}

/// Angles of a finger at a time between two samples.
fn interpolate([a, b]: [&FingerState; 2], [from_s, to_s]: [f64; 2], time_s: f64) -> FingerState {
    let angle = |of: fn(&FingerState) -> (f64, f64)| {
        let ((q0, v0), (q1, v1)) = (of(a), of(b));
        match to_s > from_s {
            true => Hermite::new((from_s, q0, v0), (to_s, q1, v1)).value(time_s),
            false => q1,
        }
    };
    FingerState {
        q11_rad: angle(|finger| (finger.q11_rad, finger.qd11_rad_s)),
        q21_rad: angle(|finger| (finger.q21_rad, finger.qd21_rad_s)),
        q12_rad: angle(|finger| (finger.q12_rad, finger.qd12_rad_s)),
        q13_rad: angle(|finger| (finger.q13_rad, finger.qd21_rad_s + finger.qd22_rad_s)),
        ..*b
    }
}

impl Sink for LinkOverlaps {
    fn required_data(&self) -> RequiredData {
        RequiredData { passive: true, ..RequiredData::NONE }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let (time_s, fingers) = (sample.time_s, [0, 1].map(|side| sample.finger(side)));
        let (from_s, before) = self.last.unwrap_or((time_s, fingers));
        while self.next_check_s <= time_s {
            let fingers =
                [0, 1].map(|side| interpolate([&before[side], &fingers[side]], [from_s, time_s], self.next_check_s));
            self.check(self.next_check_s, &fingers);
            self.next_check_s += self.interval_s;
        }
        self.last = Some((time_s, fingers));
        Ok(())
    }
}
