//! The plan of a scene of discs: a body for every disc that moves, a fixed surface for every one that does not.

use super::plan::{Against, Course, Meet, Plan, PlannedBody, PlannedContact, PlannedDrive, PlannedFixed, Shape};
use crate::gripper::Body;
use crate::scene::{BodiesScene, DiscMotion, Partner};

/// The plan of a scene of discs. Contacts are in the order of [`BodiesScene::pairs`]; bodies in that of the discs that move.
pub fn plan_discs(scene: &BodiesScene) -> Plan {
    let mut plan = Plan { gravity_m_s2: scene.gravity_m_s2, ..Plan::default() };
    let places: Vec<Against> = scene
        .discs
        .iter()
        .map(|disc| {
            let shape = Shape::Disc { radius_m: disc.radius_m };
            let (mass_kg, inertia_kg_m2, velocity_m_s, rate_rad_s) = match disc.motion {
                DiscMotion::Fixed => {
                    plan.fixed.push(PlannedFixed { shape, origin_m: disc.centre_m, direction: [1.0, 0.0] });
                    return Against::Fixed(plan.fixed.len() - 1);
                }
                DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
                    let course = Course::Even { acceleration_m_s2 };
                    plan.drives.push(PlannedDrive { body: plan.bodies.len(), course });
                    (0.0, 0.0, velocity_m_s, spin_rad_s)
                }
                DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
                    (mass_kg, inertia_kg_m2.unwrap_or(0.0), velocity_m_s, spin_rad_s)
                }
            };
            plan.bodies.push(PlannedBody {
                body: Body { mass_kg, com_m: [0.0; 2], inertia_kg_m2 },
                origin_m: disc.centre_m,
                angle_rad: 0.0,
                velocity_m_s,
                rate_rad_s,
                shape: Some(shape),
            });
            Against::Body(plan.bodies.len() - 1)
        })
        .collect();
    let ground = plan.fixed.len();
    if let Some(half_plane) = scene.half_plane {
        plan.fixed.push(PlannedFixed {
            shape: Shape::HalfPlane,
            origin_m: [0.0, half_plane.level_m],
            direction: [1.0, 0.0],
        });
    }
    for pair in scene.pairs() {
        let against = match pair.partner {
            Partner::Disc(index) => places[index],
            Partner::HalfPlane => Against::Fixed(ground),
        };
        // The first disc of a pair moves.
        if let Against::Body(body) = places[pair.disc] {
            plan.contacts.push(PlannedContact { body, against, meet: Meet::Each, law: scene.contact });
        }
    }
    plan
}
