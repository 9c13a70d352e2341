//! The plan of a gripper: the links of both fingers, the object, palm and table, and a differential as wheels.

use super::finger::{L11, Mount, Parts, add};
use super::plan::{
    Against, Course, Meet, Plan, PlannedBody, PlannedContact, PlannedDrive, PlannedFixed, PlannedGear, PlannedHold,
    PlannedMotor, PlannedRotor, Shape,
};
use crate::gripper::{Body, Site};
use crate::law::ContactLaw;
use crate::scene::{Differential, GripperFinger, GripperScene, Motor, ObjectMotion, Place, Side};

/// Links of a finger.
const LINKS: usize = 4;

/// The body that is the object, where it moves.
pub const OBJECT: usize = 2 * LINKS;

/// The body that is the palm, where that moves: behind the object.
const PALM: usize = OBJECT + 1;

/// The first body of a finger; its links come in the order of a finger's plan.
pub fn base(side: Side) -> usize {
    LINKS * side as usize
}

/// The plan of a gripper, or the finger whose angles do not close its loop.
pub fn plan_gripper(scene: &GripperScene) -> Result<Plan, Side> {
    let mut plan = Plan { gravity_m_s2: scene.gravity_m_s2, ..Plan::default() };
    let shape = Shape::Disc { radius_m: scene.object.radius_m };
    let origin_m = scene.object.centre_m;
    let object = match scene.object.motion {
        ObjectMotion::Fixed => {
            plan.fixed.push(PlannedFixed { shape, origin_m, direction: [1.0, 0.0] });
            Against::Fixed(0)
        }
        ObjectMotion::Free { .. } => Against::Body(OBJECT),
    };
    let palm = scene.palm_motion.as_ref().map(|_| PALM);
    for side in Side::BOTH {
        let GripperFinger { finger, spring, limit, contact, initial, .. } = scene.finger(side);
        let parts = Parts {
            finger,
            initial,
            spring: *spring,
            limit: *limit,
            contact: *contact,
            object: Some(object),
            meet: Meet::Body,
        };
        let mirror = side.mirror();
        let ground_m = [mirror * 0.5 * scene.palm_width_m, 0.0];
        add(&mut plan, &parts, Mount { on: palm, ground_m, mirror }).ok_or(side)?;
        let (motor, driven) = (&scene.finger(side).motor, base(side) + L11);
        // The rotor turns with the link, about a joint that stays where it is in the palm.
        plan.bodies[driven].body.inertia_kg_m2 += motor.inertia_kg_m2;
        add_rotor(&mut plan, driven, motor.inertia_kg_m2);
        let on = std::iter::once((driven, mirror)).chain(palm.map(|palm| (palm, -mirror)));
        plan.motors.push(planned(motor, on.collect()));
        let against = palm.map(|palm| (palm, -mirror));
        plan.holds.extend(motor.brake.map(|brake| PlannedHold { on: (driven, mirror), against, brake }));
    }
    if let ObjectMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } = scene.object.motion {
        plan.bodies.push(PlannedBody {
            body: Body { mass_kg, com_m: [0.0; 2], inertia_kg_m2 },
            origin_m,
            angle_rad: scene.object.angle_rad,
            velocity_m_s,
            rate_rad_s: spin_rad_s,
            shape: Some(shape),
        });
        if let Some(motion) = &scene.palm_motion {
            plan.drives.push(PlannedDrive { body: PALM, course: Course::Palm(motion.clone()) });
            plan.bodies.push(PlannedBody {
                body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2: 0.0 },
                origin_m: [0.0; 2],
                angle_rad: 0.0,
                velocity_m_s: [0.0; 2],
                rate_rad_s: 0.0,
                shape: scene.palm.map(|_| Shape::HalfPlane),
            });
        }
        let mut contact = |against: Against, law: ContactLaw| {
            plan.contacts.push(PlannedContact { body: OBJECT, against, meet: Meet::Other, law });
        };
        let mut plane = |level_m: f64, side: f64| {
            plan.fixed.push(PlannedFixed { shape: Shape::HalfPlane, origin_m: [0.0, level_m], direction: [side, 0.0] });
            Against::Fixed(plan.fixed.len() - 1)
        };
        if let Some(law) = scene.palm {
            contact(palm.map_or_else(|| plane(0.0, 1.0), Against::Body), law);
        }
        if let Some(table) = scene.table {
            contact(plane(table.level_m, -1.0), table.contact);
        }
    }
    if let Some(differential) = &scene.differential {
        add_differential(&mut plan, differential);
    }
    Ok(plan)
}

fn planned(motor: &Motor, on: Vec<(usize, f64)>) -> PlannedMotor {
    PlannedMotor { on, actuation: motor.actuation.clone(), no_load_speed_rad_s: motor.no_load_speed_rad_s }
}

fn add_rotor(plan: &mut Plan, body: usize, inertia_kg_m2: f64) {
    if inertia_kg_m2 > 0.0 {
        plan.rotors.push(PlannedRotor { body, inertia_kg_m2 });
    }
}

/// Half of the input's torque goes to each finger; what has inertia is a wheel, geared to both driven links: the input turns by the mean of
/// their closing angles, the seesaw by half of their difference.
fn add_differential(plan: &mut Plan, differential: &Differential) {
    let Differential { motor, seesaw_inertia_kg_m2 } = differential;
    let [right, left] = Side::BOTH.map(|side| base(side) + L11);
    plan.motors.push(planned(motor, vec![(right, 0.5), (left, -0.5)]));
    let (on, against) = ((right, 0.5), Some((left, -0.5)));
    plan.holds.extend(motor.brake.map(|brake| PlannedHold { on, against, brake }));
    let inertias = [motor.inertia_kg_m2, *seesaw_inertia_kg_m2];
    if inertias == [0.0; 2] {
        return;
    }
    let first = plan.bodies.len();
    let palm = plan.palm().map(|(body, _)| body);
    (0..2).for_each(|index| add_rotor(plan, first + index, inertias[index]));
    // A wheel without inertia would follow for nothing: one that nothing drives stands in for it.
    let geared = inertias.map(|inertia| if inertia > 0.0 { 1.0 } else { 0.0 });
    plan.bodies.extend(inertias.map(|inertia| PlannedBody {
        body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2: if inertia > 0.0 { inertia } else { 1.0 } },
        origin_m: [0.0; 2],
        angle_rad: 0.0,
        velocity_m_s: [0.0; 2],
        rate_rad_s: 0.0,
        shape: None,
    }));
    let rates = [right, left].map(|body| plan.bodies[body].rate_rad_s);
    plan.bodies[first].rate_rad_s = geared[0] * 0.5 * (rates[0] - rates[1]);
    plan.bodies[first + 1].rate_rad_s = geared[1] * 0.5 * (rates[0] + rates[1]);
    let mut wheels = vec![
        (first, [1.0, 0.0]),
        (first + 1, [0.0, 1.0]),
        (right, [-0.5 * geared[0], -0.5 * geared[1]]),
        (left, [0.5 * geared[0], -0.5 * geared[1]]),
    ];
    // The palm's own turning cancels in the mean of both closing angles, and counts in what wheels turn against it.
    wheels.extend(palm.map(|palm| (palm, [-geared[0], 0.0])));
    plan.gears.push(PlannedGear { wheels });
}

/// Torque of the brakes on the driven link of a finger, N·m, counted as closing it; `torque` is that of a hold.
pub fn brake_torque(plan: &Plan, side: Side, torque: impl Fn(usize) -> f64) -> f64 {
    let driven = base(side) + L11;
    let part = |hold: &PlannedHold| {
        let on = std::iter::once(hold.on).chain(hold.against).find(|(body, _)| *body == driven);
        on.map_or(0.0, |(_, part)| side.mirror() * part)
    };
    plan.holds.iter().enumerate().map(|(index, hold)| part(hold) * torque(index)).sum()
}

/// The index among the stops and contacts of a gripper's plan of a place; `None` where the scene has no such place.
pub fn index_of_place(plan: &Plan, place: Place) -> Option<usize> {
    let (stops, contacts) = (&plan.stops, &plan.contacts);
    let is_contact =
        |found: &dyn Fn(&PlannedContact) -> bool| contacts.iter().position(found).map(|index| stops.len() + index);
    match place {
        Place::Finger(side, Site::Limit) => {
            stops.iter().position(|stop| (base(side)..base(side) + LINKS).contains(&stop.on))
        }
        Place::Finger(side, site) => {
            let body = base(side) + if site == Site::Proximal { super::L21 } else { super::L22 };
            is_contact(&|contact| contact.body == body)
        }
        Place::Palm | Place::Table => is_contact(&|contact| {
            let is_palm = match contact.against {
                Against::Body(body) => body == PALM,
                Against::Fixed(index) => plan.fixed[index].direction == [1.0, 0.0],
            };
            contact.body == OBJECT && is_palm == (place == Place::Palm)
        }),
    }
}
