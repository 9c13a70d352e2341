//! The plan of a mechanism.

use super::cable::PlannedCableFriction;
use super::coordinate::{BodyPose, Circle, Coordinate, Measure, Twist};
use super::plan::{
    BrakeKind, Capsule, ContactPointConvention, Plan, PlannedActuator, PlannedBody, PlannedBrake, PlannedContact,
    PlannedDrive, PlannedGear, PlannedJoint, PlannedMotor, PlannedRotor, PlannedServo, PlannedSpring, PlannedStop,
    PlannedSurface, PlannedTendon, ServoLaw, Shape, SurfaceId,
};
use super::powertrain::PlannedPowertrain;
use crate::drive::Profile;
use crate::gripper::{self, Body};
use crate::mechanism::{
    Actuator, Command, DistanceFeedback, ForcePoint, Joint, JointCombination, Mechanism, OutlinePoint, OutlineShape,
    PathElement, PointContact, PointId, Spring, SpringKind, Start, Tendon, assemble,
};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{add, perp, scale, sub};
use crate::scene::Scene;
use crate::shape;

/// Builds the plan of a scene.
///
/// # Errors
/// Returns an error for a start that cannot be assembled, and for a mechanism that the engine model does not support.
pub fn build_plan(scene: &Scene) -> Result<Plan, String> {
    let mechanism = scene.mechanism().map_err(|error| error.to_string())?;
    let start = assemble(&mechanism).map_err(|error| error.to_string())?;
    build_mechanism_plan(&mechanism, &start)
}

/// Builds the plan of a mechanism from its assembled start.
///
/// Bodies and joints have the same indices as in the mechanism; they are followed by bodies that represent inertias of
/// joints. Contact channels are those of [`Mechanism::point_contacts`], then of [`Mechanism::limits`].
///
/// # Errors
/// Returns an error that names a component that the engine does not support: one that acts on a combination of joints
/// with more than two bodies, or with sliders.
pub fn build_mechanism_plan(mechanism: &Mechanism, start: &Start) -> Result<Plan, String> {
    let states = start.poses.iter().zip(&start.rates);
    let bodies = mechanism.bodies.iter().zip(states).map(|(body, (pose, rate))| {
        // In the plan, a drive moves a body without mass, and a body without inertia does not rotate.
        let moves_by_forces = body.motion.is_none();
        let inertia_kg_m2 = if moves_by_forces && body.inertia_kg_m2.is_finite() { body.inertia_kg_m2 } else { 0.0 };
        let (mass_kg, com_m) = if moves_by_forces { (body.mass_kg, body.com_m) } else { (0.0, [0.0; 2]) };
        PlannedBody {
            body: Body { mass_kg, com_m, inertia_kg_m2 },
            origin_m: [pose[0], pose[1]],
            angle_rad: pose[2],
            velocity_m_s: [rate[0], rate[1]],
            rate_rad_s: rate[2],
            gyration_m: 0.0,
            surfaces: Vec::new(),
        }
    });
    let drives = mechanism.bodies.iter().enumerate().filter_map(|(body, of)| {
        let motion = of.motion.clone()?;
        Some(PlannedDrive { body, motion })
    });
    let joints = mechanism.joints.iter().map(|joint| {
        let (mut bodies, mut anchors_m, mut offset_rad) = (joint.bodies, joint.points_m, joint.offset_rad);
        let [first, second] = bodies.map(|body| (!mechanism.is_base(body), body));
        // rapier's solver depends on the order, which is the same for both fingers of a gripper.
        let is_reversed = joint.kind.is_angle() && first > second;
        if is_reversed {
            bodies.reverse();
            anchors_m.reverse();
            offset_rad = -offset_rad;
        }
        PlannedJoint { kind: joint.kind, bodies, anchors_m, offset_rad, is_reversed }
    });
    let mut plan = Plan {
        gravity_m_s2: mechanism.gravity_m_s2,
        bodies: bodies.collect(),
        joints: joints.collect(),
        drives: drives.collect(),
        reported_circles: mechanism.reported_elements().collect(),
        reported_bodies: mechanism.reported_bodies().collect(),
        ground_carries: ground_carries(mechanism),
        ..Plan::default()
    };
    for (body, planned) in plan.bodies.iter_mut().enumerate() {
        planned.gyration_m = gyration_m(mechanism, body, &planned.body);
    }
    let coordinates: Vec<Coordinate> = plan.joints.iter().map(|joint| plan.joint_coordinate(joint)).collect();
    add_couplings(&mut plan, mechanism, &coordinates);
    add_springs_and_dampers(&mut plan, mechanism, &coordinates);
    for actuator in &mechanism.actuators {
        add_actuator(&mut plan, mechanism, actuator, combined(&actuator.on, &coordinates));
    }
    let points = mechanism.point_contacts();
    for (channel, contact) in points.iter().enumerate() {
        add_contact(&mut plan, mechanism, contact, channel);
    }
    for limit in mechanism.limits() {
        let beyond = combined(&mechanism.limited(&limit), &coordinates).less(limit.value);
        plan.stops.push(PlannedStop { gap: if limit.side > 0.0 { beyond.negated() } else { beyond }, law: limit.law });
        plan.stop_channels.push(points.len() + plan.stop_channels.len());
    }
    mechanism.tendons.iter().for_each(|tendon| add_tendon(&mut plan, tendon, &coordinates));
    Ok(plan)
}

/// Whether joints, springs, tendons or bodies that do not rotate act on the ground.
fn ground_carries(mechanism: &Mechanism) -> bool {
    let linear = |spring: &Spring| match &spring.kind {
        SpringKind::Linear { bodies, .. } => bodies.contains(&None),
        SpringKind::Torsional { .. } => false,
    };
    mechanism.has_joint(None)
        || mechanism.springs.iter().any(linear)
        || mechanism.tendons.iter().flat_map(|tendon| &tendon.path).any(|element| element.body.is_none())
        || mechanism.bodies.iter().any(|body| body.moves_by_forces() == [true, true, false])
}

/// Distance of a centre of mass from a joint, in radii of gyration, below which the rotation about the joint counts.
const AT_JOINT: f64 = 0.1;

/// Returns the arm at which step sizes take the angular acceleration of a body into account: its radius of gyration, or 0 if
/// the rotation moves no surface, or accelerates the centre of mass as well.
fn gyration_m(mechanism: &Mechanism, index: usize, body: &Body) -> f64 {
    if body.inertia_kg_m2 == 0.0 {
        return 0.0;
    }
    let gyration_m = (body.inertia_kg_m2 / body.mass_kg).sqrt();
    let ends = mechanism.joints.iter().flat_map(|joint| joint.bodies.into_iter().zip(joint.points_m));
    let mut points = ends.filter(|(of, _)| *of == Some(index)).map(|(_, point)| point).peekable();
    let counts = match points.peek() {
        Some(_) => points.any(|point| {
            let [x, y] = sub(point, body.com_m);
            hypot(x, y) < AT_JOINT * gyration_m
        }),
        None => mechanism.bodies[index].outlines.iter().any(|outline| match outline.shape {
            OutlineShape::Disc { center_m, .. } => center_m != body.com_m,
            _ => true,
        }),
    };
    if counts { gyration_m } else { 0.0 }
}

/// Returns a combination of joint coordinates: that of one joint, an angle of up to two bodies, or their sum.
fn combined(on: &JointCombination, coordinates: &[Coordinate]) -> Coordinate {
    if let [(joint, 1.0)] = on.terms[..] {
        return coordinates[joint].clone().less(on.offset);
    }
    angle_of_bodies(on, coordinates).unwrap_or_else(|| {
        let terms = on.terms.iter().map(|(joint, factor)| (coordinates[*joint].clone(), *factor));
        Coordinate::sum(terms.collect()).less(on.offset)
    })
}

/// Returns a combination of joint angles that is an angle of one or two bodies.
fn angle_of_bodies(on: &JointCombination, coordinates: &[Coordinate]) -> Option<Coordinate> {
    let (mut ratios, mut offset): (Vec<(usize, f64)>, f64) = (Vec::new(), on.offset);
    for (joint, factor) in &on.terms {
        let Coordinate { measure: Measure::Angle { on, against }, offset: of_joint } = &coordinates[*joint] else {
            return None;
        };
        offset += factor * of_joint;
        for &(body, ratio) in std::iter::once(on).chain(against) {
            match ratios.iter_mut().find(|(other, _)| *other == body) {
                Some((_, sum)) => *sum += factor * ratio,
                None => ratios.push((body, factor * ratio)),
            }
        }
    }
    ratios.retain(|(_, ratio)| *ratio != 0.0);
    let (on, against) = match ratios[..] {
        [on] => (on, None),
        [on, against] => (on, Some(against)),
        _ => return None,
    };
    Some(Coordinate { measure: Measure::Angle { on, against }, offset })
}

/// Adds a gear for each coupling, and a wheel for each inertia of a joint or combination of joints, which turns with its
/// coordinate, and with a moving palm.
fn add_couplings(plan: &mut Plan, mechanism: &Mechanism, coordinates: &[Coordinate]) {
    for coupling in &mechanism.couplings {
        let terms = coupling.on.terms.iter().map(|(joint, factor)| (coordinates[*joint].clone(), [*factor, 0.0]));
        plan.gears.push(PlannedGear { terms: terms.collect() });
    }
    let poses: Vec<BodyPose> = plan.bodies.iter().map(PlannedBody::pose).collect();
    let velocity = |(body, pose): (&PlannedBody, &BodyPose)| {
        let arm = perp(sub(pose.com, body.origin_m));
        let [x, y] = add(body.velocity_m_s, scale(arm, body.rate_rad_s));
        [x, y, body.rate_rad_s]
    };
    let velocities: Vec<Twist> = plan.bodies.iter().zip(&poses).map(velocity).collect();
    let palm = plan.palm().map(|(body, _)| body);
    let mut rotors = Vec::new();
    let mut add_wheel = |terms: &[(usize, f64)], inertia: f64| {
        let wheel = plan.bodies.len();
        let rate = |(joint, factor): &(usize, f64)| factor * coordinates[*joint].row(&poses).rate(&velocities);
        let rate_rad_s = terms.iter().map(rate).sum();
        plan.bodies.push(PlannedBody { rate_rad_s, ..PlannedBody::at_origin(inertia) });
        let with_palm = palm.map(|palm| (Coordinate::angle_of(palm), [-1.0, 0.0]));
        let joints = terms.iter().map(|(joint, factor)| (coordinates[*joint].clone(), [-factor, 0.0]));
        let terms = [(Coordinate::angle_of(wheel), [1.0, 0.0])].into_iter().chain(joints).chain(with_palm);
        plan.gears.push(PlannedGear { terms: terms.collect() });
        plan.rotors.push(PlannedRotor { body: wheel, inertia_kg_m2: inertia });
    };
    for (index, joint) in mechanism.joints.iter().enumerate().filter(|(_, joint)| joint.armature > 0.0) {
        match own_rotor(joint, palm) {
            Some(body) => rotors.push((body, joint.armature)),
            None => add_wheel(&[(index, 1.0)], joint.armature),
        }
    }
    mechanism.reflected_inertias().for_each(|(on, inertia)| add_wheel(&on.terms, inertia));
    for (body, inertia_kg_m2) in rotors {
        plan.bodies[body].body.inertia_kg_m2 += inertia_kg_m2;
        plan.rotors.push(PlannedRotor { body, inertia_kg_m2 });
    }
}

/// Body of a revolute joint on the ground, or on the palm if it moves: the rotor turns with it.
fn own_rotor(joint: &Joint, palm: Option<usize>) -> Option<usize> {
    match joint.bodies {
        _ if !joint.kind.is_angle() => None,
        [base, Some(body)] | [Some(body), base] if base == palm => Some(body),
        _ => None,
    }
}

fn add_springs_and_dampers(plan: &mut Plan, mechanism: &Mechanism, coordinates: &[Coordinate]) {
    for (joint, coordinate) in mechanism.joints.iter().zip(coordinates) {
        add_damper(plan, coordinate.clone(), joint.damping);
        plan.brakes.extend(joint.friction.map(|law| PlannedBrake {
            shaft: coordinate.clone(),
            kind: BrakeKind::Friction(law),
            actuator: None,
        }));
    }
    for spring in &mechanism.springs {
        let extension = match &spring.kind {
            SpringKind::Torsional { on, preload } => {
                let coordinate = combined(on, coordinates);
                if *preload != 0.0 {
                    let kind = gripper::SpringKind::Constant { torque_n_m: -preload };
                    plan.springs.push(PlannedSpring { extension: coordinate.clone(), kind });
                }
                coordinate.less(spring.rest)
            }
            SpringKind::Linear { bodies, points_m } => {
                let circle = |k: usize| Circle {
                    center: plan.body_point(bodies[k], points_m[k]),
                    signed_radius_m: 0.0,
                    is_on: true,
                };
                Coordinate { measure: Measure::Cable { circles: vec![circle(0), circle(1)] }, offset: spring.rest }
            }
        };
        if spring.stiffness != 0.0 {
            let kind = gripper::SpringKind::Torsional { stiffness_n_m_per_rad: spring.stiffness, preload_rad: 0.0 };
            plan.springs.push(PlannedSpring { extension: extension.clone(), kind });
        }
        add_damper(plan, extension, spring.damping);
    }
}

fn add_damper(plan: &mut Plan, coordinate: Coordinate, damping: f64) {
    if damping > 0.0 {
        let law = ServoLaw { kp: 0.0, kd: damping, limit: f64::INFINITY, slope: 0.0, target_rate: 0.0 };
        let target = Profile::Constant { value: 0.0 };
        plan.servos.push(PlannedServo { coordinate, target, law, is_motor: false });
    }
}

fn add_actuator(plan: &mut Plan, mechanism: &Mechanism, actuator: &Actuator, coordinate: Coordinate) {
    let limit = actuator.limit.unwrap_or(f64::INFINITY);
    let actuator_index = plan.actuators.len();
    let brake = |brake| PlannedBrake {
        shaft: coordinate.clone(),
        kind: BrakeKind::Brake(brake),
        actuator: Some(actuator_index),
    };
    plan.brakes.extend(actuator.brake.map(brake));
    if !actuator.powertrain.is_direct() {
        let circle = |id: PointId| Circle {
            center: plan.body_point(id.body, mechanism.point(id).at_m),
            signed_radius_m: 0.0,
            is_on: true,
        };
        let distance = |feedback: DistanceFeedback| Coordinate {
            measure: Measure::Cable { circles: feedback.points.map(circle).into() },
            offset: 0.0,
        };
        let measured = actuator.powertrain.feedback.map_or_else(|| coordinate.clone(), distance);
        plan.actuators.push(PlannedActuator::Powertrain(plan.powertrains.len()));
        plan.powertrains.push(PlannedPowertrain::new(actuator, coordinate, measured));
        return;
    }
    match &actuator.command {
        Command::Effort(profile) => {
            plan.actuators.push(PlannedActuator::Motor(plan.motors.len()));
            plan.motors.push(PlannedMotor {
                shaft: coordinate,
                actuation: profile.clone(),
                limit,
                no_load_speed_rad_s: actuator.no_load_speed,
            });
        }
        Command::Servo { kp, kd, target, .. } => {
            let slope = actuator.no_load_speed.map_or(0.0, f64::recip);
            let law = ServoLaw { kp: *kp, kd: *kd, limit, slope, target_rate: 0.0 };
            plan.actuators.push(PlannedActuator::Servo(plan.servos.len()));
            plan.servos.push(PlannedServo { coordinate, target: target.clone(), law, is_motor: true });
        }
    }
}

/// Adds a tendon: its spring is a stop on its elongation, and its actuator a motor that shortens it.
fn add_tendon(plan: &mut Plan, tendon: &Tendon, coordinates: &[Coordinate]) {
    let circle = |element: &PathElement| Circle {
        center: plan.body_point(element.body, element.point_m),
        signed_radius_m: element.side * element.radius_m,
        is_on: true,
    };
    let circles: Vec<Circle> = tendon.path.iter().map(circle).collect();
    let spool = |(joint, factor): &(usize, f64)| (coordinates[*joint].clone(), *factor);
    let far: Vec<_> = tendon.far_joints.iter().map(spool).collect();
    let cable = Measure::Cable { circles: circles.clone() };
    let mut terms = vec![(Coordinate { measure: cable, offset: 0.0 }, 1.0)];
    terms.extend(tendon.joints.iter().map(spool).chain(far.iter().cloned()));
    let length = Coordinate::sum(terms);
    let stop = tendon.law().map(|law| {
        plan.stops.push(PlannedStop { gap: length.clone().less(tendon.rest_m).negated(), law });
        plan.stops.len() - 1
    });
    let motor = tendon.actuator.as_ref().map(|actuator| {
        plan.actuators.push(PlannedActuator::Motor(plan.motors.len()));
        plan.motors.push(PlannedMotor {
            shaft: length.clone().negated(),
            actuation: actuator.tension.positive_part(),
            limit: f64::INFINITY,
            no_load_speed_rad_s: None,
        });
        plan.motors.len() - 1
    });
    let tendon_index = plan.tendons.len();
    let frictions = tendon.path.iter().enumerate().filter_map(|(circle, element)| Some((circle, element.friction?)));
    let planned = frictions.map(|(circle, law)| PlannedCableFriction { tendon: tendon_index, circle, law });
    plan.cable_frictions.extend(planned);
    plan.tendons.push(PlannedTendon { length, stop, motor, circles, far });
}

/// Adds a contact of a point, as a disc, or of an ellipse with a face. The body of the contact is the first of both in the
/// mechanism. The gap between two fixed surfaces does not change, and they are omitted.
fn add_contact(plan: &mut Plan, mechanism: &Mechanism, contact: &PointContact, channel: usize) {
    let pair = &mechanism.contacts[contact.pair];
    let point = match contact.point {
        OutlinePoint::Vertex { point_m, radius_m } => aligned(Shape::Disc(shape::Shape::Disc { radius_m }), point_m),
        OutlinePoint::Ellipse { center_m, semi_axes_m, axis } => {
            PlannedSurface { shape: Shape::Ellipse { semi_axes_m }, origin_m: center_m, direction: axis }
        }
    };
    let mut id = |body: Option<usize>, surface: PlannedSurface| {
        let surfaces = match body {
            Some(body) => &mut plan.bodies[body].surfaces,
            None => &mut plan.fixed_surfaces,
        };
        let index = surfaces.iter().position(|other| *other == surface).unwrap_or(surfaces.len());
        if index == surfaces.len() {
            surfaces.push(surface);
        }
        SurfaceId { body, index }
    };
    let point = id(contact.body, point);
    let face = id(pair.face.body, face_surface(&mechanism.outline(pair.face).shape));
    let [of_own, of_other] = [ContactPointConvention::BodySurface, ContactPointConvention::PartnerSurface];
    let points_are_first = mechanism.points_are_first(pair);
    let (own, against, [of_point, of_face]) = match points_are_first {
        true => (point, face, [of_own, of_other]),
        false => (face, point, [of_other, of_own]),
    };
    let point_convention = match pair.force_point {
        ForcePoint::Points => of_point,
        ForcePoint::Face => of_face,
        ForcePoint::Middle => ContactPointConvention::Middle,
        ForcePoint::Each => ContactPointConvention::EachSurface,
    };
    if let SurfaceId { body: Some(body), index: surface } = own {
        plan.contacts.push(PlannedContact {
            body,
            surface,
            against,
            point_convention,
            law: pair.law,
            rolling: pair.rolling,
            is_reported_on_partner: points_are_first == pair.is_reported_on_face,
            is_removed: false,
        });
        plan.contact_channels.push(channel);
    }
}

/// A surface with the axes of its body.
fn aligned(shape: Shape, origin_m: [f64; 2]) -> PlannedSurface {
    PlannedSurface { shape, origin_m, direction: [1.0, 0.0] }
}

fn face_surface(shape: &OutlineShape) -> PlannedSurface {
    match *shape {
        OutlineShape::Disc { center_m, radius_m } => aligned(Shape::Disc(shape::Shape::Disc { radius_m }), center_m),
        OutlineShape::Capsule { from_m, to_m, radius_m } => {
            aligned(Shape::Capsule(Capsule { end_m: sub(to_m, from_m), radius_m }), from_m)
        }
        OutlineShape::Polygon { ref vertices_m, radius_m } => {
            aligned(Shape::Polygon { vertices_m: vertices_m.clone(), radius_m }, [0.0; 2])
        }
        // The half plane lies below the x axis of its frame.
        OutlineShape::HalfPlane { point_m, normal: [x, y] } => {
            PlannedSurface { shape: Shape::HalfPlane, origin_m: point_m, direction: [y, -x] }
        }
        OutlineShape::Ellipse { center_m, semi_axes_m, angle_rad } => {
            let (sin, cos) = sin_cos(angle_rad);
            PlannedSurface { shape: Shape::Ellipse { semi_axes_m }, origin_m: center_m, direction: [cos, sin] }
        }
    }
}
