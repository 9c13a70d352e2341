//! Bodies without joints, whose coordinates are the pose of their centre of mass, and frames at centres of mass.

use super::motion::{BodyMotion, Motions};
use crate::mechanism::structure::{Group, Placement};
use crate::mechanism::{Mechanism, Outline, OutlineShape, Pose, SpringKind};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::sub;

/// A body without joints. Its mass matrix is diagonal and constant, because its frame is at its centre of mass.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeBody {
    pub body: usize,
    /// Index of the first coordinate.
    pub first: usize,
    /// Number of coordinates: two for a body that does not rotate, otherwise three.
    pub axes: usize,
    /// Whether the angle of the body has no effect: its outlines are discs about its centre of mass, and nothing else
    /// is attached.
    pub is_round: bool,
    /// Angle at the start, rad; constant for a body that does not rotate.
    pub angle_rad: f64,
    /// Reciprocals of the mass (x, y) and of the inertia.
    pub mobility: [f64; 3],
    pub weight: [f64; 2],
}

impl FreeBody {
    /// Moves the body to the pose and rate that its coordinates give; they come first in `q` and `v`.
    pub fn place(&self, (q, v): (&[f64], &[f64]), motions: &mut Motions<f64>) {
        let body = &mut motions.bodies[self.body];
        (body.origin, body.rate) = ([q[0], q[1]], [v[0], v[1], 0.0]);
        body.angle = self.angle_rad;
        if self.axes == 3 {
            (body.angle, body.rate[2]) = (q[2], v[2]);
        }
        if !self.is_round {
            let (sin, cos) = sin_cos(body.angle);
            body.direction = [cos, sin];
        }
    }
}

/// The only body of a group without joints and prescribed motion, with the number of its coordinates.
pub(super) fn free_body(group: &Group) -> Option<(usize, usize)> {
    match group.placements[..] {
        [Placement::Free { body, axes, .. }] => Some((body, axes)),
        _ => None,
    }
}

/// Moves the frame of a body to its centre of mass.
pub(super) fn center_frame(mechanism: &mut Mechanism, index: usize, (poses, rates): (&mut [Pose], &mut [Pose])) {
    let [x, y] = std::mem::take(&mut mechanism.bodies[index].com_m);
    if [x, y] == [0.0; 2] {
        return;
    }
    let body = BodyMotion::at(poses[index], rates[index]);
    let center = body.point([x, y]);
    poses[index][..2].copy_from_slice(&center.position);
    rates[index][..2].copy_from_slice(&center.rate);
    let shift = |point: &mut [f64; 2]| *point = sub(*point, [x, y]);
    for joint in &mut mechanism.joints {
        let ends = joint.bodies.iter().zip(&mut joint.points_m);
        ends.filter(|(body, _)| **body == Some(index)).for_each(|(_, point)| shift(point));
    }
    for outline in &mut mechanism.bodies[index].outlines {
        outline.shape = outline.shape.moved([-x, -y], 0.0);
    }
    mechanism.bodies[index].points.iter_mut().for_each(|point| shift(&mut point.at_m));
    for spring in &mut mechanism.springs {
        let SpringKind::Linear { bodies, points_m } = &mut spring.kind else { continue };
        let ends = bodies.iter().zip(points_m);
        ends.filter(|(body, _)| **body == Some(index)).for_each(|(_, point)| shift(point));
    }
    let elements = mechanism.tendons.iter_mut().flat_map(|tendon| &mut tendon.path);
    elements.filter(|element| element.body == Some(index)).for_each(|element| shift(&mut element.point_m));
}

/// Whether the outlines of a free body are discs about its origin, and no spring, tendon or point is attached to it.
pub(super) fn is_round(mechanism: &Mechanism, index: usize) -> bool {
    let is_disc = |outline: &Outline| matches!(outline.shape, OutlineShape::Disc { center_m: [0.0, 0.0], .. });
    let springs = mechanism.springs.iter().filter_map(|spring| match &spring.kind {
        SpringKind::Linear { bodies, .. } => Some(*bodies),
        SpringKind::Torsional { .. } => None,
    });
    let elements = mechanism.tendons.iter().flat_map(|tendon| &tendon.path);
    let mut attached = springs.flatten().chain(elements.map(|element| element.body));
    let of = &mechanism.bodies[index];
    of.points.is_empty() && of.outlines.iter().all(is_disc) && attached.all(|body| body != Some(index))
}
