//! What drives the finger: motor and spring.

use super::super::check::{Checker, POSITIVE};
use super::super::entry::item_span;
use super::super::kinds::{Choice, List, Time, Torque};
use super::super::table::drive::{Motor, Shaft, Springs};
use super::super::table::keys::Keys;
use super::super::table::{Table, read};
use super::super::{self as scene, Actuation, Spring, SpringKind};
use super::sizing::Sized;

const TORQUE: &str = "add the motor's torque on l11: [motor] torque = \"480 N*mm\"";

/// The motor, with the torque of the scene's sizing if it is [`Sized::By`] one.
pub fn motor(c: &mut Checker<'_>, raw: &Keys<'_>, sized: Sized) -> Option<scene::Motor> {
    let actuation = actuation(c, raw, sized)?;
    let shaft = read(c, "motor", raw, Shaft::usual());
    if let Some(brake) = shaft.brake
        && shaft.release_s().is_some_and(|release_s| release_s < brake.start_s + brake.rise_s)
    {
        c.push(
            raw.span("brake_release"),
            "`motor.brake_release` is before the brake has gripped, at brake_at + brake_rise",
            "too early",
            "release it later, or leave it out: it holds for good then",
        );
    }
    Some(shaft.with(actuation))
}

/// Its torque over time.
fn actuation(c: &mut Checker<'_>, raw: &Keys<'_>, sized: Sized) -> Option<Actuation> {
    let mut motor = read(c, "motor", raw, Motor::usual());
    // An unknown profile says nothing about the other keys.
    raw.is_known::<Choice<Actuation>>("profile").then_some(())?;
    if let Actuation::Table { interpolation, .. } = motor.actuation {
        return Some(Actuation::Table { points: table(c, raw)?, interpolation });
    }
    match sized {
        Sized::Not if !raw.has("torque") => c.lacks("motor.torque", raw.span.clone(), TORQUE),
        Sized::Not | Sized::Wrong => {}
        Sized::By(sizing) => motor.torque_n_m().into_iter().for_each(|torque| *torque = sizing.motor_n_m),
    }
    Some(motor.actuation)
}

/// The points of a table.
fn table(c: &mut Checker<'_>, raw: &Keys<'_>) -> Option<Vec<(f64, f64)>> {
    for key in ["times", "torques"] {
        if !raw.has(key) {
            let help = "a table has both: times = [\"0 ms\", \"5 ms\"] and torques = [\"0 N*mm\", \"480 N*mm\"]";
            c.lacks(&format!("motor.{key}"), raw.span.clone(), help);
        }
    }
    let (times, torques) = (raw.value::<List<Time>>("times")?, raw.value::<List<Torque>>("torques")?);
    if times.is_empty() {
        c.push(raw.span("times"), "the table of the motor is empty", "no times", "give at least one time and torque");
        return None;
    }
    if times.len() != torques.len() {
        let message = format!("the table of the motor has {} times, but {} torques", times.len(), torques.len());
        c.push(raw.span("torques"), message, "another count", "give one torque for each time");
        return None;
    }
    if let Some(i) = (1..times.len()).find(|&i| times[i] <= times[i - 1]) {
        let message = format!("the times of the motor's table do not increase: value {} is not after value {i}", i + 1);
        let place = raw.get("times").map(|times| item_span(times, i));
        c.push(place, message, "must be later than the time before", "put the times in increasing order, each once");
        return None;
    }
    Some(times.into_iter().zip(torques).collect())
}

/// The spring: `Some(None)` where the scene has none, `None` where it is wrong.
pub fn spring(c: &mut Checker<'_>, raw: &Keys<'_>, sized: Sized) -> Option<Option<Spring>> {
    let before = c.count();
    let mut spring = read(c, "spring", raw, Springs::usual());
    let sound = c.count() == before;
    raw.is_known::<Choice<Option<SpringKind>>>("type").then_some(())?;
    match (&mut spring.kind, sized) {
        (None, _) => {}
        (Some(SpringKind::Constant { .. }), Sized::Not) if !raw.has("torque") => {
            let help =
                "add the spring's torque: [spring] torque = \"132.6 N*mm\"; or leave it out: [spring] type = \"none\"";
            c.lacks("spring.torque", raw.span.clone(), help);
        }
        (Some(SpringKind::Torsional { .. }), Sized::Not) if !raw.has("stiffness") => {
            c.lacks("spring.stiffness", raw.span.clone(), "add the spring's stiffness: stiffness = \"100 N*mm/rad\"");
        }
        (Some(_), Sized::Not) => {}
        (Some(SpringKind::Constant { torque_n_m }), Sized::Wrong | Sized::By(_)) => {
            *torque_n_m = sized.sizing()?.spring_n_m;
        }
        // c_s q_p = k_s (2.30): the same torque where the finger is straight.
        (Some(SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad }), Sized::Wrong | Sized::By(_)) => {
            if !raw.has("preload") {
                let help = "the sizing says the torque of the straight finger, its preload the stiffness: preload = \"90 deg\"";
                c.lacks("spring.preload", raw.span.clone(), help);
            } else if sound && *preload_rad == 0.0 {
                c.beyond("spring.preload", raw.span("preload"), POSITIVE);
            }
            *stiffness_n_m_per_rad = sized.sizing()?.spring_n_m / *preload_rad;
        }
    }
    Some(spring.spring())
}
