//! Contact candidates: gaps, normals, and the rows that give their rates from body velocities.

use std::f64::consts::TAU;

use super::cable::{self, PlannedCableFriction};
use super::closest::{ClosestPoints, closest_points};
use super::coordinate::{BodyPose, Row, Twist};
use super::linkage::Linkage;
use super::plan::{Plan, PlannedBody, PlannedBrake, PlannedContact, PlannedMotor, PlannedServo, ServoLaw};
use super::powertrain::{PlannedPowertrain, PowertrainLaw};
use super::world::World;
use crate::law::{FrictionLaw, FrictionPoint, FrictionStep, NormalForce, NormalLaw, normal_force};
use crate::numeric::elementary::hypot;
use crate::numeric::plane::{cross, perp, sub};
use crate::scene::Response;

/// A possible contact, stop, brake, motor or servo at one instant.
#[derive(Clone, Debug)]
pub struct ContactCandidate {
    /// Index of the element in the plan.
    pub index: usize,
    pub law: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Distance of the surfaces; negative in penetration.
    pub gap: f64,
    /// Rounding error of the gap due to the rounding of the positions.
    pub rounding: f64,
    pub normal: [f64; 2],
    /// Rotation rate of the normal, rad/s, computed from its rotation in the last step.
    pub normal_rotation_rate: f64,
    pub point: [f64; 2],
    pub normal_row: Row,
    /// Row of the slip of the body's surface relative to the other surface; zero for a stop.
    pub slip_row: Row,
    /// Law of rolling resistance: a moment against the relative rotation.
    pub rolling: Option<FrictionLaw>,
    /// Row of the relative rotation that the rolling resistance opposes.
    pub roll_row: Row,
    /// Torque characteristic of a motor with a no-load speed.
    pub motor: Option<MotorSlope>,
    /// Law of a powertrain: a force along the slip row, which depends on the gap.
    pub powertrain: Option<PowertrainLaw>,
    /// Law of a servo, which replaces the normal law. The gap is then minus the error of the coordinate.
    pub servo: Option<ServoLaw>,
    /// Prescribed rate and acceleration of the gap. For a brake or a motor, they model the change of its force over a
    /// step; for a servo, they are those of the target.
    pub prescribed_gap_motion: [f64; 2],
    /// Whether the contact laws of the scene apply. They do not if rapier handles the contact, or if the pair is out of
    /// reach.
    pub uses_contact_law: bool,
    /// Whether the work of the element counts as work of a motor.
    pub is_motor: bool,
    /// Friction of a cable.
    pub cable: Option<CablePass>,
    /// Whether friction acts only against negative slip.
    pub one_way: bool,
    /// The component of the plan that defines the gap.
    pub element: Element,
}

/// Component of the plan behind a candidate, by its index among components of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    Stop(usize),
    Contact(usize),
    /// A brake: friction under a prescribed normal force.
    Brake(usize),
    /// A motor with a no-load speed: a torque along its slip row.
    Motor(usize),
    /// A servo: a force along its normal row.
    Servo(usize),
    /// A powertrain: a force along its slip row.
    Powertrain(usize),
    /// Friction of a cable on a circle. Its normal force is the tension of the actuator of the cable, plus an offset, so that
    /// the candidate always has one.
    Cable(usize),
}

/// State of the friction of a cable in a step.
#[derive(Clone, Copy, Debug)]
pub struct CablePass {
    /// Wrap in the middle of the step, rad.
    pub turn: f64,
    /// Part of the normal force that is not a tension, N.
    pub offset_n: f64,
}

/// Torque of a motor with a no-load speed, relative to the stall torque: its sign, and its decrease per unit rate.
#[derive(Clone, Copy, Debug)]
pub struct MotorSlope {
    pub sign: f64,
    pub slope: f64,
}

/// Gaps below this fraction of the transition are rounding errors of surfaces that a step has brought into contact.
pub(crate) const GAP_ROUNDING: f64 = 1e-9;
/// Rates below this are rounding errors, m/s (stop: rad/s); the analytic model starts a run with the same value.
pub(crate) const ZERO_RATE: f64 = 1e-12;

impl ContactCandidate {
    /// A candidate with a zero gap, without friction, and not subject to its law.
    fn new(index: usize, element: Element, law: NormalLaw, [normal_row, slip_row]: [Row; 2]) -> Self {
        Self {
            index,
            law,
            friction: None,
            gap: 0.0,
            rounding: 0.0,
            normal: [0.0; 2],
            normal_rotation_rate: 0.0,
            point: [0.0; 2],
            normal_row,
            slip_row,
            rolling: None,
            roll_row: Row::none(),
            motor: None,
            powertrain: None,
            servo: None,
            prescribed_gap_motion: [0.0; 2],
            uses_contact_law: false,
            is_motor: false,
            cable: None,
            one_way: false,
            element,
        }
    }

    /// Returns the force along the normal row, with its derivatives by penetration and penetration rate.
    #[inline(always)]
    pub(crate) fn normal_force(&self, gap: f64, gap_rate: f64) -> NormalForce {
        match &self.servo {
            Some(law) => law.force(-gap, -gap_rate),
            None => normal_force(&self.law, -gap, -gap_rate),
        }
    }

    /// Friction at the end of an implicit step: opposing force along the slip row at the rate `slip`, with its
    /// derivatives with respect to rate and normal force, as in [`FrictionStep`]. A law without internal state leaves
    /// the state unchanged.
    #[inline(always)]
    pub(crate) fn friction_at_step_end(&self, [slip, state, normal]: [f64; 3], h: f64) -> FrictionStep {
        if let Some(MotorSlope { sign, slope }) = self.motor {
            let relative_torque = slope * slip - sign;
            let force = normal * relative_torque;
            return FrictionStep { force, d_slip: normal * slope, d_normal: relative_torque, state };
        }
        match &self.friction {
            Some(law) => law.implicit_step(FrictionPoint { slip, state, normal }, h, self.one_way),
            None => FrictionStep { force: 0.0, d_slip: 0.0, d_normal: 0.0, state },
        }
    }

    /// Returns the friction law if it has an internal state.
    pub fn law_with_state(&self) -> Option<&FrictionLaw> {
        self.friction.as_ref().filter(|law| law.has_state())
    }

    /// Prescribes the depth in a step, a parabola through these values at its start, middle and end.
    fn follow_parabola(&mut self, [start, middle, end]: [f64; 3], dt: f64) {
        let rate = (4.0 * middle - 3.0 * start - end) / dt;
        (self.gap, self.prescribed_gap_motion) = (-start, [-rate, -4.0 * (start - 2.0 * middle + end) / (dt * dt)]);
    }

    /// Whether there is a force along the slip row.
    pub(crate) fn has_tangent(&self) -> bool {
        self.friction.is_some() || self.motor.is_some() || self.powertrain.is_some()
    }

    /// Whether the candidate has a gap, as surfaces and stops do.
    pub(crate) fn has_gap(&self) -> bool {
        matches!(self.element, Element::Stop(_) | Element::Contact(_))
    }

    /// Whether the normal force is prescribed, as of brakes and motors, or the gap of a powertrain.
    pub(crate) fn has_prescribed_normal(&self) -> bool {
        matches!(self.element, Element::Brake(_) | Element::Motor(_) | Element::Cable(_))
            || self.powertrain.is_some_and(|law| law.has_prescribed_gap())
    }

    /// Normal force under which the friction law applies, when the force along the normal row is `normal`: the law of a cable
    /// gives a coefficient.
    pub(crate) fn law_normal(&self, normal: f64) -> f64 {
        if self.cable.is_some() { 1.0 } else { normal }
    }

    /// Law of friction without a state that changes within narrow ranges of the slip.
    pub(crate) fn slip_law(&self) -> Option<&FrictionLaw> {
        let loss = self.powertrain.as_ref().and_then(PowertrainLaw::loss_law);
        self.friction.as_ref().or(loss).filter(|law| !law.has_state())
    }

    /// Whether the force acts in both directions and at any gap, as of servos and powertrains.
    pub(crate) fn is_servo(&self) -> bool {
        matches!(self.element, Element::Servo(_) | Element::Powertrain(_))
    }

    /// Whether the gap is larger than its rounding error.
    pub fn is_separated(&self) -> bool {
        self.gap > GAP_ROUNDING * self.law.depth_scale_m()
    }

    /// Whether the candidate is a pair of surfaces, whose normal rotates with the bodies; a stop's gap is an angle.
    pub(crate) fn is_between_surfaces(&self) -> bool {
        matches!(self.element, Element::Contact(_))
    }
}

pub fn find(candidates: &[ContactCandidate], index: usize) -> Option<&ContactCandidate> {
    candidates.iter().find(|candidate| candidate.index == index)
}

/// Collects all stops, contacts, brakes, motors with a no-load speed, and servos.
pub fn collect(world: &World, plan: &Plan, linkage: &Linkage, candidates: &mut Vec<ContactCandidate>) {
    candidates.clear();
    for (index, stop) in plan.stops.iter().enumerate() {
        let normal_row = stop.gap.row(&linkage.poses);
        candidates.push(ContactCandidate {
            gap: stop.gap.value(&linkage.poses),
            rounding: f64::EPSILON * TAU,
            uses_contact_law: true,
            ..ContactCandidate::new(index, Element::Stop(index), stop.law, [normal_row, Row::none()])
        });
    }
    for (index, contact) in plan.contacts.iter().enumerate() {
        let [collider, other] = world.contacts[index];
        let in_reach = || world.physics.narrow_phase.contact_pair(collider, other).is_some();
        let Some(points) = closest_points(world, plan, index, &linkage.poses) else { continue };
        let ClosestPoints { gap, normal, .. } = points;
        let rows = surface_rows(plan, index, &linkage.poses, &points);
        candidates.push(ContactCandidate {
            friction: contact.law.friction,
            rolling: contact.rolling,
            roll_row: Row::new(
                (contact.body, [0.0, 0.0, 1.0]),
                contact.against.body.map(|partner| (partner, [0.0, 0.0, -1.0])),
            ),
            gap,
            rounding: gap_rounding(plan, contact, &linkage.poses),
            normal,
            point: points.at(contact.point_convention)[0],
            uses_contact_law: world.response == Response::Laws && in_reach(),
            ..ContactCandidate::new(plan.stops.len() + index, Element::Contact(index), contact.law.normal, rows)
        });
    }
    candidates.extend((0..plan.brakes.len()).map(|index| brake_candidate(plan, index, &linkage.poses)));
    let motor_candidate_of = |(index, motor): (usize, &PlannedMotor)| {
        motor.no_load_speed_rad_s.map(|speed| motor_candidate(plan, index, speed, &linkage.poses))
    };
    candidates.extend(plan.motors.iter().enumerate().filter_map(motor_candidate_of));
    let servos = plan.servos.iter().enumerate();
    candidates.extend(servos.map(|(index, servo)| servo_candidate(plan, index, servo, &linkage.poses)));
    candidates.extend((0..plan.powertrains.len()).map(|index| powertrain_candidate(plan, index, &linkage.poses)));
    let frictions = plan.cable_frictions.iter().enumerate();
    candidates.extend(frictions.map(|(index, friction)| cable_candidate(plan, index, friction, &linkage.poses)));
}

/// Models the friction of a cable as a contact; [`set_cables`] sets its tension and its wrap.
fn cable_candidate(plan: &Plan, index: usize, friction: &PlannedCableFriction, poses: &[BodyPose]) -> ContactCandidate {
    let tendon = &plan.tendons[friction.tendon];
    let slip_row = cable::slip_row(&tendon.circles, friction.circle, &tendon.far, poses);
    ContactCandidate {
        friction: Some(friction.law),
        cable: Some(CablePass { turn: 0.0, offset_n: 1.0 }),
        uses_contact_law: tendon.circles[friction.circle].is_on,
        ..shaft_candidate(plan.first_cable_friction() + index, Element::Cable(index), slip_row)
    }
}

/// Sets the wraps of cables with friction in the middle of a step, and the tensions of their actuators: a parabola.
pub(crate) fn set_cables(
    plan: &Plan,
    (poses, velocities): (&[BodyPose], &[Twist]),
    (t, dt): (f64, f64),
    candidates: &mut [ContactCandidate],
) {
    let times = [1e-9, 0.5, 1.0 - 1e-9].map(|fraction| t + fraction * dt);
    for candidate in candidates.iter_mut().filter(|candidate| candidate.uses_contact_law) {
        let Element::Cable(index) = candidate.element else { continue };
        let PlannedCableFriction { tendon, circle, .. } = plan.cable_frictions[index];
        let tendon = &plan.tendons[tendon];
        let motor = tendon.motor.map(|motor| &plan.motors[motor]);
        let pulls = times.map(|t| motor.map_or(0.0, |motor| motor.stall_torque(t)));
        let offset_n = pulls.into_iter().fold(0.0, f64::max).max(1.0);
        let turn = cable::turn(&tendon.circles, circle, poses);
        let middle = turn + 0.5 * dt * cable::turn_rate(&tendon.circles, circle, poses, velocities);
        candidate.cable = Some(CablePass { turn: middle.max(0.0), offset_n });
        candidate.law = NormalLaw::constant_force(offset_n);
        candidate.follow_parabola(pulls.map(|pull| 1.0 + pull / offset_n), dt);
    }
}

/// Models a brake as a contact: friction under a force set by [`set_shaft_torques`].
fn brake_candidate(plan: &Plan, index: usize, poses: &[BodyPose]) -> ContactCandidate {
    let PlannedBrake { shaft, kind, .. } = &plan.brakes[index];
    ContactCandidate {
        friction: Some(kind.law()),
        one_way: kind.is_one_way(),
        ..shaft_candidate(plan.first_brake() + index, Element::Brake(index), shaft.row(poses))
    }
}

/// Models as a contact a motor with a no-load speed; [`set_shaft_torques`] sets its torque.
fn motor_candidate(plan: &Plan, index: usize, no_load_speed_rad_s: f64, poses: &[BodyPose]) -> ContactCandidate {
    ContactCandidate {
        is_motor: true,
        motor: Some(MotorSlope { sign: 1.0, slope: no_load_speed_rad_s.recip() }),
        ..shaft_candidate(plan.first_motor() + index, Element::Motor(index), plan.motors[index].shaft.row(poses))
    }
}

/// Models a servo as a contact; [`set_shaft_torques`] sets its target.
fn servo_candidate(plan: &Plan, index: usize, servo: &PlannedServo, poses: &[BodyPose]) -> ContactCandidate {
    let normal_row = servo.coordinate.row(poses);
    let law = NormalLaw::constant_force(0.0);
    ContactCandidate {
        gap: servo.coordinate.value(poses),
        rounding: f64::EPSILON,
        servo: Some(servo.law),
        is_motor: servo.is_motor,
        uses_contact_law: true,
        ..ContactCandidate::new(plan.first_servo() + index, Element::Servo(index), law, [normal_row, Row::none()])
    }
}

/// Models a powertrain as a contact; [`set_shaft_torques`] sets its gap.
fn powertrain_candidate(plan: &Plan, index: usize, poses: &[BodyPose]) -> ContactCandidate {
    let powertrain = &plan.powertrains[index];
    let (element, without_force) = (Element::Powertrain(index), NormalLaw::constant_force(0.0));
    ContactCandidate {
        rounding: f64::EPSILON,
        powertrain: Some(powertrain.law),
        is_motor: true,
        uses_contact_law: true,
        ..ContactCandidate::new(
            plan.first_powertrain() + index,
            element,
            without_force,
            powertrain_rows(powertrain, poses),
        )
    }
}

/// Rows of what a powertrain measures, if it does, and of its shaft.
fn powertrain_rows(PlannedPowertrain { shaft, measured, .. }: &PlannedPowertrain, poses: &[BodyPose]) -> [Row; 2] {
    [measured.as_ref().map_or_else(Row::none, |measured| measured.row(poses)), shaft.row(poses)]
}

/// Returns a candidate along the slip row of a shaft. No body changes its penetration, which together with the stiffness
/// of its law defines the normal force.
fn shaft_candidate(index: usize, element: Element, slip_row: Row) -> ContactCandidate {
    ContactCandidate {
        gap: -1.0,
        rounding: f64::EPSILON,
        ..ContactCandidate::new(index, element, NormalLaw::constant_force(0.0), [Row::none(), slip_row])
    }
}

/// Sets the forces of brakes and motors for a step, a parabola through the values at its start, middle and end; and the
/// motion of the targets of servos, also a parabola.
pub(crate) fn set_shaft_torques(plan: &Plan, poses: &[BodyPose], t: f64, dt: f64, candidates: &mut [ContactCandidate]) {
    // Discontinuities at both ends belong to adjacent steps.
    let times = [1e-9, 0.5, 1.0 - 1e-9].map(|fraction| t + fraction * dt);
    for candidate in candidates {
        let torques = match candidate.element {
            Element::Brake(index) => times.map(|t| plan.brakes[index].kind.normal_force(t)),
            Element::Motor(index) => {
                let torques = times.map(|t| plan.motors[index].stall_torque(t));
                candidate.motor = candidate.motor.map(|motor| MotorSlope { sign: torques[1].signum(), ..motor });
                torques.map(f64::abs)
            }
            Element::Servo(index) => {
                let PlannedServo { coordinate, target, law, .. } = &plan.servos[index];
                let [(start, start_rate), _, (_, end_rate)] = times.map(|t| target.at(t));
                candidate.gap = coordinate.value(poses) - start;
                candidate.servo = Some(ServoLaw { target_rate: 0.5 * (start_rate + end_rate), ..*law });
                candidate.prescribed_gap_motion = [start_rate, (end_rate - start_rate) / dt];
                continue;
            }
            Element::Powertrain(index) => {
                let PlannedPowertrain { input, measured, .. } = &plan.powertrains[index];
                let [(start, start_rate), (middle, _), (end, end_rate)] = times.map(|t| input.at(t));
                if let Some(measured) = measured {
                    candidate.gap = measured.value(poses) - start;
                    candidate.prescribed_gap_motion = [start_rate, (end_rate - start_rate) / dt];
                } else {
                    candidate.follow_parabola([start, middle, end], dt);
                }
                continue;
            }
            Element::Stop(_) | Element::Contact(_) | Element::Cable(_) => continue,
        };
        let max_torque = torques.into_iter().fold(0.0, f64::max);
        candidate.law = NormalLaw::constant_force(max_torque);
        candidate.uses_contact_law = max_torque > 0.0;
        if candidate.uses_contact_law {
            candidate.follow_parabola(torques.map(|torque| torque / max_torque), dt);
        }
    }
}

/// Sets the gap to zero where surfaces at rest overlap only by a rounding error, which must not cause a contact force.
pub(crate) fn zero_rounding_gaps(candidates: &mut [ContactCandidate], velocities: &[Twist]) {
    for candidate in candidates.iter_mut().filter(|candidate| candidate.is_between_surfaces()) {
        let is_rounding = candidate.gap < 0.0 && candidate.gap >= -candidate.rounding;
        if is_rounding && candidate.normal_row.rate(velocities).abs() <= ZERO_RATE {
            candidate.gap = 0.0;
        }
    }
}

/// Rotation, rad, as which a change of a lever arm by the gyration radius of its body counts: a corner that rebounds from
/// a floor passes its error of the spin on to all later impacts. With 1, a box dropped on a corner turns 1.3e-4 rad wrong.
const LEVER_ROTATION: f64 = 8.0;

/// Sets the rotation rates of the normals, from the normals and normal rows `before`, a time `dt` earlier. In bodies with
/// a gyration radius, changes of lever arms count as well.
pub(crate) fn set_normal_rotation_rates(
    candidates: &mut [ContactCandidate],
    bodies: &[PlannedBody],
    before: &[([f64; 2], Row)],
    dt: f64,
) {
    let turn = |(body, [.., arm]): (usize, Twist), (_, [.., arm_before]): (usize, Twist)| {
        let gyration_m = bodies[body].gyration_m;
        if gyration_m > 0.0 { LEVER_ROTATION * (arm - arm_before).abs() / gyration_m } else { 0.0 }
    };
    for (candidate, (normal_before, row_before)) in candidates.iter_mut().zip(before) {
        let [x, y] = sub(candidate.normal, *normal_before);
        let mut rotation = hypot(x, y);
        if candidate.is_between_surfaces() {
            let row = &candidate.normal_row;
            rotation = rotation.max(turn(row.on, row_before.on));
            if let Some((on, on_before)) = row.against.zip(row_before.against) {
                rotation = rotation.max(turn(on, on_before));
            }
        }
        candidate.normal_rotation_rate = rotation / dt;
    }
}

/// Returns the gap, and the normal and slip rows, of a candidate at other body poses; `None` if its surfaces have no closest
/// points there. The gap of a component without surfaces is that of the candidate.
pub(crate) fn gap_and_rows_at(
    candidate: &ContactCandidate,
    world: &World,
    plan: &Plan,
    poses: &[BodyPose],
) -> Option<(f64, [Row; 2])> {
    let along = |row: Row| (candidate.gap, [row, Row::none()]);
    let across = |row: Row| (candidate.gap, [Row::none(), row]);
    Some(match candidate.element {
        Element::Stop(index) => along(plan.stops[index].gap.row(poses)),
        Element::Servo(index) => along(plan.servos[index].coordinate.row(poses)),
        Element::Brake(index) => across(plan.brakes[index].shaft.row(poses)),
        Element::Motor(index) => across(plan.motors[index].shaft.row(poses)),
        Element::Powertrain(index) => (candidate.gap, powertrain_rows(&plan.powertrains[index], poses)),
        Element::Cable(index) => {
            let PlannedCableFriction { tendon, circle, .. } = plan.cable_frictions[index];
            let tendon = &plan.tendons[tendon];
            across(cable::slip_row(&tendon.circles, circle, &tendon.far, poses))
        }
        Element::Contact(index) => {
            let points = closest_points(world, plan, index, poses)?;
            (points.gap, surface_rows(plan, index, poses, &points))
        }
    })
}

/// Returns the normal and slip rows of a contact between surfaces.
fn surface_rows(plan: &Plan, index: usize, poses: &[BodyPose], points: &ClosestPoints) -> [Row; 2] {
    [points.normal, perp(points.normal)].map(|direction| contact_row(plan, index, poses, points, direction))
}

/// Returns the row of a contact along a direction. The point on each surface follows the contact's point convention.
fn contact_row(plan: &Plan, index: usize, poses: &[BodyPose], points: &ClosestPoints, direction: [f64; 2]) -> Row {
    let side = |body: usize, point: [f64; 2], direction: [f64; 2]| {
        let arm = sub(point, poses[body].com);
        (body, [direction[0], direction[1], cross(arm, direction)])
    };
    let contact = &plan.contacts[index];
    let [body_point, partner_point] = points.at(contact.point_convention);
    let partner = |body: usize| side(body, partner_point, [-direction[0], -direction[1]]);
    Row::new(side(contact.body, body_point, direction), contact.against.body.map(partner))
}

/// Returns the rounding error of a gap between two surfaces.
fn gap_rounding(plan: &Plan, contact: &PlannedContact, poses: &[BodyPose]) -> f64 {
    let size = |[x, y]: [f64; 2]| x.abs().max(y.abs());
    let other = contact.against.body.map_or_else(|| plan.surface(contact.against).origin_m, |body| poses[body].com);
    f64::EPSILON * (size(poses[contact.body].com) + size(other))
}
