//! Links of a gripper that overlap the palm, the table or links of the other finger. No model has contacts for these pairs: the links
//! pass through.

use crate::gripper::Lengths;
use crate::numeric::elementary::{cos, sin, sin_cos};
use crate::numeric::plane::rotate;
use crate::scene::{PalmMotion, Scene, Side};
use crate::trace::{Event, FingerState, Sample, Sink, SinkError};

/// A link by its finger and its name: `l11`, `l12`, `l21`, or `l22` and `t22` of the distal body.
pub type Link = (Side, &'static str);

/// What a link overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// The palm between both ground joints.
    Palm,
    Table,
    Link(Link),
}

/// An overlap over a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkOverlap {
    pub link: Link,
    pub obstacle: Obstacle,
    /// When it was first found.
    pub from_s: f64,
    /// Largest depth, m, and when.
    pub depth_m: f64,
    pub deepest_s: f64,
}

impl LinkOverlap {
    /// A sentence without its full stop.
    pub fn sentence(&self) -> String {
        let name = |(side, link): Link| format!("{link} of the {} finger", side.word());
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

/// Instants of a run at which overlaps are looked for, about.
const INSTANTS: f64 = 256.0;
/// Part of the half width of a link below which an overlap is rounding or the creep of a contact.
const LEAST_PART: f64 = 0.01;

/// Finds the overlaps of a run of a gripper: the deepest of each finger with each obstacle.
#[derive(Clone, Debug)]
pub struct LinkOverlaps {
    lengths: [Lengths; 2],
    palm_width_m: f64,
    palm: bool,
    table_m: Option<f64>,
    palm_motion: Option<PalmMotion>,
    every_s: f64,
    next_s: f64,
    latest: Option<Sample>,
    found: Vec<LinkOverlap>,
}

/// The axis of a link, in the palm's frame.
struct Axis {
    name: &'static str,
    from: [f64; 2],
    to: [f64; 2],
}

impl LinkOverlaps {
    /// `None` where the scene is no gripper.
    pub fn of(scene: &Scene) -> Option<Self> {
        let system = &scene.system;
        (system.fingers.len() == 2).then(|| LinkOverlaps {
            lengths: Side::BOTH.map(|side| system.finger(side).linkage.lengths),
            palm_width_m: system.palm_width_m,
            palm: system.palm.is_some(),
            table_m: system.table.map(|table| table.level_m),
            palm_motion: system.palm_motion.clone(),
            every_s: scene.duration_s / INSTANTS,
            next_s: 0.0,
            latest: None,
            found: Vec::new(),
        })
    }

    /// The overlaps up to the last sample.
    pub fn found(&self) -> Vec<LinkOverlap> {
        let mut all = self.clone();
        if let Some(last) = &self.latest {
            all.look(last);
        }
        all.found
    }

    fn look(&mut self, sample: &Sample) {
        let [Some(right), Some(left)] = [0, 1].map(|side| sample.fingers.get(side)) else { return };
        let axes = [self.axes(Side::Right, right), self.axes(Side::Left, left)];
        let pose = self.palm_motion.as_ref().map(|motion| motion.pose(sample.time_s).place).unwrap_or_default();
        for (side, axes) in Side::BOTH.into_iter().zip(&axes) {
            let half_width_m = self.lengths[side as usize].half_width_m;
            for axis in axes {
                let table = self.table_m.map(|level_m| half_width_m - beyond_table(axis, pose, level_m));
                let palm = self.palm.then(|| half_width_m - self.above_palm(axis));
                self.note(sample.time_s, (side, axis.name), Obstacle::Table, table);
                self.note(sample.time_s, (side, axis.name), Obstacle::Palm, palm);
            }
        }
        let [right, left] = &axes;
        let both_m = self.lengths[0].half_width_m + self.lengths[1].half_width_m;
        let leftmost = right.iter().flat_map(|axis| [axis.from[0], axis.to[0]]).fold(f64::INFINITY, f64::min);
        let rightmost = left.iter().flat_map(|axis| [axis.from[0], axis.to[0]]).fold(f64::NEG_INFINITY, f64::max);
        if leftmost - rightmost >= both_m {
            return;
        }
        for one in right {
            for other in left {
                let depth_m = both_m - distance(one, other);
                let obstacle = Obstacle::Link((Side::Left, other.name));
                self.note(sample.time_s, (Side::Right, one.name), obstacle, Some(depth_m));
            }
        }
    }

    fn note(&mut self, time_s: f64, link: Link, obstacle: Obstacle, depth_m: Option<f64>) {
        let least_m = LEAST_PART * self.lengths[link.0 as usize].half_width_m;
        let Some(depth_m) = depth_m.filter(|depth_m| *depth_m > least_m) else { return };
        let same_kind = |known: &&mut LinkOverlap| {
            known.link.0 == link.0
                && match (known.obstacle, obstacle) {
                    (Obstacle::Link(_), Obstacle::Link(_)) => true,
                    (known, now) => known == now,
                }
        };
        match self.found.iter_mut().find(same_kind) {
            None => self.found.push(LinkOverlap { link, obstacle, from_s: time_s, depth_m, deepest_s: time_s }),
            Some(known) if depth_m > known.depth_m => {
                *known = LinkOverlap { link, obstacle, from_s: known.from_s, depth_m, deepest_s: time_s };
            }
            Some(_) => {}
        }
    }

    /// The links of a finger.
    fn axes(&self, side: Side, finger: &FingerState) -> [Axis; 5] {
        let Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, .. } = self.lengths[side as usize];
        let half_m = 0.5 * self.palm_width_m;
        let placed = |[x, y]: [f64; 2]| [side.mirror() * (half_m + x), y];
        let along = |[x, y]: [f64; 2], length: f64, angle: f64| [x + length * cos(angle), y + length * sin(angle)];
        let joint = [0.0; 2];
        let a12 = along(joint, l11_m, finger.q11_rad);
        let a22 = along(joint, l21_m, finger.q21_rad);
        let axis = |name, from, to| Axis { name, from: placed(from), to: placed(to) };
        [
            axis("l11", joint, a12),
            axis("l12", a12, along(a12, l12_m, finger.q11_rad + finger.q12_rad)),
            axis("l21", joint, a22),
            axis("l22", a22, along(a22, l22_m, finger.q13_rad)),
            axis("t22", a22, along(a22, t22_m, finger.q13_rad + phi22_rad)),
        ]
    }

    /// How far the far end of a link is above the palm, m; infinite beside it, and of joints on the ground.
    fn above_palm(&self, axis: &Axis) -> f64 {
        let [x, y] = axis.to;
        if x.abs() < 0.5 * self.palm_width_m { y } else { f64::INFINITY }
    }
}

/// How far the axis of a link stays from the table, m.
fn beyond_table(axis: &Axis, [_, height, angle]: [f64; 3], level_m: f64) -> f64 {
    let (sin, cos) = sin_cos(angle);
    let far = [axis.from, axis.to].map(|point| height + rotate(point, [cos, sin])[1]);
    level_m - far[0].max(far[1])
}

/// Distance between two segments.
fn distance(one: &Axis, other: &Axis) -> f64 {
    let side =
        |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [px, py]: [f64; 2]| (bx - ax) * (py - ay) - (by - ay) * (px - ax);
    let crosses = |a: &Axis, b: &Axis| side(a.from, a.to, b.from) * side(a.from, a.to, b.to) < 0.0;
    if crosses(one, other) && crosses(other, one) {
        return 0.0;
    }
    let to_segment = |axis: &Axis, [px, py]: [f64; 2]| {
        let ([ax, ay], [bx, by]) = (axis.from, axis.to);
        let (dx, dy) = (bx - ax, by - ay);
        let part = (((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        let (ex, ey) = (px - ax - part * dx, py - ay - part * dy);
        ex * ex + ey * ey
    };
    let ends = [
        to_segment(one, other.from),
        to_segment(one, other.to),
        to_segment(other, one.from),
        to_segment(other, one.to),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min).sqrt()
}

impl Sink for LinkOverlaps {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if sample.time_s >= self.next_s {
            self.look(sample);
            self.next_s = sample.time_s + self.every_s;
            self.latest = None;
        } else {
            match &mut self.latest {
                Some(latest) => latest.clone_from(sample),
                None => self.latest = Some(sample.clone()),
            }
        }
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}
