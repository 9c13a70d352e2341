//! The order in which the bodies of a mechanism are placed: joints with coordinates first, then pairs of bodies that
//! close a loop (dyads).
//!
//! Bodies that are connected by joints or by components that act on several joints, other than through the ground, form a
//! group. All bodies with prescribed motion are in one group, whose first coordinate is time. Within a group, an
//! independent coordinate opens a joint, a coupling gives the coordinate of a joint from other joints, and a dyad (two
//! bodies with three joints) is placed by the intersection of two circles or lines. Nearly every planar linkage is a row
//! of dyads after its driven joints. Where there is no row of dyads, a larger Assur group is placed by Newton's method. The
//! search tries joints with a start, an actuator, a spring or a limit first. Where these coordinates fail, because the joints
//! of a dyad come into line, [`regroup`] searches others.

use std::cell::{Cell, RefCell};
use std::collections::HashSet;

use super::assur::{ClosedSet, closed_set};
use super::{Mechanism, PrescribedMotion, Spring};

/// A group of connected bodies and the order in which they are placed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// Bodies in the order in which they are placed.
    pub bodies: Vec<usize>,
    pub placements: Vec<Placement>,
    /// Independent coordinates.
    pub coordinates: Vec<Coordinate>,
}

impl Group {
    /// Number of joints that close loops: one for each dyad. It does not depend on the choice of the coordinates.
    pub fn count_of_dyads(&self) -> usize {
        let count = |placement: &Placement| match placement {
            Placement::Dyad { .. } => 1,
            Placement::Assur { closing, .. } => closing.len(),
            _ => 0,
        };
        self.placements.iter().map(count).sum()
    }

    /// Whether Newton's method places some of the bodies.
    pub fn has_assur(&self) -> bool {
        self.placements.iter().any(|placement| matches!(placement, Placement::Assur { .. }))
    }
}

/// An independent coordinate of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    Joint(usize),
    /// A component (x, y or θ) of the pose of a body without joints to the ground.
    Body(usize, usize),
    /// Time, on which the poses of bodies with prescribed motion depend. It is the first coordinate of their group.
    Time,
}

/// Bodies that are placed from bodies with a known pose.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// A body whose pose is given by coordinates from index `first` on: three `axes`, or two for a body that does not
    /// rotate.
    Free { body: usize, first: usize, axes: usize },
    /// A body with prescribed motion.
    Prescribed { body: usize },
    /// A body at a joint whose coordinate is known.
    Joint { at: Attachment, coordinate: Source },
    /// Two bodies that close a loop at the joint `inner`.
    Dyad { outer: [Attachment; 2], inner: usize },
    /// Bodies whose joints determine their poses, without a dyad among them. The joints of `tree` attach each body to a
    /// preceding body; the joints `closing` close the loops. If the coordinate of a joint of the tree is an independent
    /// coordinate of the group, `known` contains its index.
    Assur { tree: Vec<Attachment>, known: Vec<Option<usize>>, closing: Vec<usize> },
}

/// Placements that a search may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closures {
    Dyads,
    /// Dyads and larger Assur groups.
    All,
}

/// A body, the joint that attaches it, and the body on the other side of the joint, whose pose is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attachment {
    pub joint: usize,
    pub body: usize,
    pub base: Option<usize>,
    /// Whether the placed body is the second body of the joint.
    pub is_second: bool,
}

impl Attachment {
    /// Sign of the rotation of the placed body relative to `base` for a positive joint rotation: ±1.
    #[inline]
    pub fn sign(&self) -> f64 {
        if self.is_second { 1.0 } else { -1.0 }
    }
}

/// Where the coordinate of a joint comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// An independent coordinate of the group, by its index.
    Coordinate(usize),
    /// A coupling with joints whose coordinates are known.
    Coupling(usize),
    /// The constant angle of the attached body, which does not rotate.
    Angle,
}

/// Why the equations of a mechanism cannot be written in independent coordinates.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StructureError {
    #[error(
        "the loop through the joints {} is no row of dyads (two bodies with three joints each), nor of larger groups of \
         bodies that turn and that joints alone determine: give one of these joints an actuator or a start, which makes \
         its coordinate independent, or simulate with `--model engine`",
        joints.join(", ")
    )]
    NoDyad { joints: Vec<String> },
    #[error("the coupling {name} relates joints that other joints already determine: remove it, or one of its joints")]
    Coupling { name: String },
    #[error("no joint of the mechanism can move: remove a joint, so that at least one coordinate is free")]
    NoCoordinate,
    #[error("{what} is not in the analytic model: remove it, or simulate with `--model engine`")]
    Unsupported { what: String },
}

/// Returns the groups of a mechanism, in the order of their first bodies.
///
/// # Errors
/// Returns an error for a loop that is neither a row of dyads nor of larger Assur groups, for a coupling of joints that
/// are already determined, or for a mechanism that cannot move.
pub fn find_groups(mechanism: &Mechanism) -> Result<Vec<Group>, StructureError> {
    let group_of = connected_bodies(mechanism);
    let mut groups = Vec::new();
    for first in 0..mechanism.bodies.len() {
        if group_of[first] == first {
            let search = Search::new(mechanism, |body| group_of[body] == first);
            groups.push(search.run().or_else(|error| match error {
                StructureError::NoDyad { .. } => search.with(Closures::All).run().map_err(|_| error),
                _ => Err(error),
            })?);
        }
    }
    match groups.iter().all(|group| group.coordinates.is_empty()) {
        true => Err(StructureError::NoCoordinate),
        false => Ok(groups),
    }
}

/// Largest number of partial placements that [`regroup`] extends: a limit of its time only. A placement without dead ends
/// extends one for each coordinate, and a mechanism has at most 300 joints.
const MAX_EXTENSIONS: usize = 2000;

/// Returns the group with other coordinates for which all placements are accepted; `None` if there are none.
/// Coordinates of `group` are kept as far as possible; the others are chosen as by [`find_groups`]. Number and layout
/// of the coordinates do not change.
pub fn regroup(
    mechanism: &Mechanism,
    group: &Group,
    closures: Closures,
    accepts: &dyn Fn(&Placement) -> bool,
) -> Option<Group> {
    let search = Search::new(mechanism, |body| group.bodies.contains(&body));
    let search = Search { kept: &group.coordinates, accepts, ..search.with(closures) };
    let found = search.run().ok()?;
    (found.coordinates.len() == group.coordinates.len() && found.count_of_dyads() == group.count_of_dyads())
        .then_some(found)
}

/// Returns the first body of the group of each body.
fn connected_bodies(mechanism: &Mechanism) -> Vec<usize> {
    let mut group_of: Vec<usize> = (0..mechanism.bodies.len()).collect();
    let mut merge = |bodies: &mut dyn Iterator<Item = usize>| {
        let Some(first) = bodies.next() else { return };
        for body in bodies {
            let (kept, merged) = (group_of[first].min(group_of[body]), group_of[first].max(group_of[body]));
            group_of.iter_mut().filter(|group| **group == merged).for_each(|group| *group = kept);
        }
    };
    let Mechanism { joints, couplings, springs, actuators, rotors, sum_limits, bodies, .. } = mechanism;
    joints.iter().for_each(|joint| merge(&mut joint.bodies.into_iter().flatten()));
    let couplings = couplings.iter().map(|coupling| &coupling.on);
    let springs = springs.iter().filter_map(Spring::on);
    let actuators = actuators.iter().map(|actuator| &actuator.on);
    let limits = sum_limits.iter().map(|limit| &limit.on);
    for on in couplings.chain(springs).chain(actuators).chain(rotors.iter().map(|rotor| &rotor.on)).chain(limits) {
        merge(&mut on.terms.iter().flat_map(|(joint, _)| joints[*joint].bodies.into_iter().flatten()));
    }
    merge(&mut (0..bodies.len()).filter(|body| bodies[*body].motion.is_some()));
    group_of
}

/// Search for the placements of one group.
struct Search<'a> {
    mechanism: &'a Mechanism,
    bodies: Vec<usize>,
    joints: Vec<usize>,
    couplings: Vec<usize>,
    /// Coordinates that are tried first.
    kept: &'a [Coordinate],
    closures: Closures,
    accepts: &'a dyn Fn(&Placement) -> bool,
    /// Sets of placed joints that lead to no placement of all bodies.
    failed: RefCell<HashSet<Vec<usize>>>,
    extensions: Cell<usize>,
}

/// Part of a group that is placed so far.
#[derive(Clone, Default)]
struct Partial {
    group: Group,
    joints: Vec<usize>,
    couplings: Vec<usize>,
    /// Joints between bodies that are not placed whose coordinates are independent, with the indices of the coordinates.
    known: Vec<(usize, usize)>,
}

impl<'a> Search<'a> {
    fn new(mechanism: &'a Mechanism, is_member: impl Fn(usize) -> bool) -> Self {
        let has_member = |joint: usize| mechanism.joints[joint].bodies.into_iter().flatten().any(&is_member);
        Self {
            mechanism,
            bodies: (0..mechanism.bodies.len()).filter(|body| is_member(*body)).collect(),
            joints: (0..mechanism.joints.len()).filter(|joint| has_member(*joint)).collect(),
            couplings: (0..mechanism.couplings.len())
                .filter(|coupling| mechanism.couplings[*coupling].on.terms.iter().any(|(joint, _)| has_member(*joint)))
                .collect(),
            kept: &[],
            closures: Closures::Dyads,
            accepts: &|_| true,
            failed: RefCell::default(),
            extensions: Cell::new(0),
        }
    }

    /// A new search with these placements.
    fn with(&self, closures: Closures) -> Self {
        Self {
            bodies: self.bodies.clone(),
            joints: self.joints.clone(),
            couplings: self.couplings.clone(),
            closures,
            failed: RefCell::default(),
            extensions: Cell::new(0),
            ..*self
        }
    }

    fn run(&self) -> Result<Group, StructureError> {
        let (mut start, mut furthest) = (Partial::default(), Partial::default());
        for &body in self.bodies.iter().filter(|body| self.mechanism.bodies[**body].motion.is_some()) {
            start.group.coordinates = vec![Coordinate::Time];
            start.add(Placement::Prescribed { body });
        }
        if let Some(group) = self.extend(start, &mut furthest) {
            return self.with_constant_angles(group);
        }
        let is_left = |joint: &&usize| !furthest.joints.contains(joint);
        let joints: Vec<String> =
            self.joints.iter().filter(is_left).map(|joint| self.mechanism.joints[*joint].name.clone()).collect();
        match self.couplings.iter().find(|coupling| !furthest.couplings.contains(coupling)) {
            Some(coupling) if joints.is_empty() => {
                Err(StructureError::Coupling { name: self.mechanism.couplings[*coupling].name.clone() })
            }
            _ => Err(StructureError::NoDyad { joints }),
        }
    }

    /// Places all bodies, from a part that is placed; `None` if this part leads to no placement of all.
    fn extend(&self, mut partial: Partial, furthest: &mut Partial) -> Option<Group> {
        while let Some(placement) = self.determined(&partial) {
            if !(self.accepts)(&placement) {
                return None;
            }
            partial.add(placement);
        }
        if partial.joints.len() >= furthest.joints.len() {
            *furthest = partial.clone();
        }
        let is_closed_twice = |joint: &usize| {
            !partial.joints.contains(joint)
                && self.mechanism.joints[*joint].bodies.into_iter().all(|body| partial.is_placed(body))
        };
        let is_unused = |coupling: &usize| {
            let terms = &self.mechanism.couplings[*coupling].on.terms;
            !partial.couplings.contains(coupling) && terms.iter().all(|(joint, _)| partial.joints.contains(joint))
        };
        if self.joints.iter().any(is_closed_twice) || self.couplings.iter().any(is_unused) {
            return None;
        }
        if partial.group.bodies.len() == self.bodies.len() {
            return Some(partial.group);
        }
        let mut open: Vec<Attachment> =
            self.joints.iter().filter_map(|joint| self.attachment(&partial, *joint)).collect();
        let is_new = |at: &Attachment| !self.kept.contains(&Coordinate::Joint(at.joint));
        open.sort_by_key(|at| (is_new(at), self.rank(at.joint)));
        if open.is_empty() {
            let index = *self.bodies.iter().find(|body| !partial.is_placed(Some(**body)))?;
            let (first, body) = (partial.group.coordinates.len(), &self.mechanism.bodies[index]);
            let axes = if body.rotates() { 3 } else { 2 };
            partial.group.coordinates.extend((0..axes).map(|axis| Coordinate::Body(index, axis)));
            partial.add(Placement::Free { body: index, first, axes });
            return self.extend(partial, furthest);
        }
        // The order in which joints were placed has no effect on what is left.
        let mut placed = partial.joints.clone();
        placed.sort_unstable();
        placed.push(usize::MAX);
        placed.extend(partial.known.iter().map(|(joint, _)| joint));
        let is_limited = !self.kept.is_empty() || self.closures == Closures::All;
        if is_limited && (self.failed.borrow().contains(&placed) || self.extensions.get() >= MAX_EXTENSIONS) {
            return None;
        }
        self.extensions.set(self.extensions.get() + 1);
        let found = open.into_iter().find_map(|at| {
            let mut next = partial.clone();
            next.group.coordinates.push(Coordinate::Joint(at.joint));
            next.add(Placement::Joint { at, coordinate: Source::Coordinate(next.group.coordinates.len() - 1) });
            self.extend(next, furthest)
        });
        let found = found.or_else(|| self.extend_with_known(&partial, furthest));
        if found.is_none() {
            self.failed.borrow_mut().insert(placed);
        }
        found
    }

    /// Places all bodies with the coordinate of a joint between two bodies that are not placed, if the search may use it.
    fn extend_with_known(&self, partial: &Partial, furthest: &mut Partial) -> Option<Group> {
        if self.closures == Closures::Dyads {
            return None;
        }
        // Joints in ascending order, so that no choice of several is tried twice.
        let last = partial.known.last().map_or(0, |(joint, _)| joint + 1);
        let is_between = |joint: &usize| {
            let bodies = self.mechanism.joints[*joint].bodies;
            *joint >= last && bodies.into_iter().all(|body| body.is_some() && !partial.is_placed(body))
        };
        let mut between: Vec<usize> = self.joints.iter().copied().filter(is_between).collect();
        between.sort_by_key(|joint| (!self.kept.contains(&Coordinate::Joint(*joint)), self.rank(*joint)));
        between.into_iter().find_map(|joint| {
            let mut next = partial.clone();
            next.known.push((joint, next.group.coordinates.len()));
            next.group.coordinates.push(Coordinate::Joint(joint));
            self.extend(next, furthest)
        })
    }

    /// Returns the group, if the placement of every body that does not rotate keeps its angle.
    fn with_constant_angles(&self, group: Group) -> Result<Group, StructureError> {
        let Mechanism { bodies, joints, .. } = self.mechanism;
        let mut turns = vec![true; bodies.len()];
        let is_slider = |joint: usize| !joints[joint].kind.is_angle();
        for placement in &group.placements {
            let base_turns = |at: &Attachment| at.base.is_some_and(|base| turns[base]);
            match placement {
                Placement::Free { body, axes, .. } => turns[*body] = *axes == 3,
                Placement::Prescribed { body } => {
                    let is_palm = matches!(bodies[*body].motion, Some(PrescribedMotion::Palm(_)));
                    turns[*body] = is_palm || bodies[*body].rate[2] != 0.0;
                }
                Placement::Joint { at, coordinate } => {
                    turns[at.body] =
                        if is_slider(at.joint) { base_turns(at) } else { !matches!(coordinate, Source::Angle) };
                }
                Placement::Dyad { outer, inner } => {
                    let slides_on = outer.each_ref().map(|at| is_slider(at.joint) && !base_turns(at));
                    let is_shared = is_slider(*inner) && slides_on != [false; 2];
                    (0..2).for_each(|k| turns[outer[k].body] = !slides_on[k] && !is_shared);
                }
                Placement::Assur { tree, .. } => tree.iter().for_each(|at| turns[at.body] = true),
            }
        }
        match group.bodies.iter().find(|body| turns[**body] && bodies[**body].moves_by_forces() == [true, true, false])
        {
            Some(body) => Err(StructureError::Unsupported {
                what: format!(
                    "the joint of the body `{}`, which does not rotate, to a body that does,",
                    bodies[*body].name
                ),
            }),
            None => Ok(group),
        }
    }

    /// Order in which joints are tried as independent coordinates.
    fn rank(&self, joint: usize) -> usize {
        let Mechanism { joints, actuators, springs, .. } = self.mechanism;
        let of = &joints[joint];
        let has_spring = springs.iter().any(|spring| spring.on().is_some_and(|on| on.factor(joint) != 0.0));
        match () {
            () if of.start.is_some() => 0,
            () if actuators.iter().any(|actuator| actuator.on.factor(joint) != 0.0) => 1,
            () if has_spring || of.limit.is_some() => 2,
            () => 3,
        }
    }

    /// Returns the attachment of the body on one side of a joint, if only the body on the other side is placed.
    fn attachment(&self, partial: &Partial, joint: usize) -> Option<Attachment> {
        match self.mechanism.joints[joint].bodies {
            [base, Some(body)] if partial.is_placed(base) && !partial.is_placed(Some(body)) => {
                Some(Attachment { joint, body, base, is_second: true })
            }
            [Some(body), base] if partial.is_placed(base) && !partial.is_placed(Some(body)) => {
                Some(Attachment { joint, body, base, is_second: false })
            }
            _ => None,
        }
    }

    /// Returns a placement that needs no further coordinate.
    fn determined(&self, partial: &Partial) -> Option<Placement> {
        let known = partial.known.iter().find_map(|(joint, index)| {
            let at = self.attachment(partial, *joint)?;
            Some(Placement::Joint { at, coordinate: Source::Coordinate(*index) })
        });
        if known.is_some() {
            return known;
        }
        let coupled = self.couplings.iter().find_map(|coupling| {
            let terms = &self.mechanism.couplings[*coupling].on.terms;
            let mut unknown = terms.iter().map(|(joint, _)| *joint).filter(|joint| !partial.joints.contains(joint));
            let (joint, None) = (unknown.next()?, unknown.next()) else { return None };
            let at = self.attachment(partial, joint)?;
            (!partial.couplings.contains(coupling))
                .then_some(Placement::Joint { at, coordinate: Source::Coupling(*coupling) })
        });
        let angle = || {
            let mut pins = self.joints.iter().filter(|joint| self.mechanism.joints[**joint].kind.is_angle());
            let at = pins.find_map(|joint| {
                self.attachment(partial, *joint).filter(|at| !self.mechanism.bodies[at.body].rotates())
            })?;
            Some(Placement::Joint { at, coordinate: Source::Angle })
        };
        let dyad = || self.joints.iter().find_map(|inner| self.dyad(partial, *inner));
        coupled.or_else(angle).or_else(dyad).or_else(|| self.assur(partial))
    }

    /// Returns the smallest Assur group beyond a dyad that the placed bodies determine, if the search may use it.
    fn assur(&self, partial: &Partial) -> Option<Placement> {
        if self.closures == Closures::Dyads {
            return None;
        }
        let is_left = |body: &usize| !partial.is_placed(Some(*body));
        let bodies: Vec<usize> = self.bodies.iter().copied().filter(is_left).collect();
        let has_left = |joint: &usize| self.mechanism.joints[*joint].bodies.iter().flatten().any(is_left);
        let joints: Vec<usize> = self.joints.iter().copied().filter(has_left).collect();
        let known: Vec<usize> = partial.known.iter().map(|(joint, _)| *joint).collect();
        let ClosedSet { tree, closing } = closed_set(self.mechanism, (&bodies, &joints), &known)?;
        let attachment = |(joint, side): (usize, usize)| {
            let bodies = self.mechanism.joints[joint].bodies;
            Some(Attachment { joint, body: bodies[side]?, base: bodies[1 - side], is_second: side == 1 })
        };
        let tree: Vec<Attachment> = tree.into_iter().map(attachment).collect::<Option<_>>()?;
        let index_of = |at: &Attachment| partial.known.iter().find(|known| known.0 == at.joint).map(|known| known.1);
        let known = tree.iter().map(index_of).collect();
        // Two bodies between three slides are no dyad.
        (tree.len() > 2).then_some(Placement::Assur { tree, known, closing })
    }

    /// Returns the dyad with this inner joint, if each of its bodies has one joint to a placed body.
    fn dyad(&self, partial: &Partial, inner: usize) -> Option<Placement> {
        let [Some(first), Some(second)] = self.mechanism.joints[inner].bodies else { return None };
        if partial.is_placed(Some(first)) || partial.is_placed(Some(second)) {
            return None;
        }
        let outer_of = |body: usize| {
            let attachments = self.joints.iter().filter_map(|joint| self.attachment(partial, *joint));
            let mut outer = attachments.filter(|at| at.body == body);
            outer.next().filter(|_| outer.next().is_none())
        };
        let outer = [outer_of(first)?, outer_of(second)?];
        let mut joints = [outer[0].joint, inner, outer[1].joint].into_iter();
        let has_pin = joints.any(|joint| self.mechanism.joints[joint].kind.is_angle());
        (has_pin && partial.known.iter().all(|known| known.0 != inner)).then_some(Placement::Dyad { outer, inner })
    }
}

impl Partial {
    fn is_placed(&self, body: Option<usize>) -> bool {
        body.is_none_or(|body| self.group.bodies.contains(&body))
    }

    fn add(&mut self, placement: Placement) {
        match &placement {
            Placement::Free { body, .. } | Placement::Prescribed { body } => self.group.bodies.push(*body),
            Placement::Joint { at, coordinate } => {
                self.group.bodies.push(at.body);
                self.joints.push(at.joint);
                if let Source::Coupling(coupling) = coordinate {
                    self.couplings.push(*coupling);
                }
            }
            Placement::Dyad { outer, inner } => {
                self.group.bodies.extend(outer.map(|at| at.body));
                self.joints.extend([outer[0].joint, *inner, outer[1].joint]);
            }
            Placement::Assur { tree, closing, .. } => {
                self.group.bodies.extend(tree.iter().map(|at| at.body));
                self.joints.extend(tree.iter().map(|at| at.joint).chain(closing.iter().copied()));
            }
        }
        self.group.placements.push(placement);
    }
}
