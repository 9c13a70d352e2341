//! A gripper at a node of the engine model.

use super::EngineReader;
use super::finger::Links;
use crate::engine::{L11, Motion, OBJECT, Plan, Twist, base, index_of_place};
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
        sample.fingers.clear();
        sample.fingers.extend(Side::BOTH.map(|side| {
            let links = Links { first: base(side), mirror: side.mirror() };
            let phi22_rad = self.finger(side).finger.lengths.phi22_rad;
            let torque =
                motion.plan.motor_torque(base(side) + L11, motion.clock.now(), |body| motion.velocities[body][2]);
            links.read(motion, phi22_rad, side.mirror() * torque)
        }));
        sample.bodies.clear();
        sample.bodies.push(match self.object.motion {
            ObjectMotion::Fixed => {
                BodyState { centre_m: self.object.centre_m, angle_rad: self.object.angle_rad, ..BodyState::default() }
            }
            ObjectMotion::Free { .. } => {
                let (place, v) = (&motion.linkage.places[OBJECT], &motion.velocities[OBJECT]);
                BodyState { centre_m: place.com, angle_rad: place.angle, velocity_m_s: [v[0], v[1]], spin_rad_s: v[2] }
            }
        });
    }

    fn fly(&self, sample: &mut Sample, from: &Sample, accelerations: &[Twist]) {
        let time_s = sample.time_s - from.time_s;
        for side in Side::BOTH {
            let links = Links { first: base(side), mirror: side.mirror() };
            let index = side as usize;
            links.fly(&mut sample.fingers[index], &from.fingers[index], time_s, accelerations);
        }
        if let ObjectMotion::Free { .. } = self.object.motion {
            sample.bodies[0] = from.bodies[0].flown(time_s, &accelerations[OBJECT]);
        }
    }
}
