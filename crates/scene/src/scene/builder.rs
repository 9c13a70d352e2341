//! The mechanism of a hand.
//!
//! Bodies are the links of the fingers, a moving object, and a moving palm; a fixed object and planes are outlines of
//! the ground. The joints of a finger have the angles of the thesis as coordinates, q11, q12, q21 and q22; the joint
//! `loop` closes the loop. A left finger is the mirror image of a right one: its joints connect the same bodies in the
//! opposite order, so that its coordinates are the angles in the mirrored finger.

use super::hand::{Differential, Hand, HandContact, HandFinger, Motor, Object, ObjectMotion, Side};
use crate::gripper::{
    FingerContact, Lengths, Placement, Posture, Spring, SpringKind, close_loop, link_outline, straight_posture,
    tip_outline,
};
use crate::mechanism::{
    self, Actuator, Body, Command, ContactPair, ForcePoint, Joint, JointCombination, JointKind, Mechanism, Outline,
    OutlineId, OutlineShape, Pose, Powertrain, PrescribedMotion, Rotor,
};
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{cross, opening_angle, perp, scale, sub};
use crate::shape::max_radius;
use std::f64::consts::{FRAC_PI_2, PI};

/// Links of a finger in the order of its bodies.
const LINKS: [&str; 4] = ["l11", "l12", "l21", "l22"];
const L11: usize = 0;
const L12: usize = 1;
const L21: usize = 2;
const L22: usize = 3;
/// Joints of a finger, in the order of its mechanism. q11 and q21 are the ground joints. q12 and q22 are the passive
/// joints, relative to the preceding link. `loop` connects the ends of l12 and l22.
pub const FINGER_JOINTS: [&str; 5] = ["q11", "q12", "q21", "q22", "loop"];
const Q11: usize = 0;
const Q12: usize = 1;
const Q21: usize = 2;
const Q22: usize = 3;
const LOOP: usize = 4;

/// Posture of a finger that can neither close its loop at its start nor be straight.
const UPRIGHT: Posture = Posture { q11_rad: 0.0, q21_rad: FRAC_PI_2, q12_rad: 0.0, q22_rad: 0.0 };

/// Error for initial angles at which the loop of a finger does not close.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenLoop {
    #[error("the links do not close the loop at these initial angles; choose others")]
    Single,
    #[error("the links of the {} finger do not close their loop at these initial angles", .0.name())]
    OneOfTwo(Side),
}

impl Hand {
    /// Returns the mechanism of the hand, with poses and rates at the start in closed form.
    ///
    /// # Errors
    /// Returns an error if the initial angles of a finger do not close its loop.
    pub fn mechanism(&self) -> Result<Mechanism, OpenLoop> {
        let (mechanism, open_loop) = self.build();
        open_loop.map_or(Ok(mechanism), Err)
    }

    /// Returns the mechanism of the hand. A finger whose loop does not close at its start is drawn straight.
    pub fn drawn_mechanism(&self) -> Mechanism {
        self.build().0
    }

    fn build(&self) -> (Mechanism, Option<OpenLoop>) {
        let mut mechanism = Mechanism { gravity_m_s2: self.gravity_m_s2, ..Mechanism::default() };
        let mut open_loop = None;
        let object_moves = self.moving_object().is_some();
        let palm = LINKS.len() * self.fingers.len() + usize::from(object_moves);
        let palm = self.palm_motion.is_some().then_some(palm);
        for (side, finger) in self.fingers_by_side() {
            let name = |part: &str| match self.fingers.len() {
                1 => part.to_owned(),
                _ => format!("{}_{part}", side.name()),
            };
            let mount = Mount { base: palm, half_palm_m: 0.5 * self.palm_width_m, mirror: side.mirror() };
            if !add_finger(&mut mechanism, finger, &mount, &name) {
                let error = if self.fingers.len() == 1 { OpenLoop::Single } else { OpenLoop::OneOfTwo(side) };
                open_loop.get_or_insert(error);
            }
            if self.has_motor(finger) {
                let on = JointCombination::of_joint(FINGER_JOINTS.len() * side as usize + Q11);
                mechanism.actuators.push(actuator(name("motor"), &finger.motor, on));
            }
        }
        if let Some(differential) = &self.differential {
            add_differential(&mut mechanism, differential);
        }
        let object = self.object.as_ref().map(|object| add_object(&mut mechanism, object));
        if let Some(motion) = self.palm_motion.clone() {
            mechanism.bodies.push(Body {
                motion: Some(PrescribedMotion::Palm(motion)),
                is_reported: false,
                ..body("palm".to_owned(), [0.0; 2], [0.0; 3], [0.0; 3])
            });
        }
        let mut half_plane = |name: &str, body: Option<usize>, level_m: f64, side: f64| {
            let shape = OutlineShape::HalfPlane { point_m: [0.0, level_m], normal: [0.0, side] };
            add_outline(&mut mechanism, body, name, shape)
        };
        let palm_plane = self.palm.map(|plane| half_plane("palm", palm, plane.level_m, 1.0));
        let table_plane = self.table.map(|plane| half_plane("table", None, plane.level_m, -1.0));
        // For a finger on a fixed object, forces act at each surface's own nearest point, as in the thesis. Where fingers
        // can push an object away, they act at the point on the surface that is not the object's.
        let on_phalanx = if self.fingers.len() == 1 && !object_moves { ForcePoint::Each } else { ForcePoint::Face };
        for contact in self.contacts() {
            let (face, force_point) = match contact {
                HandContact::Finger(_, FingerContact::Limit) => continue,
                HandContact::Finger(side, phalanx) => {
                    let link = if phalanx == FingerContact::Proximal { L21 } else { L22 };
                    let body = Some(LINKS.len() * side as usize + link);
                    (Some(OutlineId { body, outline: 0 }), on_phalanx)
                }
                HandContact::Palm => (palm_plane, ForcePoint::Face),
                HandContact::Table => (table_plane, ForcePoint::Face),
            };
            let (Some((points, face)), Some(law)) = (object.zip(face), self.law(contact)) else { continue };
            let name = Some(contact.name_for(self.fingers.len()));
            let pair = ContactPair { name, points, face, law, rolling: None, force_point, is_reported_on_face: true };
            mechanism.contacts.push(pair);
        }
        (mechanism, open_loop)
    }

    /// Whether the mechanism has a motor on the driven link of a finger. A differential replaces the motors of both
    /// fingers.
    pub fn has_motor(&self, finger: &HandFinger) -> bool {
        self.differential.is_none() || finger.motor != Motor::NONE
    }

    /// Returns the mechanism with another outline of the grasped object, and its mass, moment of inertia and centre of mass.
    /// It has the order, the names and the reported bodies of a mechanism in a scene file.
    ///
    /// # Errors
    /// Returns an error if the initial angles of a finger do not close its loop.
    pub(crate) fn mechanism_with_object(
        &self,
        outline: &OutlineShape,
        (mass_kg, inertia_kg_m2, com_m): (f64, f64, [f64; 2]),
    ) -> Result<Mechanism, OpenLoop> {
        let mut mechanism = self.mechanism()?;
        let Some(object) = &self.object else { return Ok(mechanism) };
        if let Some(index) = mechanism.bodies.iter().position(|body| body.name == Object::NAME) {
            let body = &mut mechanism.bodies[index];
            (body.mass_kg, body.inertia_kg_m2, body.com_m) = (mass_kg, inertia_kg_m2, com_m);
            body.outlines[0].shape = outline.clone();
        } else {
            // The ground does not turn.
            let at = mechanism.ground_outlines.iter().position(|outline| outline.name == Object::NAME).unwrap_or(0);
            mechanism.ground_outlines[at].shape = outline.moved(object.centre_m, object.angle_rad);
        }
        as_in_file(&mut mechanism);
        Ok(mechanism)
    }

    /// Returns the mechanism in the form of a scene file.
    ///
    /// # Errors
    /// Returns an error if the initial angles of a finger do not close its loop.
    pub(crate) fn mechanism_of_file(&self) -> Result<Mechanism, OpenLoop> {
        let mut mechanism = self.mechanism()?;
        as_in_file(&mut mechanism);
        Ok(mechanism)
    }
}

/// Gives a mechanism the order, the names, the contacts and the reported bodies of one in a scene file.
fn as_in_file(mechanism: &mut Mechanism) {
    let pairs = std::mem::take(&mut mechanism.contacts);
    for pair in pairs {
        let directed = mechanism.directions([pair.points, pair.face]).into_iter().map(|[points, face]| ContactPair {
            name: None,
            points,
            face,
            is_reported_on_face: false,
            ..pair.clone()
        });
        mechanism.contacts.extend(directed);
    }
    for body in &mut mechanism.bodies {
        (body.is_reported, body.drawn_m) = (true, Vec::new());
        if body.motion.is_some() {
            // They have no effect, but a scene file gives all bodies a mass and a moment of inertia.
            (body.mass_kg, body.inertia_kg_m2) = (1.0, 1.0);
        }
    }
    mechanism.joints.iter_mut().for_each(|joint| joint.limit_name = None);
    // Rates of bodies with joints follow from those of the joints.
    let jointed: Vec<usize> = mechanism.joints.iter().flat_map(|joint| joint.bodies).flatten().collect();
    jointed.into_iter().for_each(|body| mechanism.bodies[body].rate = [0.0; 3]);
    sort_by_name(mechanism);
}

/// Sorts bodies, joints, springs and actuators by their names, as in a scene file.
fn sort_by_name(mechanism: &mut Mechanism) {
    fn sort<T>(list: &mut Vec<T>, name: impl Fn(&T) -> &str) -> Vec<usize> {
        let mut order: Vec<usize> = (0..list.len()).collect();
        order.sort_by(|a, b| name(&list[*a]).cmp(name(&list[*b])));
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, old)| places[*old] = place);
        let mut sorted: Vec<(usize, T)> = std::mem::take(list).into_iter().enumerate().collect();
        sorted.sort_by_key(|(old, _)| places[*old]);
        *list = sorted.into_iter().map(|(_, item)| item).collect();
        places
    }
    let bodies = sort(&mut mechanism.bodies, |body| &body.name);
    let joints = sort(&mut mechanism.joints, |joint| &joint.name);
    sort(&mut mechanism.springs, |spring| &spring.name);
    sort(&mut mechanism.actuators, |actuator| &actuator.name);
    sort(&mut mechanism.rotors, |rotor| &rotor.name);
    let outlines = sort(&mut mechanism.ground_outlines, |outline| &outline.name);
    for body in mechanism.joints.iter_mut().flat_map(|joint| &mut joint.bodies).flatten() {
        *body = bodies[*body];
    }
    for contact in &mut mechanism.contacts {
        for id in [&mut contact.points, &mut contact.face] {
            match &mut id.body {
                Some(body) => *body = bodies[*body],
                None => id.outline = outlines[id.outline],
            }
        }
    }
    let springs = mechanism.springs.iter_mut().filter_map(|spring| match &mut spring.kind {
        mechanism::SpringKind::Torsional { on, .. } => Some(on),
        mechanism::SpringKind::Linear { .. } => None,
    });
    let actuators = mechanism.actuators.iter_mut().map(|actuator| &mut actuator.on);
    let combinations = springs.chain(actuators).chain(mechanism.rotors.iter_mut().map(|rotor| &mut rotor.on));
    combinations.flat_map(|on| &mut on.terms).for_each(|(joint, _)| *joint = joints[*joint]);
}

/// Mounting of a finger: the body that carries it (`None`: the ground), its distance from the middle of the palm, and
/// −1 for a finger mirrored about the y axis.
struct Mount {
    base: Option<usize>,
    half_palm_m: f64,
    mirror: f64,
}

impl Mount {
    /// Position of the ground joint.
    fn ground_m(&self) -> [f64; 2] {
        [self.mirror * self.half_palm_m, 0.0]
    }
}

/// Adds links, joints, spring and limit of a finger; returns whether its loop closes.
fn add_finger(mechanism: &mut Mechanism, driven: &HandFinger, mount: &Mount, name: &dyn Fn(&str) -> String) -> bool {
    let HandFinger { linkage: finger, initial, .. } = driven;
    let (first_body, first_joint) = (mechanism.bodies.len(), mechanism.joints.len());
    let closed = close_loop(&finger.lengths, finger.assembly, initial.q11_rad, initial.q21_rad);
    let is_closed = closed.is_ok();
    let posture = closed.or_else(|_| straight_posture(&finger.lengths, FRAC_PI_2)).unwrap_or(UPRIGHT);
    mechanism.bodies.extend(links(driven, mount, &posture, name));
    mechanism.joints.extend(joints(driven, mount, first_body, name));
    let spring = driven.spring.map(|spring| finger_spring(spring, &finger.lengths, first_joint, name("spring")));
    let has_spring = spring.as_ref().is_none_or(Option::is_some);
    mechanism.springs.extend(spring.flatten());
    is_closed && has_spring
}

/// Links of a finger in a posture, at its initial rates.
fn links(driven: &HandFinger, mount: &Mount, posture: &Posture, name: &dyn Fn(&str) -> String) -> [Body; 4] {
    let HandFinger { linkage: finger, initial, .. } = driven;
    let (lengths, mirror, ground_m) = (&finger.lengths, mount.mirror, mount.ground_m());
    let angles = link_angles(posture, lengths.phi22_rad);
    let rates = link_rates(lengths, &angles, [initial.qd11_rad_s, initial.qd21_rad_s]);
    let end = |length: f64, link: usize| {
        [ground_m[0] + mirror * (length * cos(angles[link])), ground_m[1] + length * sin(angles[link])]
    };
    let origins = [ground_m, end(lengths.l11_m, L11), ground_m, end(lengths.l21_m, L21)];
    let masses = [finger.bodies.l11, finger.bodies.l12, finger.bodies.l21, finger.bodies.l22];
    let (surfaces, drawn_m) = (link_surfaces(lengths, mirror), drawn_links(lengths, mirror));
    std::array::from_fn(|link| {
        let [x, y] = origins[link];
        // The origins of l12 and l22 move with l11 and l21.
        let [vx, vy] = scale(perp(sub(origins[link], ground_m)), mirror * rates[link - link % 2]);
        let com_m = [masses[link].com_m[0], mirror * masses[link].com_m[1]];
        let angle = if mirror > 0.0 { angles[link] } else { PI - angles[link] };
        let surface = surfaces[link].clone().map(|shape| Outline { name: "surface".to_owned(), shape });
        Body {
            mass_kg: masses[link].mass_kg,
            inertia_kg_m2: masses[link].inertia_kg_m2,
            is_reported: false,
            drawn_m: drawn_m[link].clone(),
            outlines: surface.into_iter().collect(),
            ..body(name(LINKS[link]), com_m, [x, y, angle], [vx, vy, mirror * rates[link]])
        }
    })
}

/// Surfaces that the object can touch, of both phalanges.
fn link_surfaces(lengths: &Lengths, mirror: f64) -> [Option<OutlineShape>; 4] {
    let capsule = |to_m| Some(OutlineShape::Capsule { from_m: [0.0; 2], to_m, radius_m: lengths.half_width_m });
    let (phi22, t22_m) = (lengths.phi22_rad, lengths.t22_m);
    [None, None, capsule([lengths.l21_m, 0.0]), capsule([t22_m * cos(phi22), t22_m * sin(mirror * phi22)])]
}

/// Polygons of the links in drawings.
fn drawn_links(lengths: &Lengths, mirror: f64) -> [Vec<Vec<[f64; 2]>>; 4] {
    let bar = |length_m| link_outline(length_m, lengths.half_width_m).to_vec();
    // A degenerate triangle has no outline; its mass is given in the scene.
    let distal = tip_outline(lengths).map_or_else(|_| bar(lengths.l22_m), |corners| corners.to_vec());
    [bar(lengths.l11_m), bar(lengths.l12_m), bar(lengths.l21_m), distal].map(|corners| {
        vec![match mirror > 0.0 {
            true => corners,
            false => corners.iter().rev().map(|[x, y]| [*x, -y]).collect(),
        }]
    })
}

/// Joints of a finger whose links begin at `first_body`, with its joint limit.
fn joints(driven: &HandFinger, mount: &Mount, first_body: usize, name: &dyn Fn(&str) -> String) -> [Joint; 5] {
    let HandFinger { linkage: finger, initial, motor, .. } = driven;
    let (lengths, ground_m) = (&finger.lengths, mount.ground_m());
    let link = |link: usize| Some(first_body + link);
    let pins = [
        ([mount.base, link(L11)], [ground_m, [0.0; 2]]),
        ([link(L11), link(L12)], [[lengths.l11_m, 0.0], [0.0; 2]]),
        ([mount.base, link(L21)], [ground_m, [0.0; 2]]),
        ([link(L21), link(L22)], [[lengths.l21_m, 0.0], [0.0; 2]]),
        ([link(L12), link(L22)], [[lengths.l12_m, 0.0], [lengths.l22_m, 0.0]]),
    ];
    std::array::from_fn(|index| {
        let (mut bodies, mut points_m) = pins[index];
        // The mirror image of an angle q from the base is π − q.
        let mut offset_rad = 0.0;
        if mount.mirror < 0.0 {
            bodies.reverse();
            points_m.reverse();
            offset_rad = if matches!(index, Q11 | Q21) { -PI } else { 0.0 };
        }
        let (start, start_rate) = match index {
            Q11 => (Some(initial.q11_rad), initial.qd11_rad_s),
            Q21 => (Some(initial.q21_rad), initial.qd21_rad_s),
            _ => (None, 0.0),
        };
        let limit = driven.limit.filter(|_| index == Q22);
        Joint {
            offset_rad,
            start,
            start_rate,
            armature: if index == Q11 { motor.inertia_kg_m2 } else { 0.0 },
            lower: limit.map(|_| -lengths.phi22_rad),
            limit,
            limit_name: limit.map(|_| name(FingerContact::Limit.name())),
            ..Joint::new(name(FINGER_JOINTS[index]), JointKind::Revolute, bodies, points_m)
        }
    })
}

/// Returns a spring between the two links of its placement, with a coordinate that is zero in the straight posture and
/// grows as the finger closes; `None` if the straight posture does not exist.
fn finger_spring(spring: Spring, lengths: &Lengths, first_joint: usize, name: String) -> Option<mechanism::Spring> {
    let (terms, on, against): (&[(usize, f64)], usize, usize) = match spring.placement {
        Placement::GroundLinks => (&[(Q21, 1.0), (Q11, -1.0)], L21, L11),
        Placement::DrivenCoupler => (&[(Q12, 1.0)], L12, L11),
        Placement::Phalanges => (&[(Q22, 1.0)], L22, L21),
        Placement::CouplerDistal => (&[(LOOP, -1.0)], L12, L22),
    };
    let angles = link_angles(&straight_posture(lengths, FRAC_PI_2).ok()?, lengths.phi22_rad);
    // Rates with q11 at constant q21.
    let rates = link_rates(lengths, &angles, [1.0, 0.0]);
    let closing = (rates[on] - rates[against]).signum();
    let (torque_n_m, stiffness) = match spring.kind {
        SpringKind::Constant { torque_n_m } => (torque_n_m, 0.0),
        SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
            (stiffness_n_m_per_rad * preload_rad, stiffness_n_m_per_rad)
        }
    };
    let on = JointCombination {
        terms: terms.iter().map(|(joint, factor)| (first_joint + joint, closing * factor)).collect(),
        offset: closing * (angles[on] - angles[against]),
    };
    let kind = mechanism::SpringKind::Torsional { on, preload: -torque_n_m };
    Some(mechanism::Spring { name, kind, stiffness, damping: 0.0, rest: 0.0 })
}

/// Adds the input of a differential, which turns by the mean of q11 of both fingers, and its seesaw, which turns by half
/// of their difference.
fn add_differential(mechanism: &mut Mechanism, differential: &Differential) {
    let [right, left] = [Q11, FINGER_JOINTS.len() + Q11];
    let half = |sign: f64| JointCombination { terms: vec![(right, 0.5), (left, sign * 0.5)], offset: 0.0 };
    let Differential { motor, seesaw_inertia_kg_m2 } = differential;
    mechanism.actuators.push(actuator("motor".to_owned(), motor, half(1.0)));
    let rotors = [("input", motor.inertia_kg_m2, 1.0), ("seesaw", *seesaw_inertia_kg_m2, -1.0)];
    let rotors = rotors.into_iter().filter(|(_, inertia, _)| *inertia > 0.0);
    mechanism.rotors.extend(rotors.map(|(name, inertia, sign)| Rotor {
        name: name.to_owned(),
        on: half(sign),
        inertia,
    }));
}

fn actuator(name: String, motor: &Motor, on: JointCombination) -> Actuator {
    Actuator {
        name,
        on,
        command: Command::Effort(motor.actuation.clone()),
        limit: None,
        no_load_speed: motor.no_load_speed_rad_s,
        brake: motor.brake,
        powertrain: Powertrain::default(),
    }
}

/// Adds the object, and returns its outline.
fn add_object(mechanism: &mut Mechanism, object: &Object) -> OutlineId {
    let moving = match object.motion {
        ObjectMotion::Fixed => None,
        ObjectMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s: [vx, vy], spin_rad_s } => {
            let [x, y] = object.centre_m;
            let pose = [x, y, object.angle_rad];
            let rates = [vx, vy, spin_rad_s];
            Some(Body { mass_kg, inertia_kg_m2, ..body(Object::NAME.to_owned(), [0.0; 2], pose, rates) })
        }
    };
    add_disc(mechanism, Object::NAME, max_radius(&object.shape), object.centre_m, moving)
}

/// Adds a disc: the body of a moving one, otherwise an outline of the ground. Returns its outline.
pub(super) fn add_disc(
    mechanism: &mut Mechanism,
    name: &str,
    radius_m: f64,
    centre_m: [f64; 2],
    moving: Option<Body>,
) -> OutlineId {
    let shape = |center_m| OutlineShape::Disc { center_m, radius_m };
    let Some(body) = moving else { return add_outline(mechanism, None, name, shape(centre_m)) };
    mechanism.bodies.push(body);
    add_outline(mechanism, Some(mechanism.bodies.len() - 1), "surface", shape([0.0; 2]))
}

/// A body without mass and outlines.
pub(super) fn body(name: String, com_m: [f64; 2], pose: Pose, rate: Pose) -> Body {
    Body { com_m, pose, rate, ..Body::new(name, 0.0, 0.0) }
}

/// Adds an outline to a body, or to the ground for `None`.
pub(super) fn add_outline(
    mechanism: &mut Mechanism,
    body: Option<usize>,
    name: &str,
    shape: OutlineShape,
) -> OutlineId {
    let outlines = match body {
        Some(body) => &mut mechanism.bodies[body].outlines,
        None => &mut mechanism.ground_outlines,
    };
    outlines.push(Outline { name: name.to_owned(), shape });
    OutlineId { body, outline: outlines.len() - 1 }
}

/// Orientations of the four links. The angle of l22 is measured from the straight line, as q22 is in both models.
fn link_angles(posture: &Posture, phi22: f64) -> [f64; 4] {
    let direction = |angle: f64| [cos(angle), sin(angle)];
    let bend = opening_angle(direction(posture.q21_rad), direction(posture.q21_rad + posture.q22_rad + phi22));
    [posture.q11_rad, posture.q11_rad + posture.q12_rad, posture.q21_rad, posture.q21_rad + bend - phi22]
}

/// Angular rates of the four links from those of the base links; the pin q13 has one velocity.
fn link_rates(lengths: &Lengths, angles: &[f64; 4], [w1, w2]: [f64; 2]) -> [f64; 4] {
    // Velocity of the end of a link that rotates at rate 1.
    let end_velocity = |length: f64, link: usize| scale(perp([cos(angles[link]), sin(angles[link])]), length);
    let (u1, u2) = (end_velocity(lengths.l11_m, L11), end_velocity(lengths.l21_m, L21));
    let (u3, u4) = (end_velocity(lengths.l12_m, L12), end_velocity(lengths.l22_m, L22));
    // w3 u3 − w4 u4 = w2 u2 − w1 u1
    let right = sub(scale(u2, w2), scale(u1, w1));
    let determinant = cross(u3, u4);
    [w1, cross(right, u4) / determinant, w2, cross(right, u3) / determinant]
}
