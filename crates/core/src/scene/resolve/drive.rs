//! What drives the finger: motor and spring.

use super::super::check::{ANY, Checker, NOT_NEGATIVE, POSITIVE};
use super::super::raw::{RawMotor, RawScene, RawSpring};
use super::super::words::{MotorProfile, SpringType};
use super::super::{Actuation, Interpolation, Placement, Spring, SpringKind};
use super::sizing::Sized;

const TORQUE: &str = "add the motor's torque on l11: [motor] torque = \"480 N*mm\"";

/// Motor torque over time, with the torque of the scene's sizing if it is [`Sized::By`] one.
pub fn motor(c: &mut Checker<'_>, raw: &RawScene, sized: Sized) -> Option<Actuation> {
    let motor = &raw.motor;
    // An unknown profile says nothing about the other keys.
    let profile = match motor.profile.is_given() {
        true => c.get("motor.profile", &motor.profile)?,
        false => MotorProfile::Constant,
    };
    refuse_unused(c, motor, profile);
    if profile == MotorProfile::Table {
        return table(c, raw);
    }
    let torque_n_m = match sized {
        Sized::Not => c.required("motor.torque", &motor.torque, ANY, motor, TORQUE),
        Sized::Wrong => None,
        Sized::By(sizing) => Some(sizing.motor_n_m),
    };
    match profile {
        MotorProfile::Constant | MotorProfile::Table => Some(Actuation::Constant { torque_n_m: torque_n_m? }),
        MotorProfile::Ramp => {
            let rise =
                c.required("motor.rise", &motor.rise, POSITIVE, motor, "add the time of the rise: rise = \"2 ms\"");
            Some(Actuation::Ramp { torque_n_m: torque_n_m?, rise_s: rise? })
        }
        MotorProfile::HalfSine => {
            let help = "add the length of the pulse: pulse = \"10 ms\"";
            let pulse = c.required("motor.pulse", &motor.pulse, POSITIVE, motor, help);
            Some(Actuation::HalfSine { torque_n_m: torque_n_m?, length_s: pulse? })
        }
        MotorProfile::Reversal => {
            let help = "add when the torque changes sign: reverse_at = \"10 ms\"";
            let at = c.required("motor.reverse_at", &motor.reverse_at, NOT_NEGATIVE, motor, help);
            Some(Actuation::Reversal { torque_n_m: torque_n_m?, at_s: at? })
        }
    }
}

fn refuse_unused(c: &mut Checker<'_>, motor: &RawMotor, profile: MotorProfile) {
    if profile != MotorProfile::Ramp {
        c.unused("motor.rise", &motor.rise, "without profile = \"ramp\"");
    }
    if profile != MotorProfile::HalfSine {
        c.unused("motor.pulse", &motor.pulse, "without profile = \"half-sine\"");
    }
    if profile != MotorProfile::Reversal {
        c.unused("motor.reverse_at", &motor.reverse_at, "without profile = \"reversal\"");
    }
    if profile == MotorProfile::Table {
        c.unused("motor.torque", &motor.torque, "with profile = \"table\"");
    } else {
        c.unused("motor.times", &motor.times, "without profile = \"table\"");
        c.unused("motor.torques", &motor.torques, "without profile = \"table\"");
        c.unused("motor.interpolation", &motor.interpolation, "without profile = \"table\"");
    }
}

fn table(c: &mut Checker<'_>, raw: &RawScene) -> Option<Actuation> {
    let motor = &raw.motor;
    let interpolation = c.or("motor.interpolation", &motor.interpolation, Interpolation::Linear);
    for (key, given) in [("motor.times", motor.times.is_given()), ("motor.torques", motor.torques.is_given())] {
        if !given {
            let help = "a table has both: times = [\"0 ms\", \"5 ms\"] and torques = [\"0 N*mm\", \"480 N*mm\"]";
            c.missing(key, motor, help);
        }
    }
    let (times, torques) = (c.get("motor.times", &motor.times), c.get("motor.torques", &motor.torques));
    let (times, torques) = (times?, torques?);
    if times.is_empty() {
        c.push(motor.times.span(), "the table of the motor is empty", "no times", "give at least one time and torque");
        return None;
    }
    if times.len() != torques.len() {
        let message = format!("the table of the motor has {} times, but {} torques", times.len(), torques.len());
        c.push(motor.torques.span(), message, "another count", "give one torque for each time");
        return None;
    }
    if let Some(i) = (1..times.len()).find(|&i| times[i] <= times[i - 1]) {
        let message = format!("the times of the motor's table do not increase: value {} is not after value {i}", i + 1);
        let place = motor.times.item_span(i);
        c.push(place, message, "must be later than the time before", "put the times in increasing order, each once");
        return None;
    }
    Some(Actuation::Table { points: times.into_iter().zip(torques).collect(), interpolation })
}

/// The spring: `Some(None)` where the scene has none, `None` where it is wrong.
pub fn spring(c: &mut Checker<'_>, raw: &RawScene, sized: Sized) -> Option<Option<Spring>> {
    let spring = &raw.spring;
    let kind = match spring.kind.is_given() {
        true => c.get("spring.type", &spring.kind)?,
        false => SpringType::Constant,
    };
    let placement = c.or("spring.placement", &spring.placement, Placement::Phalanges);
    refuse_unused_spring(c, spring, kind);
    let kind = match kind {
        SpringType::None => return Some(None),
        SpringType::Constant => {
            let help =
                "add the spring's torque: [spring] torque = \"132.6 N*mm\"; or leave it out: [spring] type = \"none\"";
            let torque = match sized {
                Sized::Not => c.required("spring.torque", &spring.torque, NOT_NEGATIVE, spring, help),
                Sized::Wrong => None,
                Sized::By(sizing) => Some(sizing.spring_n_m),
            };
            SpringKind::Constant { torque_n_m: torque? }
        }
        SpringType::Torsional => {
            let help = "add the spring's stiffness: stiffness = \"100 N*mm/rad\"";
            let (preload, stiffness) = match sized {
                Sized::Not => (
                    c.number_or("spring.preload", &spring.preload, NOT_NEGATIVE, 0.0),
                    c.required("spring.stiffness", &spring.stiffness, POSITIVE, spring, help),
                ),
                // c_s q_p = k_s (2.30): the same torque where the finger is straight.
                Sized::Wrong | Sized::By(_) => {
                    let help = "the sizing says the torque of the straight finger, its preload the stiffness: preload = \"90 deg\"";
                    let preload = c.required("spring.preload", &spring.preload, POSITIVE, spring, help)?;
                    (preload, sized.sizing().map(|sizing| sizing.spring_n_m / preload))
                }
            };
            SpringKind::Torsional { stiffness_n_m_per_rad: stiffness?, preload_rad: preload }
        }
    };
    Some(Some(Spring { kind, placement }))
}

fn refuse_unused_spring(c: &mut Checker<'_>, spring: &RawSpring, kind: SpringType) {
    if kind != SpringType::Constant {
        c.unused("spring.torque", &spring.torque, "without type = \"constant\"");
    }
    if kind != SpringType::Torsional {
        c.unused("spring.stiffness", &spring.stiffness, "without type = \"torsional\"");
        c.unused("spring.preload", &spring.preload, "without type = \"torsional\"");
    }
    if kind == SpringType::None {
        c.unused("spring.placement", &spring.placement, "with type = \"none\"");
    }
}
