//! Assur groups beyond dyads: the smallest sets of bodies whose joints determine all their poses, although no two of them
//! are a dyad. The coordinate of a joint within such a set may be independent, and thus known.

use super::Mechanism;

/// Number of coordinates of a body, and of constraints of a joint.
const COORDINATES: usize = 3;
const CONSTRAINTS: usize = 2;

/// A closed set of bodies: the joint that attaches each body to one that is placed before it, with the side of the body, and
/// the joints that close the loops.
pub(super) struct ClosedSet {
    pub tree: Vec<(usize, usize)>,
    pub closing: Vec<usize>,
}

/// Bodies and joints that are not placed.
struct Rest<'a> {
    mechanism: &'a Mechanism,
    bodies: &'a [usize],
    joints: &'a [usize],
    /// Joints whose coordinates are known.
    known: &'a [usize],
    /// Constraints that determine a coordinate of each of these bodies, by their joints.
    held: Vec<Vec<usize>>,
}

/// Returns the smallest set of bodies that is determined by those that are placed, from the bodies and joints that are not,
/// and the joints whose coordinates are known; `None` if there is none, or if the joints constrain some bodies more than once.
pub(super) fn closed_set(
    mechanism: &Mechanism,
    (bodies, joints): (&[usize], &[usize]),
    known: &[usize],
) -> Option<ClosedSet> {
    let mut rest = Rest { mechanism, bodies, joints, known, held: vec![Vec::new(); bodies.len()] };
    for &joint in joints {
        for _ in 0..CONSTRAINTS + usize::from(known.contains(&joint)) {
            if !rest.assign(joint, &mut vec![false; bodies.len()]) {
                return None;
            }
        }
    }
    let sets = (0..bodies.len()).filter_map(|first| rest.determined_with(first));
    let smallest = sets.min_by_key(Vec::len)?;
    // An angle that forces do not change is no unknown.
    let all_turn = smallest.iter().all(|index| mechanism.bodies[bodies[*index]].rotates());
    if all_turn { rest.ordered(&smallest) } else { None }
}

impl Rest<'_> {
    /// Indices of the bodies of a joint that are not placed.
    fn bodies_of(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        let bodies = self.mechanism.joints[joint].bodies.into_iter().flatten();
        bodies.filter_map(|body| self.bodies.iter().position(|other| *other == body))
    }

    /// Assigns a constraint of a joint to a coordinate of one of its bodies, and others anew where necessary (a matching by
    /// augmenting paths). Returns false if all coordinates are determined by other constraints.
    fn assign(&mut self, joint: usize, visited: &mut [bool]) -> bool {
        let bodies: Vec<usize> = self.bodies_of(joint).collect();
        for body in bodies {
            if std::mem::replace(&mut visited[body], true) {
                continue;
            }
            if self.held[body].len() < COORDINATES {
                self.held[body].push(joint);
                return true;
            }
            for place in 0..COORDINATES {
                if self.assign(self.held[body][place], visited) {
                    self.held[body][place] = joint;
                    return true;
                }
            }
        }
        false
    }

    /// The bodies whose coordinates determine those of a body, with this body, by their indices in ascending order; `None` if
    /// some coordinate is free.
    fn determined_with(&self, first: usize) -> Option<Vec<usize>> {
        let mut set = vec![first];
        let mut next = 0;
        while let Some(&body) = set.get(next) {
            if self.held[body].len() < COORDINATES {
                return None;
            }
            for joint in &self.held[body] {
                for other in self.bodies_of(*joint) {
                    if !set.contains(&other) {
                        set.push(other);
                    }
                }
            }
            next += 1;
        }
        set.sort_unstable();
        Some(set)
    }

    /// The bodies of a set in an order in which each one is attached to one before it, at a joint with a known coordinate if
    /// there is one, or else at a pin if possible. `None` if joints with known coordinates close a loop.
    fn ordered(&self, set: &[usize]) -> Option<ClosedSet> {
        let mut left: Vec<usize> = set.iter().map(|index| self.bodies[*index]).collect();
        let is_in_set = |joint: &usize| self.bodies_of(*joint).any(|body| set.contains(&body));
        let mut closing: Vec<usize> = self.joints.iter().copied().filter(is_in_set).collect();
        let mut tree = Vec::new();
        while !left.is_empty() {
            let is_left = |body: Option<usize>| body.is_some_and(|body| left.contains(&body));
            let attached = |joint: &usize| match self.mechanism.joints[*joint].bodies.map(is_left) {
                [true, false] => Some((*joint, 0)),
                [false, true] => Some((*joint, 1)),
                _ => None,
            };
            let is_slide = |joint: usize| !self.mechanism.joints[joint].kind.is_angle();
            let rank = |(joint, _): &(usize, usize)| (!self.known.contains(joint), is_slide(*joint));
            let (joint, side) = closing.iter().filter_map(attached).min_by_key(rank)?;
            left.retain(|body| self.mechanism.joints[joint].bodies[side] != Some(*body));
            closing.retain(|other| *other != joint);
            tree.push((joint, side));
        }
        let closes_known = closing.iter().any(|joint| self.known.contains(joint));
        (!closes_known).then_some(ClosedSet { tree, closing })
    }
}
