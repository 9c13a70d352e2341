//! Builds the plan of a system: links of all fingers, discs, palm and table.

use super::differential::{add_differential, add_rotor, plan_motor};
use super::finger::{ContactTargets, L11, LINKS, Mount, add_finger, first_link};
use super::plan::{
    ContactPartner, ContactPointConvention, Plan, PlannedBody, PlannedBrake, PlannedContact, PlannedDrive,
    PlannedFixedSurface, PrescribedMotion, Shape,
};
use crate::gripper::Body;
use crate::numeric::elementary::sin_cos;
use crate::scene::{ContactId, Disc, DiscMotion, DrivenFinger, PalmMotion, Side, System};

/// Builds the plan of a system.
///
/// Bodies are the links of the fingers, the moving discs in their order, a moving palm, and the wheels of a
/// differential.
///
/// # Errors
/// Returns the side of a finger whose initial angles do not close its loop.
pub fn build_plan(system: &System) -> Result<Plan, Side> {
    let mut plan = Plan { gravity_m_s2: system.gravity_m_s2, ..Plan::default() };
    let surfaces = disc_surfaces(&mut plan, system);
    let first_moving = LINKS * system.fingers.len();
    let moving = system.discs.iter().filter(|disc| disc.motion.moves());
    let palm = system.palm_motion.as_ref().map(|motion| (first_moving + moving.clone().count(), motion));
    // For a finger on fixed surfaces, and between discs, forces act at each surface's own closest point, as in the
    // thesis. Where fingers can push an object away, both models use the point on the surface that is not the disc's.
    let point_convention = if system.fingers.len() == 1 && moving.clone().count() == 0 {
        ContactPointConvention::EachSurface
    } else {
        ContactPointConvention::BodySurface
    };
    let contact_ids = system.contact_ids();
    for (side, finger) in system.fingers_by_side() {
        let mirror = side.mirror();
        let on = palm.map(|(body, _)| body);
        let mount = Mount { on, ground_m: [mirror * 0.5 * system.palm_width_m, 0.0], mirror };
        add_finger(&mut plan, finger, ContactTargets { discs: &surfaces, point_convention }, mount).ok_or(side)?;
        add_finger_channels(&mut plan, side, &contact_ids, (surfaces.len(), finger.limit.is_some()));
        add_motor(&mut plan, side, finger, on);
    }
    moving.for_each(|disc| add_disc(&mut plan, disc));
    if let Some((body, motion)) = palm {
        add_palm(&mut plan, body, motion, system.palm.is_some());
    }
    add_pairs(&mut plan, system, (&contact_ids, &surfaces), palm.map(|(body, _)| body));
    if let Some(differential) = &system.differential {
        add_differential(&mut plan, differential);
    }
    Ok(plan)
}

/// Returns the surfaces of all discs; adds those of fixed discs to the plan. The bodies of the others are added later.
fn disc_surfaces(plan: &mut Plan, system: &System) -> Vec<ContactPartner> {
    let mut next = LINKS * system.fingers.len();
    let surface = |disc: &Disc| match disc.motion {
        DiscMotion::Fixed => {
            let (shape, (sin, cos)) = (Shape::Disc(disc.shape), sin_cos(disc.angle_rad));
            plan.fixed_surfaces.push(PlannedFixedSurface { shape, origin_m: disc.centre_m, direction: [cos, sin] });
            ContactPartner::Fixed(plan.fixed_surfaces.len() - 1)
        }
        DiscMotion::Driven { .. } | DiscMotion::Free { .. } => {
            next += 1;
            ContactPartner::Body(next - 1)
        }
    };
    system.discs.iter().map(surface).collect()
}

/// Adds the contact channels of the stop and the contacts of a finger.
fn add_finger_channels(plan: &mut Plan, side: Side, contact_ids: &[ContactId], (discs, stops): (usize, bool)) {
    for (channel, id) in contact_ids.iter().enumerate() {
        match id {
            ContactId::Stop(own_side) if *own_side == side && stops => plan.stop_channels.push(channel),
            ContactId::Phalanx(own_side, _, disc) if *own_side == side && *disc < discs => {
                plan.contact_channels.push(channel)
            }
            _ => {}
        }
    }
}

/// Adds motor, rotor and brake of a finger.
fn add_motor(plan: &mut Plan, side: Side, finger: &DrivenFinger, palm: Option<usize>) {
    let (motor, driven, mirror) = (&finger.motor, first_link(side) + L11, side.mirror());
    // The rotor turns with the link, about a joint that is fixed in the palm.
    plan.bodies[driven].body.inertia_kg_m2 += motor.inertia_kg_m2;
    add_rotor(plan, driven, motor.inertia_kg_m2);
    let against = palm.map(|palm| (palm, -mirror));
    plan.motors.push(plan_motor(motor, std::iter::once((driven, mirror)).chain(against).collect()));
    plan.brakes.extend(motor.brake.map(|brake| PlannedBrake { on: (driven, mirror), against, brake }));
}

/// Adds a moving disc.
fn add_disc(plan: &mut Plan, disc: &Disc) {
    let (mass_kg, inertia_kg_m2, velocity_m_s, rate_rad_s) = match disc.motion {
        DiscMotion::Fixed => return,
        DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
            plan.drives.push(PlannedDrive {
                body: plan.bodies.len(),
                motion: PrescribedMotion::ConstantAcceleration { acceleration_m_s2 },
            });
            (0.0, 0.0, velocity_m_s, spin_rad_s)
        }
        DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
            (mass_kg, inertia_kg_m2.unwrap_or(0.0), velocity_m_s, spin_rad_s)
        }
    };
    plan.bodies.push(PlannedBody {
        body: Body { mass_kg, com_m: [0.0; 2], inertia_kg_m2 },
        origin_m: disc.centre_m,
        angle_rad: disc.angle_rad,
        velocity_m_s,
        rate_rad_s,
        shape: Some(Shape::Disc(disc.shape)),
    });
}

/// Adds a moving palm.
fn add_palm(plan: &mut Plan, body: usize, motion: &PalmMotion, is_solid: bool) {
    plan.drives.push(PlannedDrive { body, motion: PrescribedMotion::Palm(motion.clone()) });
    plan.bodies.push(PlannedBody {
        body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2: 0.0 },
        origin_m: [0.0; 2],
        angle_rad: 0.0,
        velocity_m_s: [0.0; 2],
        rate_rad_s: 0.0,
        shape: is_solid.then_some(Shape::HalfPlane),
    });
}

/// Adds the contacts of discs with one another, with palm or ground, and with a table.
fn add_pairs(
    plan: &mut Plan,
    system: &System,
    (contact_ids, surfaces): (&[ContactId], &[ContactPartner]),
    palm: Option<usize>,
) {
    if !system.discs.iter().any(|disc| disc.motion.moves()) {
        return;
    }
    let mut half_plane = |level_m: f64, side: f64| {
        plan.fixed_surfaces.push(PlannedFixedSurface {
            shape: Shape::HalfPlane,
            origin_m: [0.0, level_m],
            direction: [side, 0.0],
        });
        ContactPartner::Fixed(plan.fixed_surfaces.len() - 1)
    };
    let palm_plane = system.palm.and_then(|plane| Some((plane.contact?, plane.level_m)));
    let palm_plane =
        palm_plane.map(|(law, level_m)| (law, palm.map_or_else(|| half_plane(level_m, 1.0), ContactPartner::Body)));
    let table_plane = system.table.and_then(|plane| Some((plane.contact?, half_plane(plane.level_m, -1.0))));
    let on_plane = if system.fingers.is_empty() {
        ContactPointConvention::EachSurface
    } else {
        ContactPointConvention::PartnerSurface
    };
    for (channel, id) in contact_ids.iter().enumerate() {
        let (disc, point_convention, other) = match *id {
            ContactId::Discs(disc, other) => {
                (disc, ContactPointConvention::EachSurface, system.between_discs.zip(surfaces.get(other).copied()))
            }
            ContactId::Palm(disc) => (disc, on_plane, palm_plane),
            ContactId::Table(disc) => (disc, on_plane, table_plane),
            ContactId::Phalanx(..) | ContactId::Stop(_) => continue,
        };
        // The first disc of a pair is a moving one.
        if let (Some(&ContactPartner::Body(body)), Some((law, against))) = (surfaces.get(disc), other) {
            plan.contacts.push(PlannedContact { body, against, point_convention, law });
            plan.contact_channels.push(channel);
        }
    }
}
