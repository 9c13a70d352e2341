//! A gripper at a node of the engine model.

use super::EngineReader;
use super::finger::Links;
use crate::engine::{Frame, L11, Motion, OBJECT, Plan, base, brake_torque, index_of_place};
use crate::scene::{GripperScene, ObjectMotion, Place, Side};
use crate::trace::{BodyState, Sample};

impl EngineReader for GripperScene {
    fn place(&self, plan: &Plan, index: usize) -> usize {
        let is_it = |place: &Place| index_of_place(plan, *place) == Some(index);
        Place::ALL.iter().position(is_it).expect("every stop and contact of a gripper's plan is a place")
    }

    fn index(&self, plan: &Plan, place: usize) -> Option<usize> {
        index_of_place(plan, Place::ALL[place])
    }

    /// Away from the object, off palm and table too.
    fn normal(&self, place: usize, normal: [f64; 2]) -> [f64; 2] {
        match Place::ALL[place] {
            Place::Finger(..) => normal,
            Place::Palm | Place::Table => normal.map(|part| -part),
        }
    }

    fn read(&self, motion: &Motion, sample: &mut Sample) {
        let frame = Frame::at(motion.plan, motion.clock.now());
        sample.fingers.clear();
        sample.fingers.extend(Side::BOTH.map(|side| {
            let links = Links { first: base(side), mirror: side.mirror(), stands: frame.turning() };
            let phi22_rad = self.finger(side).finger.lengths.phi22_rad;
            let torque =
                motion.plan.motor_torque(base(side) + L11, motion.clock.now(), |body| motion.velocities[body][2]);
            let brakes = brake_torque(motion.plan, side, |hold| motion.hold_torque(hold));
            links.read(motion, phi22_rad, side.mirror() * torque + brakes)
        }));
        sample.bodies.clear();
        sample.bodies.push(match self.object.motion {
            ObjectMotion::Fixed => {
                BodyState { centre_m: self.object.centre_m, angle_rad: self.object.angle_rad, ..BodyState::default() }
            }
            ObjectMotion::Free { .. } => {
                let (place, v) = (&motion.linkage.places[OBJECT], &motion.velocities[OBJECT]);
                let ([vx, vy, spin_rad_s], centre_m) = (frame.twist(place.com, v), frame.point(place.com));
                let angle_rad = place.angle - frame.turning()[0];
                BodyState { centre_m, angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
            }
        });
    }

    fn fly(&self, sample: &mut Sample, from: &Sample, motion: &Motion) {
        let accelerations = &motion.step_accelerations;
        let time_s = sample.time_s - from.time_s;
        let frame = Frame::at(motion.plan, motion.clock.now());
        for side in Side::BOTH {
            let links = Links { first: base(side), mirror: side.mirror(), stands: frame.turning() };
            let index = side as usize;
            links.fly(&mut sample.fingers[index], &from.fingers[index], time_s, accelerations);
        }
        if let ObjectMotion::Free { .. } = self.object.motion {
            let (place, v) = (&motion.linkage.places[OBJECT], &motion.velocities[OBJECT]);
            let acceleration = frame.acceleration(place.com, v, &accelerations[OBJECT]);
            sample.bodies[0] = from.bodies[0].flown(time_s, &acceleration);
        }
    }
}
