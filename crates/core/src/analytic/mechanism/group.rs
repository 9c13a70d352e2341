//! A group of connected bodies with the assembly modes of its dyads: evaluation of all its motions, placement by
//! placement.

use super::assur::Assur;
use super::dyad::{
    AssemblyMode, PivotLine, Transmission, close_dyad, inner_bodies, middles, mode_at_start, move_inner_joint,
    outer_angle, pivot_offset, place_dyad, transmission,
};
use super::joint::{carried, carried_bias, column, joint_coordinate, joint_rate, place};
use super::motion::{BodyMotion, JointMotion, LANES, Lanes, Motions, Part, Support, pair, triple};
use super::palm_frame::Inertia;
use crate::mechanism::structure::{Attachment, Coordinate, Group, Placement, Source};
use crate::mechanism::{
    Actuator, Body, Command, Joint, JointCombination, JointKind, Mechanism, Pose, PrescribedMotion, Spring, SpringKind,
};
use crate::numeric::elementary::atan2;
use crate::numeric::plane::{cross, dot, nearest_equivalent_angle, perp, sub};
use crate::numeric::{Dual, Real};
use crate::scene;
use std::ops::Range;

/// Derivative of a combination of joint coordinates by the coordinates of the group.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    /// Coordinates on which the combination depends.
    pub support: Vec<usize>,
    /// Its derivatives by them, if all joints are coordinates.
    constant: Option<Vec<f64>>,
}

impl Row {
    /// `of_joints` are the coordinates on which each joint depends.
    fn new(group: &Group, of_joints: &[Vec<usize>], on: &JointCombination) -> Self {
        let terms = || on.terms.iter().filter(|(_, factor)| *factor != 0.0);
        let support = Support::union(terms().map(|(joint, _)| &of_joints[*joint][..]));
        let is_coordinate = |joint: usize| group.coordinates.contains(&Coordinate::Joint(joint));
        let factor = |index: &usize| match group.coordinates[*index] {
            Coordinate::Joint(joint) => on.factor(joint),
            Coordinate::Body(..) | Coordinate::Time => 0.0,
        };
        let is_constant = terms().all(|(joint, _)| is_coordinate(*joint));
        let constant = is_constant.then(|| support.iter().map(factor).collect());
        Self { support, constant }
    }

    /// Adds the generalised loads of an effort on the combination.
    #[inline(always)]
    pub fn add_load(&self, motions: &Motions<f64>, on: &JointCombination, effort: f64, load: &mut [f64]) {
        match &self.constant {
            Some(entries) => self.support.iter().zip(entries).for_each(|(i, entry)| load[*i] += entry * effort),
            None => self.support.iter().for_each(|i| load[*i] += motions.row_entry(on, *i) * effort),
        }
    }
}

/// Stiffness, damping and inertia on a combination of joint coordinates: Q = preload − k (q − rest) − d q̇ − I q̈.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub on: JointCombination,
    pub row: Row,
    pub preload: f64,
    pub stiffness: f64,
    pub rest: f64,
    pub damping: f64,
    pub inertia: f64,
}

impl Element {
    /// Torque or force, without that of the inertia.
    pub fn effort(&self, coordinate: f64, rate: f64) -> f64 {
        self.preload - self.stiffness * (coordinate - self.rest) - self.damping * rate
    }
}

/// Loads on the coordinates of a group and entries of its mass matrix, by rows, that do not change: those of springs of
/// constant force and of rotors on joints that are coordinates.
#[derive(Clone, Debug)]
pub(super) struct Constant {
    pub load: Vec<f64>,
    pub mass: Vec<f64>,
}

/// A group with the assembly modes of its dyads, in the order of its placements.
#[derive(Clone, Debug)]
pub(super) struct PlacedGroup {
    pub group: Group,
    pub modes: Vec<Option<AssemblyMode>>,
    /// Bodies with inertia.
    pub inertias: Vec<(usize, Inertia)>,
    /// Stiffness, damping and inertia on the joints of the group.
    pub elements: Vec<Element>,
    /// Indices of the elements whose effort or inertia varies with the coordinates. The other elements are included in
    /// `constant`.
    pub varying: Vec<usize>,
    pub constant: Constant,
    /// Joints of the group.
    pub joints: Vec<usize>,
    /// Actuators of the group.
    pub actuators: Vec<(usize, Row)>,
    /// Index of the first coordinate of the group.
    pub first: usize,
    /// Whether the equations are written in the frame of a moving palm. The prescribed motion is then that of the
    /// world.
    pub is_in_palm_frame: bool,
    /// Index of the first count of turns of the group, which has one for each dyad.
    first_count: usize,
}

impl PlacedGroup {
    /// Builds a group from its assembled poses at the start. `first` is the index of its first coordinate;
    /// `first_count`, that of its first count of turns.
    pub fn new(mechanism: &Mechanism, group: Group, (first, first_count): (usize, usize), poses: &[Pose]) -> Self {
        let motions = motions_at(mechanism, poses);
        let mut count = first_count;
        let mode = |placement: &Placement| {
            let (outer, inner) = match placement {
                Placement::Dyad { outer, inner } => (outer, inner),
                Placement::Assur { tree, known, closing } => {
                    count += closing.len();
                    let sign = Assur { mechanism, tree, known, closing }.sign(&motions);
                    return Some(AssemblyMode {
                        sign,
                        middles_rad: [0.0; 2],
                        line: None,
                        has_angles: true,
                        moves_joints: [true; 3],
                    });
                }
                _ => return None,
            };
            let of_dyad = [outer[0].joint, outer[1].joint, *inner];
            let joints = of_dyad.map(|joint| &mechanism.joints[joint]);
            let coordinates = joints.map(|joint| joint_coordinate(joint, |body| *motions.body(body)));
            let bases = pair(|k| motions.body(outer[k].base));
            let of_ranges = mode_at_start(mechanism, (outer, *inner), &motions, count);
            count += 1;
            let ranges = pair(|k| motions.bodies[outer[k].body].angle);
            let distance = |sign: f64| {
                let mode = AssemblyMode { sign, ..of_ranges };
                let (_, found) = place_dyad(mechanism, (outer, *inner), bases, (&mode, ranges));
                let error = |k: usize| {
                    let error = (found[k] - coordinates[k]).abs();
                    if joints[k].kind.is_angle() { error } else { error / bases_length(bases, &motions, outer) }
                };
                error(0) + error(1)
            };
            let sign = if distance(-1.0) < distance(1.0) { -1.0 } else { 1.0 };
            let is_base =
                |body: usize| group.placements.iter().any(|other| bases_of(mechanism, other).contains(&Some(body)));
            let both_slide = outer.iter().all(|at| !mechanism.joints[at.joint].kind.is_angle());
            let has_angles = both_slide
                || outer.iter().any(|at| is_base(at.body))
                || of_dyad.into_iter().any(|joint| has_force(mechanism, joint));
            let moves_joints = of_dyad.map(|joint| is_in_force(mechanism, joint));
            Some(AssemblyMode { sign, has_angles, moves_joints, ..of_ranges })
        };
        let modes = group.placements.iter().map(mode).collect();
        let joints = group.placements.iter().flat_map(|placement| match placement {
            Placement::Free { .. } | Placement::Prescribed { .. } => Vec::new(),
            Placement::Joint { at, .. } => vec![at.joint],
            Placement::Dyad { outer, inner } => vec![outer[0].joint, outer[1].joint, *inner],
            Placement::Assur { tree, known, closing } => Assur { mechanism, tree, known, closing }.joints().collect(),
        });
        let joints: Vec<usize> = joints.collect();
        let is_member = |on: &&JointCombination| on.terms.iter().any(|(joint, _)| joints.contains(joint));
        let none = Element {
            on: JointCombination::default(),
            row: Row::default(),
            preload: 0.0,
            stiffness: 0.0,
            rest: 0.0,
            damping: 0.0,
            inertia: 0.0,
        };
        let of_joint = |joint: &usize| {
            let Joint { damping, armature: inertia, .. } = mechanism.joints[*joint];
            Element { on: JointCombination::of_joint(*joint), damping, inertia, ..none.clone() }
        };
        let on_joints = joints.iter().map(of_joint).filter(|element| element.damping != 0.0 || element.inertia != 0.0);
        let springs = mechanism.springs.iter().filter_map(|spring| match &spring.kind {
            SpringKind::Torsional { on, preload } => Some(Element {
                on: Some(on).filter(is_member)?.clone(),
                preload: *preload,
                stiffness: spring.stiffness,
                rest: spring.rest,
                damping: spring.damping,
                ..none.clone()
            }),
            SpringKind::Linear { .. } => None,
        });
        let rotors = mechanism.reflected_inertias().filter(|(on, _)| is_member(on));
        let rotors = rotors.map(|(on, inertia)| Element { on: on.clone(), inertia, ..none.clone() });
        let actuators = mechanism.actuators.iter().enumerate().filter(|(_, actuator)| is_member(&&actuator.on));
        let of_joints = dependent_coordinates(mechanism, &group).1;
        let row = |on: &JointCombination| Row::new(&group, &of_joints, on);
        let actuators = actuators.map(|(index, actuator)| (index, row(&actuator.on)));
        let with_row = |element: Element| Element { row: row(&element.on), ..element };
        let elements: Vec<Element> = on_joints.chain(springs).chain(rotors).map(with_row).collect();
        let actuators = actuators.collect();
        let (constant, varying) = constant_parts(&group, &elements);
        let inertias = group.bodies.iter().map(|body| (*body, Inertia::of(&mechanism.bodies[*body])));
        let inertias = inertias.filter(|(_, inertia)| inertia.mass != 0.0 || inertia.moment != 0.0).collect();
        Self {
            modes,
            inertias,
            elements,
            varying,
            constant,
            actuators,
            joints,
            group,
            first,
            is_in_palm_frame: false,
            first_count,
        }
    }

    /// Indices of the counts of turns of the group.
    pub fn counts(&self) -> Range<usize> {
        self.first_count..self.first_count + self.group.count_of_dyads()
    }

    /// Whether the group contains bodies with prescribed motion. Its first coordinate is then time.
    pub fn has_prescribed(&self) -> bool {
        self.group.coordinates.first() == Some(&Coordinate::Time)
    }

    /// Pose of a body with prescribed motion. In the frame of a moving palm, it is the world.
    fn prescribed(&self, body: &Body, t: f64) -> scene::Pose {
        match &body.motion {
            Some(PrescribedMotion::Palm(motion)) if self.is_in_palm_frame => motion.world_pose(t),
            Some(motion) => motion.at((body.pose, body.rate), t),
            None => scene::Pose::default(),
        }
    }

    /// Upper bounds of the rates and of the accelerations of a body with prescribed motion between two times.
    pub fn largest_rates(&self, body: &Body, times: [f64; 2]) -> [[f64; 3]; 2] {
        match &body.motion {
            Some(PrescribedMotion::Palm(motion)) if self.is_in_palm_frame => motion.largest_world_rates(times),
            Some(motion) => motion.largest_rates(body.rate, times),
            None => [[0.0; 3]; 2],
        }
    }

    /// Number of coordinates.
    pub fn size(&self) -> usize {
        self.group.coordinates.len()
    }

    /// Number of evaluations with [`LANES`] derivatives each that the derivatives with respect to all coordinates need.
    pub fn chunks(&self) -> usize {
        self.size().div_ceil(LANES)
    }

    /// Coordinates and rates of the group, taken from those of all groups.
    #[inline(always)]
    pub fn state<'a>(&self, (q, v): (&'a [f64], &'a [f64])) -> (&'a [f64], &'a [f64]) {
        let of_group = self.first..self.first + self.size();
        (&q[of_group.clone()], &v[of_group])
    }

    /// Appends room for the derivatives of the bodies and joints of the group to `motions`.
    pub fn add_supports(&self, mechanism: &Mechanism, motions: &mut Motions<f64>) {
        let (of_bodies, of_joints) = dependent_coordinates(mechanism, &self.group);
        let size = self.size();
        for &body in &self.group.bodies {
            let (first, coordinates) = (motions.columns.len(), of_bodies[body].clone());
            motions.body_supports[body] = Support { first, coordinates };
            motions.columns.resize(first + size, [0.0; 3]);
        }
        for &joint in &self.joints {
            let (first, coordinates) = (motions.rows.len(), of_joints[joint].clone());
            motions.joint_supports[joint] = Support { first, coordinates };
            motions.rows.resize(first + size, 0.0);
            // The row of a coordinate does not change.
            if let Some(index) = self.group.coordinates.iter().position(|of| *of == Coordinate::Joint(joint)) {
                motions.rows[first + index] = 1.0;
            }
        }
    }

    /// Evaluates a part of the motions of all bodies and joints of the group at the coordinates `q` and rates `v` of
    /// the group. `Part::Derivatives` requires that the poses and rates of the same state have been evaluated.
    pub fn evaluate(&self, mechanism: &Mechanism, (q, v): (&[f64], &[f64]), motions: &mut Motions<f64>, part: Part) {
        if part.has_rates() {
            self.place(mechanism, q, motions);
        }
        self.propagate(mechanism, (q.first().copied().unwrap_or_default(), v), motions, (part, None));
    }

    /// Evaluates the motions with derivatives with respect to [`LANES`] coordinates of the group, from number `chunk` ·
    /// [`LANES`] on. `plain` are the motions without derivatives.
    pub fn differentiate(
        &self,
        mechanism: &Mechanism,
        (q, v): (&[f64], &[f64]),
        chunk: usize,
        plain: &Motions<f64>,
        motions: &mut Motions<Lanes>,
    ) {
        let (first, size) = (chunk * LANES, self.size());
        let lanes = first..first + LANES;
        for &body in &self.group.bodies {
            let support = &plain.body_supports[body];
            let columns = &plain.columns[support.first..][..size];
            motions.prescribed[body] = plain.prescribed[body];
            if support.meets(&lanes) {
                motions.bodies[body] = plain.bodies[body].lifted(columns, first);
                continue;
            }
            motions.bodies[body] = plain.bodies[body].constant();
            for &k in &support.coordinates {
                motions.columns[support.first + k] = columns[k].map(Dual::constant);
            }
        }
        for &joint in &self.joints {
            let (support, of) = (&plain.joint_supports[joint], &plain.joints[joint]);
            let row = &plain.rows[support.first..][..size];
            let mut coordinate = Dual::constant(of.coordinate);
            coordinate.grad.iter_mut().zip(&row[first..]).for_each(|(grad, entry)| *grad = *entry);
            let [rate, bias] = [of.rate, of.bias].map(Dual::constant);
            motions.joints[joint] = JointMotion { coordinate, rate, bias };
            for &k in &support.coordinates {
                motions.rows[support.first + k] = Dual::constant(row[k]);
            }
        }
        let time = q.first().map_or(Dual::constant(0.0), |time| match chunk {
            0 => Dual::variable(*time, 0),
            _ => Dual::constant(*time),
        });
        self.propagate(mechanism, (time, v), motions, (Part::All, Some(lanes)));
    }

    /// Evaluates the poses of all bodies and the coordinates of all joints.
    fn place(&self, mechanism: &Mechanism, q: &[f64], motions: &mut Motions<f64>) {
        for (placement, mode) in self.group.placements.iter().zip(&self.modes) {
            match placement {
                Placement::Free { body, first, axes } => {
                    let angle = if *axes == 3 { q[first + 2] } else { mechanism.bodies[*body].pose[2] };
                    motions.bodies[*body].place_at(&BodyMotion::at([q[*first], q[first + 1], angle], [0.0; 3]));
                }
                Placement::Prescribed { body } => {
                    let pose = self.prescribed(&mechanism.bodies[*body], q[0]);
                    motions.bodies[*body].place_at(&BodyMotion::at(pose.position, [0.0; 3]));
                    motions.prescribed[*body] = pose;
                }
                Placement::Joint { at, coordinate: source } => {
                    let coordinate = match source {
                        Source::Coordinate(index) => q[*index],
                        Source::Coupling(index) => {
                            let coupling = &mechanism.couplings[*index];
                            let ratios = coupled_joints(&coupling.on, at.joint);
                            ratios.fold(coupling.on.offset / coupling.on.factor(at.joint), |sum, (joint, ratio)| {
                                sum + ratio * motions.joints[joint].coordinate
                            })
                        }
                        Source::Angle => {
                            let angle = mechanism.bodies[at.body].pose[2] - motions.body(at.base).angle;
                            at.sign() * angle - mechanism.joints[at.joint].offset_rad
                        }
                    };
                    motions.joints[at.joint].coordinate = coordinate;
                    let base = *motions.body(at.base);
                    place(&mechanism.joints[at.joint], at, &base, coordinate, &mut motions.bodies[at.body]);
                }
                Placement::Dyad { outer, inner } => {
                    let Some(mode) = mode else { continue };
                    let bases = pair(|k| motions.body(outer[k].base));
                    // Only angles depend on the middles of their ranges; those of a slide are found with its pose.
                    let is_pin = mechanism.joints[*inner].kind.is_angle();
                    let middles =
                        if mode.has_angles || !is_pin { middles(mechanism, outer, mode, motions) } else { [0.0; 2] };
                    let (bodies, coordinates) = place_dyad(mechanism, (outer, *inner), bases, (mode, middles));
                    for (k, at) in outer.iter().enumerate() {
                        motions.bodies[at.body].place_at(&bodies[k]);
                        motions.joints[at.joint].coordinate = coordinates[k];
                    }
                    let is_needed = mode.has_angles || !mechanism.joints[*inner].kind.is_angle();
                    let coordinate = if is_needed { inner_coordinate(mechanism, *inner, motions) } else { 0.0 };
                    motions.joints[*inner].coordinate = coordinate;
                }
                Placement::Assur { tree, known, closing } => {
                    let Some(mode) = mode else { continue };
                    Assur { mechanism, tree, known, closing }.place(mode.sign, q, motions);
                }
            }
        }
    }

    /// Evaluates the angles of the bodies of dyads, and the coordinates and rates of their joints, unless they were
    /// evaluated together with the positions and rates of the bodies.
    pub fn evaluate_angles(&self, mechanism: &Mechanism, motions: &mut Motions<f64>) {
        for (placement, mode) in self.group.placements.iter().zip(&self.modes) {
            let (Placement::Dyad { outer, inner }, Some(mode)) = (placement, mode) else { continue };
            for (joint, moves) in [outer[0].joint, outer[1].joint, *inner].into_iter().zip(mode.moves_joints) {
                if !moves {
                    motions.joints[joint].rate = joint_rate(&mechanism.joints[joint], |body| *motions.body(body));
                }
            }
            if mode.has_angles {
                continue;
            }
            for (at, middle) in outer.iter().zip(middles(mechanism, outer, mode, motions)) {
                let joint = &mechanism.joints[at.joint];
                if joint.kind.is_angle() {
                    let (base, direction) = (motions.body(at.base).angle, motions.bodies[at.body].direction);
                    (motions.bodies[at.body].angle, motions.joints[at.joint].coordinate) =
                        outer_angle(joint, at, base, direction, middle);
                }
            }
            motions.joints[*inner].coordinate = inner_coordinate(mechanism, *inner, motions);
        }
    }

    /// Coordinate of a joint of a dyad that was not evaluated together with the positions; `dyad` is the index of its
    /// placement.
    pub fn joint_coordinate(&self, mechanism: &Mechanism, motions: &Motions<f64>, dyad: usize, joint: usize) -> f64 {
        let (Placement::Dyad { outer, inner }, Some(mode)) = (&self.group.placements[dyad], &self.modes[dyad]) else {
            return motions.joints[joint].coordinate;
        };
        let middles = middles(mechanism, outer, mode, motions);
        if let Some(k) = outer.iter().position(|at| at.joint == joint) {
            let (base, direction) = (motions.body(outer[k].base).angle, motions.bodies[outer[k].body].direction);
            return outer_angle(&mechanism.joints[joint], &outer[k], base, direction, middles[k]).1;
        }
        let joint = &mechanism.joints[*inner];
        let directions = joint.bodies.map(|body| motions.body(body).direction);
        let turn = atan2(cross(directions[0], directions[1]), dot(directions[0], directions[1]));
        let [first, second] = inner_bodies(joint, outer).map(|k| middles[k]);
        nearest_equivalent_angle(turn - joint.offset_rad, second - first - joint.offset_rad)
    }

    /// Revolute joints of dyads whose coordinates are not evaluated together with the positions; each is preceded by
    /// the index of its placement.
    pub fn joints_on_demand<'a>(&'a self, mechanism: &'a Mechanism) -> impl Iterator<Item = (usize, usize)> + 'a {
        let dyads = self.group.placements.iter().zip(&self.modes).enumerate();
        let joints = dyads.filter_map(|(index, of)| match of {
            (Placement::Dyad { outer, inner }, Some(AssemblyMode { has_angles: false, .. })) => {
                Some([outer[0].joint, outer[1].joint, *inner].map(|joint| (index, joint)))
            }
            _ => None,
        });
        joints.flatten().filter(|(_, joint)| mechanism.joints[*joint].kind.is_angle())
    }

    /// Evaluates a part of the motions of all bodies and joints, whose poses and coordinates are known; `first` is the first
    /// coordinate. Numbers with derivatives by the coordinates `lanes` are evaluated where they depend on these.
    fn propagate<T: Real>(
        &self,
        mechanism: &Mechanism,
        (first, v): (T, &[f64]),
        motions: &mut Motions<T>,
        (part, lanes): (Part, Option<Range<usize>>),
    ) {
        for (placement, mode) in self.group.placements.iter().zip(&self.modes) {
            if lanes.as_ref().is_some_and(|lanes| !motions.body_supports[body_of(placement)].meets(lanes)) {
                continue;
            }
            match placement {
                Placement::Free { body, first, axes } => {
                    let of_body = motions.body_supports[*body].first;
                    for axis in 0..*axes {
                        motions.bodies[*body].rate[axis] = T::constant(v[first + axis]);
                        motions.columns[of_body + first + axis][axis] = T::constant(1.0);
                    }
                }
                Placement::Prescribed { body } => {
                    let scene::Pose { rate, acceleration, jerk, .. } = motions.prescribed[*body];
                    let (of_body, motion) = (motions.body_supports[*body].first, &mut motions.bodies[*body]);
                    for axis in 0..3 {
                        let column = first.chain(rate[axis], acceleration[axis]);
                        motion.rate[axis] = column * v[0];
                        motion.bias[axis] = first.chain(acceleration[axis], jerk[axis]) * (v[0] * v[0]);
                        motions.columns[of_body][axis] = column;
                    }
                }
                Placement::Joint { at, coordinate: source } => {
                    let joint = &mechanism.joints[at.joint];
                    match (source, joint.kind) {
                        (Source::Coordinate(index), JointKind::Revolute) => {
                            move_with_pin(joint, (at, *index), v[*index], motions, part);
                        }
                        _ => move_with_joint(mechanism, (at, source), v, motions, part),
                    }
                }
                Placement::Dyad { outer, inner } => {
                    let [first, second, of_inner] = mode.map_or([true; 3], |mode| mode.moves_joints);
                    close_dyad(mechanism, (outer, *inner), [first, second], motions, part);
                    if of_inner {
                        move_inner_joint(mechanism, (outer, *inner), motions, part);
                    }
                }
                Placement::Assur { tree, known, closing } => {
                    Assur { mechanism, tree, known, closing }.close(v, motions, part);
                }
            }
        }
    }

    /// Transmission of every dyad and of every Assur group; `None` for a singular one.
    pub fn transmissions<'a>(
        &'a self,
        mechanism: &'a Mechanism,
        motions: &'a Motions<f64>,
    ) -> impl Iterator<Item = (usize, Transmission)> + 'a {
        self.group.placements.iter().enumerate().filter_map(|(index, placement)| match placement {
            Placement::Dyad { outer, inner } => Some((index, transmission(mechanism, (outer, *inner), motions))),
            Placement::Assur { tree, known, closing } => {
                Some((index, Assur { mechanism, tree, known, closing }.transmission(motions)))
            }
            _ => None,
        })
    }

    /// The Assur groups beyond dyads.
    pub fn assurs<'a>(&'a self, mechanism: &'a Mechanism) -> impl Iterator<Item = Assur<'a>> + 'a {
        self.group.placements.iter().filter_map(move |placement| match placement {
            Placement::Assur { tree, known, closing } => Some(Assur { mechanism, tree, known, closing }),
            _ => None,
        })
    }

    /// The lines between pivots whose turns are counted, each with the offset of the pivots and its rate.
    pub fn pivot_lines<'a>(
        &'a self,
        mechanism: &'a Mechanism,
        motions: &'a Motions<f64>,
    ) -> impl Iterator<Item = (&'a PivotLine, ([f64; 2], [f64; 2]))> + 'a {
        self.group.placements.iter().zip(&self.modes).filter_map(|of| match of {
            (Placement::Dyad { outer, .. }, Some(AssemblyMode { line: Some(line), .. })) => {
                Some((line, pivot_offset(mechanism, outer, motions)))
            }
            _ => None,
        })
    }
}

/// The constant parts of elements, and the indices of the others.
fn constant_parts(group: &Group, elements: &[Element]) -> (Constant, Vec<usize>) {
    let size = group.coordinates.len();
    let (mut constant, mut varying) = (Constant { load: vec![0.0; size], mass: vec![0.0; size * size] }, Vec::new());
    for (index, element) in elements.iter().enumerate() {
        let Element { row: Row { support, constant: Some(entries) }, stiffness: 0.0, damping: 0.0, .. } = element
        else {
            varying.push(index);
            continue;
        };
        for (i, by_i) in support.iter().zip(entries) {
            constant.load[*i] += by_i * element.preload;
            for (j, by_j) in support.iter().zip(entries) {
                constant.mass[i * size + j] += element.inertia * by_i * by_j;
            }
        }
    }
    (constant, varying)
}

/// Motions of bodies at rest in these poses.
pub(super) fn motions_at(mechanism: &Mechanism, poses: &[Pose]) -> Motions<f64> {
    let mut motions = Motions::<f64>::new(mechanism);
    for (motion, pose) in motions.bodies.iter_mut().zip(poses) {
        *motion = BodyMotion::at(*pose, [0.0; 3]);
    }
    motions
}

/// Coordinates and rates of a group in assembled poses.
pub(super) fn start_of(group: &Group, mechanism: &Mechanism, (poses, rates): (&[Pose], &[Pose])) -> Vec<(f64, f64)> {
    let motion = |body: Option<usize>| {
        body.map_or_else(BodyMotion::<f64>::ground, |body| BodyMotion::at(poses[body], rates[body]))
    };
    let start = |coordinate: &Coordinate| match coordinate {
        Coordinate::Joint(joint) => {
            let joint = &mechanism.joints[*joint];
            (joint_coordinate(joint, motion), joint_rate(joint, motion))
        }
        Coordinate::Body(body, axis) => (poses[*body][*axis], rates[*body][*axis]),
        Coordinate::Time => (0.0, 1.0),
    };
    group.coordinates.iter().map(start).collect()
}

/// Coordinate of the inner joint of a dyad.
fn inner_coordinate(mechanism: &Mechanism, inner: usize, motions: &Motions<f64>) -> f64 {
    joint_coordinate(&mechanism.joints[inner], |body| *motions.body(body))
}

fn bases_length(bases: [&BodyMotion<f64>; 2], motions: &Motions<f64>, outer: &[Attachment; 2]) -> f64 {
    let offset = |k: usize| sub(motions.bodies[outer[k].body].origin, bases[k].origin);
    let squared = |k: usize| dot(offset(k), offset(k));
    (squared(0) + squared(1)).sqrt().max(f64::MIN_POSITIVE)
}

/// Whether a spring, a servo, a coupling, a limit of a sum or a tendon depends on the coordinate of a joint. A spring of constant force does
/// not.
pub(super) fn has_force(mechanism: &Mechanism, joint: usize) -> bool {
    let is_servo = |actuator: &&Actuator| matches!(actuator.command, Command::Servo { .. });
    let springs = mechanism.springs.iter().filter(|spring| spring.stiffness != 0.0).filter_map(Spring::on);
    let servos = mechanism.actuators.iter().filter(is_servo).map(|actuator| &actuator.on);
    let limits = mechanism.sum_limits.iter().map(|limit| &limit.on);
    let mut all = springs.chain(servos).chain(mechanism.couplings.iter().map(|coupling| &coupling.on)).chain(limits);
    all.any(|on| on.factor(joint) != 0.0)
        || mechanism.tendons.iter().any(|tendon| tendon.spools().any(|(term, _)| *term == joint))
}

/// Whether a force acts on a joint, or another joint is coupled to it.
fn is_in_force(mechanism: &Mechanism, joint: usize) -> bool {
    let Joint { damping, armature, ref friction, limit, .. } = mechanism.joints[joint];
    let springs = mechanism.springs.iter().filter_map(Spring::on);
    let actuators = mechanism.actuators.iter().map(|actuator| &actuator.on);
    let rotors = mechanism.rotors.iter().map(|rotor| &rotor.on);
    let mut all = springs.chain(actuators).chain(rotors);
    has_force(mechanism, joint)
        || damping != 0.0
        || armature != 0.0
        || friction.is_some()
        || limit.is_some()
        || all.any(|on| on.factor(joint) != 0.0)
}

/// [`move_with_joint`] for a revolute joint whose angle is coordinate `index`, and its rate.
#[inline(always)]
fn move_with_pin<T: Real>(
    joint: &Joint,
    (at, index): (&Attachment, usize),
    rate: f64,
    motions: &mut Motions<T>,
    part: Part,
) {
    let base_of = motions.index(at.base);
    let Motions { bodies, joints, body_supports, columns, .. } = motions;
    let (own, sign) = (usize::from(at.is_second), at.sign());
    let arm = bodies[at.body].rotated(joint.points_m[own]);
    let by_joint = [arm[1] * sign, -(arm[0] * sign), T::constant(sign)];
    if at.base.is_none() {
        let body = &mut bodies[at.body];
        let [x, y, _] = by_joint;
        if part.has_rates() {
            joints[at.joint].rate = T::constant(rate);
            body.rate = [x * rate, y * rate, T::constant(sign * rate)];
        }
        if part.has_derivatives() {
            let squared = rate * rate;
            body.bias = [arm[0] * squared, arm[1] * squared, T::zero()];
            columns[body_supports[at.body].first + index] = by_joint;
        }
        return;
    }
    let from_base = sub(bodies[at.body].origin, bodies[base_of].origin);
    let across = perp(from_base);
    if part.has_rates() {
        let with_base = carried(bodies[base_of].rate, across);
        joints[at.joint].rate = T::constant(rate);
        bodies[at.body].rate = triple(|axis| with_base[axis] + by_joint[axis] * rate);
    }
    if part.has_derivatives() {
        let (base_squared, squared) = (bodies[base_of].rate[2].squared(), bodies[at.body].rate[2].squared());
        let [x, y, turn] = carried(bodies[base_of].bias, across);
        let to_joint = [from_base[0] + arm[0], from_base[1] + arm[1]];
        let centripetal = |axis: usize| arm[axis] * squared - to_joint[axis] * base_squared;
        bodies[at.body].bias = [x + centripetal(0), y + centripetal(1), turn];
        let [of_base, of_body] = [base_of, at.body].map(|body| body_supports[body].first);
        // The base does not depend on the coordinate of the joint.
        for &k in &body_supports[base_of].coordinates {
            columns[of_body + k] = carried(columns[of_base + k], across);
        }
        columns[of_body + index] = by_joint;
    }
}

/// Evaluates the motion of a placed body at a joint, and of the joint.
#[inline(always)]
fn move_with_joint<T: Real>(
    mechanism: &Mechanism,
    (at, source): (&Attachment, &Source),
    v: &[f64],
    motions: &mut Motions<T>,
    part: Part,
) {
    let joint = &mechanism.joints[at.joint];
    let base_of = motions.index(at.base);
    let (base, body) = (&motions.bodies[base_of], &motions.bodies[at.body]);
    let (across, by_joint) = (perp(sub(body.origin, base.origin)), column(joint, at, [base, body]));
    let moved = |base: [T; 3], rate: T| {
        let carried = carried(base, across);
        triple(|axis| carried[axis] + by_joint[axis] * rate)
    };
    if part.has_rates() {
        let rate = match source {
            Source::Coordinate(index) => T::constant(v[*index]),
            Source::Coupling(index) => coupled_joints(&mechanism.couplings[*index].on, at.joint)
                .fold(T::zero(), |sum, (other, ratio)| sum + motions.joints[other].rate * ratio),
            Source::Angle => base.rate[2] * -at.sign(),
        };
        let body_rate = moved(base.rate, rate);
        motions.joints[at.joint].rate = rate;
        motions.bodies[at.body].rate = body_rate;
    }
    if !part.has_derivatives() {
        return;
    }
    let Motions { bodies, joints, body_supports, joint_supports, columns, rows, .. } = motions;
    let (base, body) = (&bodies[base_of], &bodies[at.body]);
    let (of_base, of_body) = (body_supports[base_of].first, body_supports[at.body].first);
    let of_row = joint_supports[at.joint].first;
    let bias = match source {
        Source::Coordinate(index) => {
            // The base does not depend on the coordinate of the joint.
            for &k in &body_supports[base_of].coordinates {
                columns[of_body + k] = carried(columns[of_base + k], across);
            }
            columns[of_body + index] = by_joint;
            T::zero()
        }
        Source::Coupling(index) => {
            let others = || coupled_joints(&mechanism.couplings[*index].on, at.joint);
            for &k in &joint_supports[at.joint].coordinates {
                rows[of_row + k] =
                    others().fold(T::zero(), |sum, (other, ratio)| sum + rows[joint_supports[other].first + k] * ratio);
            }
            for &k in &body_supports[at.body].coordinates {
                columns[of_body + k] = moved(columns[of_base + k], rows[of_row + k]);
            }
            others().fold(T::zero(), |sum, (other, ratio)| sum + joints[other].bias * ratio)
        }
        Source::Angle => {
            let turn = -at.sign();
            for &k in &body_supports[at.body].coordinates {
                rows[of_row + k] = columns[of_base + k][2] * turn;
                columns[of_body + k] = moved(columns[of_base + k], rows[of_row + k]);
            }
            base.bias[2] * turn
        }
    };
    let carried = carried_bias(joint, at, [base, body], joints[at.joint].rate);
    joints[at.joint].bias = bias;
    bodies[at.body].bias = triple(|axis| carried[axis] + by_joint[axis] * bias);
}

/// Coordinates of a group on which the pose of each body, and the coordinate of each joint, depend.
fn dependent_coordinates(mechanism: &Mechanism, group: &Group) -> (Vec<Vec<usize>>, Vec<Vec<usize>>) {
    let mut of_bodies = vec![Vec::new(); mechanism.bodies.len()];
    let mut of_joints: Vec<Vec<usize>> = vec![Vec::new(); mechanism.joints.len()];
    for placement in &group.placements {
        let of_base = |base: Option<usize>| base.map_or_else(Vec::new, |base: usize| of_bodies[base].clone());
        match placement {
            Placement::Free { body, first, axes } => of_bodies[*body] = (*first..first + axes).collect(),
            Placement::Prescribed { body } => of_bodies[*body] = vec![0],
            Placement::Joint { at, coordinate: source } => {
                let base = of_base(at.base);
                of_joints[at.joint] = match source {
                    Source::Coordinate(index) => vec![*index],
                    Source::Coupling(index) => {
                        let others = coupled_joints(&mechanism.couplings[*index].on, at.joint);
                        Support::union(others.map(|(other, _)| &of_joints[other][..]))
                    }
                    Source::Angle => base.clone(),
                };
                of_bodies[at.body] = Support::union([&base[..], &of_joints[at.joint]]);
            }
            Placement::Dyad { outer, inner } => {
                let bases = outer.each_ref().map(|at| of_base(at.base));
                let union = Support::union(bases.iter().map(|base| &base[..]));
                outer.iter().for_each(|at| of_bodies[at.body] = union.clone());
                [outer[0].joint, outer[1].joint, *inner].into_iter().for_each(|joint| of_joints[joint] = union.clone());
            }
            Placement::Assur { tree, known, closing } => {
                let bases = bases_of(mechanism, placement).into_iter().map(of_base);
                let bases: Vec<Vec<usize>> = bases.chain([known.iter().copied().flatten().collect()]).collect();
                let union = Support::union(bases.iter().map(|base| &base[..]));
                tree.iter().for_each(|at| of_bodies[at.body] = union.clone());
                let joints = Assur { mechanism, tree, known, closing }.joints();
                joints.for_each(|joint| of_joints[joint] = union.clone());
            }
        }
    }
    (of_bodies, of_joints)
}

/// A body of a placement. All bodies of a loop depend on the same coordinates.
fn body_of(placement: &Placement) -> usize {
    match placement {
        Placement::Free { body, .. } | Placement::Prescribed { body } => *body,
        Placement::Joint { at, .. } => at.body,
        Placement::Dyad { outer, .. } => outer[0].body,
        Placement::Assur { tree, .. } => tree[0].body,
    }
}

/// Bodies from which a placement places others.
fn bases_of(mechanism: &Mechanism, placement: &Placement) -> Vec<Option<usize>> {
    match placement {
        Placement::Free { .. } | Placement::Prescribed { .. } => Vec::new(),
        Placement::Joint { at, .. } => vec![at.base],
        Placement::Dyad { outer, .. } => vec![outer[0].base, outer[1].base],
        Placement::Assur { tree, known, closing } => {
            let is_base = |body: &Option<usize>| body.is_none_or(|body| tree.iter().all(|at| at.body != body));
            let joints = Assur { mechanism, tree, known, closing }.joints();
            joints.flat_map(|joint| mechanism.joints[joint].bodies).filter(is_base).collect()
        }
    }
}

/// Joints from which the coordinate of a coupled joint follows, with their ratios: q = (offset − Σ cᵢ qᵢ)/c.
pub(super) fn coupled_joints(on: &JointCombination, joint: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    let own = on.factor(joint);
    let others = on.terms.iter().filter(move |(term, _)| *term != joint);
    others.map(move |(term, factor)| (*term, -factor / own))
}
