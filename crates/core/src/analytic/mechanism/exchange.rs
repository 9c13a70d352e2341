//! Exchange of coordinates. The coordinates of a group fail where the joints of a dyad come into line, although the
//! mechanism may be regular in others: a crank that is driven from its slider passes its dead centre. Then others take over.

use super::conditioning::{better_group, smallest_sine};
use super::group::PlacedGroup;
use super::model::{MechanismMode, MechanismModel};
use super::motion::Motions;
use crate::analytic::contact::StateRef;
use crate::integrator::Dynamic;
use crate::mechanism::structure::{Coordinate, Group};
use crate::mechanism::{Mechanism, Pose};
use crate::numeric::elementary::atan2;

/// Coordinates and rates of the model with other coordinates, and its mode.
type Exchanged = (MechanismModel, (Vec<f64>, Vec<f64>), MechanismMode);

impl MechanismModel {
    /// Smallest |sine| of the transmission angles of all dyads and Assur groups; it is small near a singularity.
    pub fn conditioning(&self, state: StateRef<'_, Dynamic>, mode: &MechanismMode) -> f64 {
        self.count_turns_as(mode);
        self.with_motions(state, |motions| {
            let sines = self.groups.iter().map(|group| smallest_sine(&self.mechanism, &group.group, motions));
            sines.fold(f64::INFINITY, f64::min)
        })
    }

    /// The mechanism with the infinite inertia of bodies that do not rotate, which the model replaces.
    fn as_described(&self) -> Mechanism {
        let mut mechanism = self.mechanism.clone();
        for (body, moves) in mechanism.bodies.iter_mut().zip(&self.moves_by_forces) {
            if body.motion.is_none() && !moves[2] {
                body.inertia_kg_m2 = f64::INFINITY;
            }
        }
        mechanism
    }

    /// Describes the singularity of a dyad with these joints, the inner one in the middle, or of an Assur group.
    pub(super) fn describe_singularity(&self, motions: &Motions<f64>, joints: &[usize]) -> String {
        let bodies = motions.bodies[..self.mechanism.bodies.len()].iter();
        let pose = |[x, y]: [f64; 2], [cos, sin]: [f64; 2]| [x, y, atan2(sin, cos)];
        let poses: Vec<Pose> = bodies.map(|body| pose(body.origin, body.direction)).collect();
        self.as_described().describe_singularity(&poses, joints)
    }

    /// Whether both models have the same coordinates.
    pub fn has_coordinates_of(&self, other: &Self) -> bool {
        self.groups.len() == other.groups.len()
            && self.groups.iter().zip(&other.groups).all(|(own, other)| own.group == other.group)
    }

    /// Returns the model in coordinates that are much better conditioned in a state, with the coordinates, rates and
    /// mode of that state; `None` if there are none. Internal states of friction and the laws of contacts and actuators
    /// do not change. Turns are counted from this state on.
    pub fn exchanged(&self, (q, v): StateRef<'_, Dynamic>, mode: &MechanismMode) -> Option<Exchanged> {
        self.count_turns_as(mode);
        let mechanism = self.as_described();
        let groups = self.with_angles((q, v), |motions| {
            let better = |(index, placed): (usize, &PlacedGroup)| {
                Some((index, better_group(&mechanism, &placed.group, motions)?))
            };
            self.groups.iter().enumerate().filter_map(better).collect()
        });
        self.with_groups(groups, (q, v), mode)
    }

    /// Returns the model in the coordinates of another model with the same structure; `None` if it already has these
    /// coordinates.
    pub fn in_coordinates_of(
        &self,
        other: &Self,
        state: StateRef<'_, Dynamic>,
        mode: &MechanismMode,
    ) -> Option<Exchanged> {
        let pairs = self.groups.iter().zip(&other.groups).enumerate();
        let different = pairs.filter(|(_, (own, other))| own.group != other.group);
        self.with_groups(different.map(|(index, (_, other))| (index, other.group.clone())).collect(), state, mode)
    }

    /// The model with other groups, by their indices; `None` without any.
    fn with_groups(
        &self,
        groups: Vec<(usize, Group)>,
        (q, v): StateRef<'_, Dynamic>,
        mode: &MechanismMode,
    ) -> Option<Exchanged> {
        if groups.is_empty() {
            return None;
        }
        self.count_turns_as(mode);
        let (joints, poses) = self.with_angles((q, v), |motions| {
            let joints: Vec<(f64, f64)> = motions.joints.iter().map(|joint| (joint.coordinate, joint.rate)).collect();
            let bodies = motions.bodies.iter();
            let poses: Vec<Pose> = bodies.map(|body| [body.origin[0], body.origin[1], body.angle]).collect();
            (joints, poses)
        });
        let (mut next, mut next_mode, mut state) = (self.clone(), mode.clone(), (q.clone(), v.clone()));
        for (index, group) in groups {
            let old = &self.groups[index];
            for (i, coordinate) in group.coordinates.iter().enumerate() {
                let kept = old.group.coordinates.iter().position(|other| other == coordinate);
                (state.0[old.first + i], state.1[old.first + i]) = match (coordinate, kept) {
                    (_, Some(kept)) => (q[old.first + kept], v[old.first + kept]),
                    (Coordinate::Joint(joint), None) => joints[*joint],
                    (Coordinate::Body(..) | Coordinate::Time, None) => return None,
                };
            }
            next_mode.counts[old.counts()].fill(0);
            next.replace_group(index, group, &poses);
        }
        next_mode.near = next.near_at_start().to_vec();
        Some((next, state, next_mode))
    }
}
