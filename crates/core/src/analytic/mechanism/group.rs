//! A group of connected bodies with the assembly modes of its dyads: evaluation of all its motions, placement by
//! placement.

use super::dyad::{AssemblyMode, Transmission, close_dyad, inner_motion, solve_dyad, transmission};
use super::motion::{BodyMotion, GroupNumber, JointMotion, Motions, joint_coordinate, joint_rate, pair, place, triple};
use crate::mechanism::structure::{Attachment, Coordinate, Group, Placement, Source};
use crate::mechanism::{JointKind, Mechanism, Pose};
use crate::numeric::plane::{dot, nearest_equivalent_angle, sub};
use crate::numeric::{Real, array_from};

/// A group with the assembly modes of its dyads, in the order of its placements.
#[derive(Clone, Debug)]
pub(super) struct PlacedGroup {
    pub group: Group,
    pub modes: Vec<Option<AssemblyMode>>,
    /// Index of the first coordinate of the group.
    pub first: usize,
}

impl PlacedGroup {
    /// Builds a group from its assembled poses at the start.
    pub fn new<const K: usize>(mechanism: &Mechanism, group: Group, first: usize, poses: &[Pose]) -> Self {
        let mut motions = Motions::<f64, K>::new(mechanism);
        for (motion, pose) in motions.bodies.iter_mut().zip(poses) {
            *motion = BodyMotion::at(*pose, [0.0; 3]);
        }
        let mode = |placement: &Placement| {
            let Placement::Dyad { outer, inner } = placement else { return None };
            let joints = [outer[0].joint, outer[1].joint, *inner].map(|joint| &mechanism.joints[joint]);
            let coordinates = joints.map(|joint| joint_coordinate(joint, |body| *motions.body(body)));
            let bases = pair(|k| motions.body(outer[k].base));
            let distance = |sign: f64| {
                let found = solve_dyad(mechanism, (outer, *inner), bases, &AssemblyMode { sign, coordinates });
                let error = |k: usize| {
                    let error = (found[k] - coordinates[k]).abs();
                    if joints[k].kind == JointKind::Revolute {
                        error
                    } else {
                        error / bases_length(bases, &motions, outer)
                    }
                };
                error(0) + error(1)
            };
            let sign = if distance(-1.0) < distance(1.0) { -1.0 } else { 1.0 };
            Some(AssemblyMode { sign, coordinates })
        };
        let modes = group.placements.iter().map(mode).collect();
        Self { group, modes, first }
    }

    /// Number of coordinates.
    pub fn size(&self) -> usize {
        self.group.coordinates.len()
    }

    /// Evaluates all bodies and joints of the group at the coordinates `q` and rates `v` of the group.
    pub fn evaluate<T: GroupNumber<K>, const K: usize>(
        &self,
        mechanism: &Mechanism,
        (q, v): (&[f64], &[f64]),
        motions: &mut Motions<T, K>,
    ) {
        let coordinate = |index: usize| {
            let mut unit = [0.0; K];
            unit[index] = 1.0;
            JointMotion {
                coordinate: T::with_gradient(q[index], &unit),
                row: array_from(|k| T::constant(unit[k])),
                rate: T::constant(v[index]),
                bias: T::zero(),
            }
        };
        for (placement, mode) in self.group.placements.iter().zip(&self.modes) {
            match placement {
                Placement::Free { body, first } => {
                    let parts = triple(|axis| coordinate(first + axis));
                    motions.bodies[*body] = free_body(&parts);
                }
                Placement::Joint { at, coordinate: source } => {
                    let joint = match source {
                        Source::Coordinate(index) => coordinate(*index),
                        Source::Coupling(index) => coupled_joint(mechanism, *index, at.joint, &motions.joints),
                    };
                    motions.joints[at.joint] = joint;
                    motions.bodies[at.body] = place(&mechanism.joints[at.joint], at, motions.body(at.base), &joint);
                }
                Placement::Dyad { outer, inner } => {
                    let Some(mode) = mode else { continue };
                    let bases = pair(|k| motions.body(outer[k].base));
                    let (bodies, joints) = close_dyad(mechanism, (outer, *inner), bases, mode, v);
                    for (k, at) in outer.iter().enumerate() {
                        motions.bodies[at.body] = bodies[k];
                        motions.joints[at.joint] = joints[k];
                    }
                    let inner_joint = &mut motions.joints[*inner];
                    *inner_joint = inner_motion(&mechanism.joints[*inner], outer, &bodies);
                    if mechanism.joints[*inner].kind == JointKind::Revolute {
                        let angle = inner_joint.coordinate.value();
                        let turns = nearest_equivalent_angle(angle, mode.coordinates[2]) - angle;
                        inner_joint.coordinate = inner_joint.coordinate + turns;
                    }
                }
            }
        }
    }

    /// Transmission of every dyad; a dyad without transmission is singular.
    pub fn transmissions<'a, const K: usize>(
        &'a self,
        mechanism: &'a Mechanism,
        motions: &'a Motions<f64, K>,
    ) -> impl Iterator<Item = (usize, Transmission)> + 'a {
        self.group.placements.iter().enumerate().filter_map(|(index, placement)| match placement {
            Placement::Dyad { outer, inner } => Some((index, transmission(mechanism, (outer, *inner), motions))),
            _ => None,
        })
    }

    /// Angles of the revolute joints of dyads relative to the start: joint, angle, and rate.
    pub fn dyad_angles<'a, const K: usize>(
        &'a self,
        mechanism: &'a Mechanism,
        motions: &'a Motions<f64, K>,
    ) -> impl Iterator<Item = (usize, f64, f64)> + 'a {
        let dyads = self.group.placements.iter().zip(&self.modes).filter_map(|(placement, mode)| match placement {
            Placement::Dyad { outer, inner } => Some(([outer[0].joint, outer[1].joint, *inner], (*mode)?.coordinates)),
            _ => None,
        });
        let joints = dyads.flat_map(|(joints, starts)| joints.into_iter().zip(starts));
        joints.filter(|(joint, _)| mechanism.joints[*joint].kind == JointKind::Revolute).map(|(joint, start)| {
            let motion = &motions.joints[joint];
            (joint, motion.coordinate - start, motion.rate)
        })
    }

    /// Coordinates and rates of the group in assembled poses.
    pub fn start(&self, mechanism: &Mechanism, (poses, rates): (&[Pose], &[Pose])) -> Vec<(f64, f64)> {
        let motion = |body: Option<usize>| {
            body.map_or_else(BodyMotion::<f64, 1>::ground, |body| BodyMotion::at(poses[body], rates[body]))
        };
        let start = |coordinate: &Coordinate| match coordinate {
            Coordinate::Joint(joint) => {
                let joint = &mechanism.joints[*joint];
                (joint_coordinate(joint, motion), joint_rate(joint, motion))
            }
            Coordinate::Body(body, axis) => (poses[*body][*axis], rates[*body][*axis]),
        };
        self.group.coordinates.iter().map(start).collect()
    }
}

fn bases_length<const K: usize>(
    bases: [&BodyMotion<f64, K>; 2],
    motions: &Motions<f64, K>,
    outer: &[Attachment; 2],
) -> f64 {
    let offset = |k: usize| sub(motions.bodies[outer[k].body].origin, bases[k].origin);
    let squared = |k: usize| dot(offset(k), offset(k));
    (squared(0) + squared(1)).sqrt().max(f64::MIN_POSITIVE)
}

/// A body whose pose is three coordinates.
fn free_body<T: Real, const K: usize>(parts: &[JointMotion<T, K>; 3]) -> BodyMotion<T, K> {
    let angle = parts[2].coordinate;
    let (sin, cos) = angle.sin_cos();
    BodyMotion {
        origin: [parts[0].coordinate, parts[1].coordinate],
        direction: [cos, sin],
        angle,
        jacobian: [parts[0].row, parts[1].row, parts[2].row],
        rate: [parts[0].rate, parts[1].rate, parts[2].rate],
        bias: [T::zero(); 3],
    }
}

/// A joint whose coordinate follows from a coupling: q = (value − Σ cᵢ qᵢ)/c.
fn coupled_joint<T: Real, const K: usize>(
    mechanism: &Mechanism,
    coupling: usize,
    joint: usize,
    joints: &[JointMotion<T, K>],
) -> JointMotion<T, K> {
    let coupling = &mechanism.couplings[coupling];
    let own: f64 = coupling.on.terms.iter().filter(|(term, _)| *term == joint).map(|(_, factor)| factor).sum();
    let mut found = JointMotion::at(T::constant(coupling.on.offset / own));
    for (term, factor) in coupling.on.terms.iter().filter(|(term, _)| *term != joint) {
        let (ratio, other) = (-factor / own, &joints[*term]);
        found.coordinate += other.coordinate * ratio;
        found.rate += other.rate * ratio;
        found.bias += other.bias * ratio;
        (0..K).for_each(|k| found.row[k] += other.row[k] * ratio);
    }
    found
}
