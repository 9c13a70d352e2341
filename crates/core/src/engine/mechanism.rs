//! The plan of a mechanism.

use super::coordinate::{BodyPose, Coordinate, Measure, Twist};
use super::plan::{
    Capsule, ContactPointConvention, Plan, PlannedActuator, PlannedBody, PlannedContact, PlannedGear, PlannedJoint,
    PlannedMotor, PlannedServo, PlannedSpring, PlannedStop, PlannedSurface, ServoLaw, Shape, SurfaceId,
};
use crate::drive::Profile;
use crate::gripper::{self, Body};
use crate::mechanism::{Actuator, Command, ForcePoint, Mechanism, OutlineShape, PointContact, SpringKind, Start};
use crate::numeric::elementary::hypot;
use crate::numeric::plane::{add, perp, scale, sub};
use crate::shape;

/// Builds the plan of a mechanism from its assembled start.
///
/// Bodies and joints have the indices of the mechanism; bodies for the inertias of joints follow. Contact channels are
/// those of [`Mechanism::point_contacts`], then of [`Mechanism::limits`].
pub fn build_mechanism_plan(mechanism: &Mechanism, start: &Start) -> Plan {
    let states = start.poses.iter().zip(&start.rates);
    let bodies = mechanism.bodies.iter().zip(states).map(|(body, (pose, rate))| PlannedBody {
        body: Body { mass_kg: body.mass_kg, com_m: body.com_m, inertia_kg_m2: body.inertia_kg_m2 },
        origin_m: [pose[0], pose[1]],
        angle_rad: pose[2],
        velocity_m_s: [rate[0], rate[1]],
        rate_rad_s: rate[2],
        gyration_m: (body.inertia_kg_m2 / body.mass_kg).sqrt(),
        surfaces: Vec::new(),
    });
    let joints = mechanism.joints.iter().map(|joint| PlannedJoint {
        kind: joint.kind,
        bodies: joint.bodies,
        anchors_m: joint.points_m,
        offset_rad: joint.offset_rad,
        closes_loop: true,
    });
    let mut plan = Plan {
        gravity_m_s2: mechanism.gravity_m_s2,
        bodies: bodies.collect(),
        joints: joints.collect(),
        ..Plan::default()
    };
    let coordinates: Vec<Coordinate> = plan.joints.iter().map(|joint| plan.joint_coordinate(joint)).collect();
    add_couplings(&mut plan, mechanism, &coordinates);
    add_springs_and_dampers(&mut plan, mechanism, &coordinates);
    mechanism.actuators.iter().for_each(|actuator| add_actuator(&mut plan, actuator, coordinates[actuator.joint]));
    let points = mechanism.point_contacts();
    for (channel, contact) in points.iter().enumerate() {
        add_contact(&mut plan, mechanism, contact, channel);
    }
    for limit in mechanism.limits() {
        let beyond = coordinates[limit.joint].less(limit.value);
        plan.stops.push(PlannedStop { gap: if limit.side > 0.0 { beyond.negated() } else { beyond }, law: limit.law });
        plan.stop_channels.push(points.len() + plan.stop_channels.len());
    }
    plan
}

/// Adds a gear for each coupling, and for the inertia of each joint a body that turns with its coordinate.
fn add_couplings(plan: &mut Plan, mechanism: &Mechanism, coordinates: &[Coordinate]) {
    for coupling in &mechanism.couplings {
        let terms = coupling.terms.iter().map(|(joint, factor)| (coordinates[*joint], [*factor, 0.0]));
        plan.gears.push(PlannedGear { terms: terms.collect() });
    }
    let poses: Vec<BodyPose> = plan.bodies.iter().map(PlannedBody::pose).collect();
    let velocity = |(body, pose): (&PlannedBody, &BodyPose)| {
        let arm = perp(sub(pose.com, body.origin_m));
        let [x, y] = add(body.velocity_m_s, scale(arm, body.rate_rad_s));
        [x, y, body.rate_rad_s]
    };
    let velocities: Vec<Twist> = plan.bodies.iter().zip(&poses).map(velocity).collect();
    for (joint, coordinate) in mechanism.joints.iter().zip(coordinates) {
        if joint.armature > 0.0 {
            let rotor = plan.bodies.len();
            let rate_rad_s = coordinate.row(&poses).rate(&velocities);
            plan.bodies.push(PlannedBody { rate_rad_s, ..PlannedBody::at_origin(joint.armature) });
            let terms = vec![(Coordinate::angle_of(rotor), [1.0, 0.0]), (*coordinate, [-1.0, 0.0])];
            plan.gears.push(PlannedGear { terms });
        }
    }
}

fn add_springs_and_dampers(plan: &mut Plan, mechanism: &Mechanism, coordinates: &[Coordinate]) {
    for (joint, coordinate) in mechanism.joints.iter().zip(coordinates) {
        add_damper(plan, *coordinate, joint.damping);
    }
    for spring in &mechanism.springs {
        let extension = match spring.kind {
            SpringKind::Torsional { joint, preload } => {
                if preload != 0.0 {
                    let kind = gripper::SpringKind::Constant { torque_n_m: -preload };
                    plan.springs.push(PlannedSpring { extension: coordinates[joint], kind });
                }
                coordinates[joint].less(spring.rest)
            }
            SpringKind::Linear { bodies, points_m } => {
                let points = [0, 1].map(|k: usize| plan.body_point(bodies[k], points_m[k]));
                Coordinate { measure: Measure::Distance { points }, offset: spring.rest }
            }
        };
        if spring.stiffness != 0.0 {
            let kind = gripper::SpringKind::Torsional { stiffness_n_m_per_rad: spring.stiffness, preload_rad: 0.0 };
            plan.springs.push(PlannedSpring { extension, kind });
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

fn add_actuator(plan: &mut Plan, actuator: &Actuator, coordinate: Coordinate) {
    let limit = actuator.limit.unwrap_or(f64::INFINITY);
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
        Command::Servo { kp, kd, target } => {
            let slope = actuator.no_load_speed.map_or(0.0, f64::recip);
            let law = ServoLaw { kp: *kp, kd: *kd, limit, slope, target_rate: 0.0 };
            plan.actuators.push(PlannedActuator::Servo(plan.servos.len()));
            plan.servos.push(PlannedServo { coordinate, target: target.clone(), law, is_motor: true });
        }
    }
}

/// Adds a contact of a point, as a disc, with a face. The body of the contact is that of the point, unless it is fixed.
/// The gap between two fixed surfaces does not change, and they are omitted.
fn add_contact(plan: &mut Plan, mechanism: &Mechanism, contact: &PointContact, channel: usize) {
    let pair = &mechanism.contacts[contact.pair];
    let disc = Shape::Disc(shape::Shape::Disc { radius_m: contact.radius_m });
    let point = PlannedSurface { shape: disc, origin_m: contact.point_m, direction: [1.0, 0.0] };
    let face = face_surface(&mechanism.outline(pair.face).shape);
    let mut add = |body: Option<usize>, surface: PlannedSurface| {
        let surfaces = match body {
            Some(body) => &mut plan.bodies[body].surfaces,
            None => &mut plan.fixed_surfaces,
        };
        surfaces.push(surface);
        SurfaceId { body, index: surfaces.len() - 1 }
    };
    let (point, face) = (add(contact.body, point), add(pair.face.body, face));
    let [of_point, of_face] = [ContactPointConvention::BodySurface, ContactPointConvention::PartnerSurface];
    let (own, against, [of_point, of_face]) = match point.body {
        Some(_) => (point, face, [of_point, of_face]),
        None => (face, point, [of_face, of_point]),
    };
    let point_convention = match pair.force_point {
        ForcePoint::Points => of_point,
        ForcePoint::Face => of_face,
        ForcePoint::Middle => ContactPointConvention::Middle,
    };
    if let SurfaceId { body: Some(body), index: surface } = own {
        plan.contacts.push(PlannedContact { body, surface, against, point_convention, law: pair.law });
        plan.contact_channels.push(channel);
    }
}

fn face_surface(shape: &OutlineShape) -> PlannedSurface {
    match *shape {
        OutlineShape::Disc { center_m, radius_m } => {
            let shape = Shape::Disc(shape::Shape::Disc { radius_m });
            PlannedSurface { shape, origin_m: center_m, direction: [1.0, 0.0] }
        }
        OutlineShape::Capsule { from_m, to_m, radius_m } => {
            let [x, y] = sub(to_m, from_m);
            let length_m = hypot(x, y);
            let shape = Shape::Capsule(Capsule { length_m, angle_rad: 0.0, radius_m });
            PlannedSurface { shape, origin_m: from_m, direction: scale([x, y], 1.0 / length_m) }
        }
        // The half plane lies below the x axis of its frame.
        OutlineShape::HalfPlane { point_m, normal: [x, y] } => {
            PlannedSurface { shape: Shape::HalfPlane, origin_m: point_m, direction: [y, -x] }
        }
    }
}
