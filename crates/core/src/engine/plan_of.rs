//! The plan of what is simulated: links of all fingers, discs, palm and table.

use super::differential::{add_differential, add_rotor, planned};
use super::finger::{L11, LINKS, Mount, Reach, add, base};
use super::plan::{
    Against, Course, Meet, Plan, PlannedBody, PlannedContact, PlannedDrive, PlannedFixed, PlannedHold, Shape,
};
use crate::gripper::Body;
use crate::numeric::elementary::sin_cos;
use crate::scene::{Disc, DiscMotion, DrivenFinger, PalmMotion, Side, System, Touching};

/// The plan of a system, or the finger whose angles do not close its loop.
///
/// Bodies are the links of the fingers, the discs that move in their order, the palm where it moves, and the wheels of a differential.
pub fn plan(system: &System) -> Result<Plan, Side> {
    let mut plan = Plan { gravity_m_s2: system.gravity_m_s2, ..Plan::default() };
    let surfaces = surfaces(&mut plan, system);
    let first_moving = LINKS * system.fingers.len();
    let moving = system.discs.iter().filter(|disc| disc.motion.moves());
    let palm = system.palm_motion.as_ref().map(|motion| (first_moving + moving.clone().count(), motion));
    // The material points of a finger on what does not move and of discs are each surface's own, as in the thesis; of what fingers can
    // push away both models count them on what is not the disc.
    let meet = if system.fingers.len() == 1 && moving.clone().count() == 0 { Meet::Each } else { Meet::Body };
    let touching = system.touching();
    for (side, finger) in system.sided() {
        let mirror = side.mirror();
        let on = palm.map(|(body, _)| body);
        let mount = Mount { on, ground_m: [mirror * 0.5 * system.palm_width_m, 0.0], mirror };
        add(&mut plan, finger, Reach { discs: &surfaces, meet }, mount).ok_or(side)?;
        places_of(&mut plan, side, &touching, (surfaces.len(), finger.limit.is_some()));
        drive(&mut plan, side, finger, on);
    }
    moving.for_each(|disc| add_disc(&mut plan, disc));
    if let Some((body, motion)) = palm {
        add_palm(&mut plan, body, motion, system.palm.is_some());
    }
    add_pairs(&mut plan, system, (&touching, &surfaces), palm.map(|(body, _)| body));
    if let Some(differential) = &system.differential {
        add_differential(&mut plan, differential);
    }
    Ok(plan)
}

/// Surfaces of all discs; those that do not move are put in the plan, the others will be.
fn surfaces(plan: &mut Plan, system: &System) -> Vec<Against> {
    let mut next = LINKS * system.fingers.len();
    let surface = |disc: &Disc| match disc.motion {
        DiscMotion::Fixed => {
            let (shape, (sin, cos)) = (Shape::Disc(disc.shape), sin_cos(disc.angle_rad));
            plan.fixed.push(PlannedFixed { shape, origin_m: disc.centre_m, direction: [cos, sin] });
            Against::Fixed(plan.fixed.len() - 1)
        }
        DiscMotion::Driven { .. } | DiscMotion::Free { .. } => {
            next += 1;
            Against::Body(next - 1)
        }
    };
    system.discs.iter().map(surface).collect()
}

/// Which contacts of a sample the stop and the contacts are that a finger has just got.
fn places_of(plan: &mut Plan, side: Side, touching: &[Touching], (discs, stops): (usize, bool)) {
    for (index, touching) in touching.iter().enumerate() {
        match touching {
            Touching::Stop(of) if *of == side && stops => plan.stop_places.push(index),
            Touching::Phalanx(of, _, disc) if *of == side && *disc < discs => plan.contact_places.push(index),
            _ => {}
        }
    }
}

/// The motor of a finger, its rotor and its brake.
fn drive(plan: &mut Plan, side: Side, finger: &DrivenFinger, palm: Option<usize>) {
    let (motor, driven, mirror) = (&finger.motor, base(side) + L11, side.mirror());
    // The rotor turns with the link, about a joint that stays where it is in the palm.
    plan.bodies[driven].body.inertia_kg_m2 += motor.inertia_kg_m2;
    add_rotor(plan, driven, motor.inertia_kg_m2);
    let against = palm.map(|palm| (palm, -mirror));
    plan.motors.push(planned(motor, std::iter::once((driven, mirror)).chain(against).collect()));
    plan.holds.extend(motor.brake.map(|brake| PlannedHold { on: (driven, mirror), against, brake }));
}

fn add_disc(plan: &mut Plan, disc: &Disc) {
    let (mass_kg, inertia_kg_m2, velocity_m_s, rate_rad_s) = match disc.motion {
        DiscMotion::Fixed => return,
        DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
            plan.drives.push(PlannedDrive { body: plan.bodies.len(), course: Course::Even { acceleration_m_s2 } });
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

fn add_palm(plan: &mut Plan, body: usize, motion: &PalmMotion, is_solid: bool) {
    plan.drives.push(PlannedDrive { body, course: Course::Palm(motion.clone()) });
    plan.bodies.push(PlannedBody {
        body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2: 0.0 },
        origin_m: [0.0; 2],
        angle_rad: 0.0,
        velocity_m_s: [0.0; 2],
        rate_rad_s: 0.0,
        shape: is_solid.then_some(Shape::HalfPlane),
    });
}

/// Contacts of discs with one another, with palm or ground, and with a table.
fn add_pairs(plan: &mut Plan, system: &System, (touching, surfaces): (&[Touching], &[Against]), palm: Option<usize>) {
    if !system.discs.iter().any(|disc| disc.motion.moves()) {
        return;
    }
    let mut half_plane = |level_m: f64, side: f64| {
        plan.fixed.push(PlannedFixed { shape: Shape::HalfPlane, origin_m: [0.0, level_m], direction: [side, 0.0] });
        Against::Fixed(plan.fixed.len() - 1)
    };
    let below = system.palm.and_then(|of| Some((of.contact?, of.level_m)));
    let below = below.map(|(law, level_m)| (law, palm.map_or_else(|| half_plane(level_m, 1.0), Against::Body)));
    let above = system.table.and_then(|of| Some((of.contact?, half_plane(of.level_m, -1.0))));
    let on_plane = if system.fingers.is_empty() { Meet::Each } else { Meet::Other };
    for (place, touching) in touching.iter().enumerate() {
        let (disc, meet, other) = match *touching {
            Touching::Discs(disc, other) => (disc, Meet::Each, system.between_discs.zip(surfaces.get(other).copied())),
            Touching::Palm(disc) => (disc, on_plane, below),
            Touching::Table(disc) => (disc, on_plane, above),
            Touching::Phalanx(..) | Touching::Stop(_) => continue,
        };
        // The first disc of a pair moves.
        if let (Some(&Against::Body(body)), Some((law, against))) = (surfaces.get(disc), other) {
            plan.contacts.push(PlannedContact { body, against, meet, law });
            plan.contact_places.push(place);
        }
    }
}
