//! A scene of a gripper.

use std::ops::Range;

use super::super::check::Checker;
use super::super::entry::Section;
use super::super::error::Problem;
use super::super::raw_gripper::{RawFinger, RawGripper};
use super::super::table::drive::BoughtMotor;
use super::super::table::gripper::{Grasped, GraspedMotion, Seesaw, Support};
use super::super::table::keys::Keys;
use super::super::table::top::{FingerKeys, GripperKeys};
use super::super::table::{Table, read};
use super::super::words::SceneKind;
use super::super::{
    Actuation, Construction, Differential, DrivenFinger, Engine, HalfPlane, Integrator, Motor, Scene, Side, System,
    defaults,
};
use super::finger::Plan;
use super::sizing::Sized;
use super::{contact, drive, finger, heading, motion, run, sizing, start};
use crate::gripper::{Circle, Finger, Lengths};
use crate::numeric::elementary::hypot;
use crate::units::{Dimension, format};

/// Deepest overlap of the object with palm or table that a scene may start with.
const MAX_PENETRATION_M: f64 = 1e-3;

/// Resolves a scene of a gripper, of which `fingers` are right and left; `file_name` gives its default name.
pub fn gripper(
    raw: &RawGripper,
    fingers: &[RawFinger; 2],
    mut c: Checker<'_>,
    file_name: &str,
) -> Result<Scene, Vec<Problem>> {
    let keys = read(&mut c, "", &raw.keys, GripperKeys::usual());
    let (name, duration) = heading(&mut c, &raw.keys, &keys.heading, file_name);
    let (gravity_m_s2, palm) = (keys.heading.gravity_m_s2, keys.palm);
    let object = object(&mut c, &raw.object);
    let finger_keys = fingers.each_ref().map(|finger| read(&mut c, "", &finger.raw.keys, FingerKeys::usual()));
    let plans = Side::BOTH
        .map(|side| finger::plan(&mut c, &fingers[side as usize].raw, &finger_keys[side as usize], object.radius_m));
    let palm_width = palm_width(&mut c, raw, &keys, &plans);
    let table = raw.table.is_given().then(|| read(&mut c, "table", &raw.table, Support::usual()));
    let table = table.filter(|table| table.present);
    let [_, height] = object.centre_m;
    let level_m = table.map(|table| if table.level_m.is_nan() { height + object.radius_m } else { table.level_m });
    let before = c.count();
    judge_object(&mut c, raw, object, palm, level_m);
    let mut room = palm_width.and_then(|palm_width_m| room(&mut c, raw, &keys, object, palm_width_m));
    room = room.filter(|_| c.count() == before);

    let seesaw = raw.differential.is_given().then(|| read(&mut c, "differential", &raw.differential, Seesaw::usual()));
    let seesaw = seesaw.filter(|seesaw| seesaw.present);
    let mut sized = [Sized::Not; 2];
    let span = raw.object.span("offset").or(raw.keys.span("palm_width")).or(raw.object.span.clone());
    let resolved = Side::BOTH.map(|side| {
        let (raw, plan) = (&fingers[side as usize], &plans[side as usize]);
        let keys = &finger_keys[side as usize];
        let place = Place { side, keys, gravity_m_s2, seesaw, object, span: span.clone() };
        let (sizing, finger) = resolve_finger(&mut c, raw, plan, place, &mut room);
        sized[side as usize] = sizing;
        finger
    });
    let differential = match seesaw {
        Some(seesaw) => input(&mut c, raw, fingers, seesaw, sized).map(Some),
        None => Some(None),
    };

    let palm_motion = motion::palm_motion(&mut c, raw, object);
    let planes = contact::planes(&mut c, &raw.contact, [palm, table.is_some()], object.radius_m);
    let integrator = read(&mut c, "integrator", &raw.integrator, Integrator::everyday(SceneKind::Gripper));
    let mu_static = resolved[0].as_ref().map(|finger| finger.contact.mu_static()[0]);
    let engine = run::engine(&mut c, &raw.engine, mu_static);
    refuse_joints(&mut c, &raw.engine, engine);
    let bounds = run::bounds(&mut c, &raw.validate, duration);
    let log = run::log(&mut c, &raw.log, duration);

    let [right, left] = resolved;
    match (right.zip(left), palm_width, differential, planes, duration) {
        (Some((right, left)), Some(palm_width_m), Some(differential), Some([palm, on_table]), Some(duration_s))
            if c.is_clean() =>
        {
            Ok(Scene {
                name,
                description: keys.heading.description,
                source: c.text.to_string(),
                system: System {
                    fingers: vec![right, left],
                    palm_width_m,
                    differential,
                    discs: vec![object.disc()],
                    between_discs: None,
                    palm: palm.map(|law| HalfPlane { level_m: 0.0, contact: Some(law) }),
                    table: level_m.zip(on_table).map(|(level_m, law)| HalfPlane { level_m, contact: Some(law) }),
                    palm_motion,
                    gravity_m_s2,
                },
                duration_s,
                integrator,
                engine,
                bounds,
                log,
            })
        }
        _ => Err(c.into_problems()),
    }
}

/// The object with what follows from its radius.
fn object(c: &mut Checker<'_>, raw: &Section<Keys<Grasped>>) -> Grasped {
    let mut object = read(c, "object", raw, Grasped::usual());
    let radius_m = object.radius_m;
    if object.centre_m[1].is_nan() {
        object.centre_m[1] = radius_m;
    }
    if let GraspedMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut object.motion {
        if mass_kg.is_nan() {
            *mass_kg = defaults::DENSITY_KG_M3 * std::f64::consts::PI * radius_m * radius_m * defaults::DEPTH_M;
        }
        if inertia_kg_m2.is_nan() {
            *inertia_kg_m2 = *mass_kg * radius_m * radius_m / 2.0;
        }
    }
    object
}

/// Given, or twice the base that both fingers are made for.
fn palm_width(c: &mut Checker<'_>, raw: &RawGripper, keys: &GripperKeys, plans: &[Plan; 2]) -> Option<f64> {
    if raw.keys.has("palm_width") {
        return Some(keys.palm_width_m).filter(|width_m| !width_m.is_nan());
    }
    let [right, left] = plans.each_ref().map(|plan| plan.base_m);
    let by_lengths = plans.iter().any(|plan| plan.lengths.is_some() && plan.base_m.is_none());
    let whole: Section<()> = Section::default();
    if by_lengths {
        c.missing("palm_width", &whole, "a finger given by [lengths] has no base that says it: palm_width = \"31 mm\"");
    } else if right.is_some() && left.is_some() && right != left {
        c.missing(
            "palm_width",
            &whole,
            "the fingers are made for different bases, so none says it: palm_width = \"31 mm\"",
        );
    }
    right.filter(|_| right == left).map(|base_m| 2.0 * base_m)
}

/// Where the object may be that fingers are sized and opened for.
#[derive(Clone, Copy)]
struct Room {
    half_palm_m: f64,
    error_m: f64,
}

/// The palm's width and the positioning error, which must be no less than the object's.
fn room(c: &mut Checker<'_>, raw: &RawGripper, keys: &GripperKeys, object: Grasped, palm_width_m: f64) -> Option<Room> {
    let offset = object.centre_m[0];
    let error_m = if raw.keys.has("positioning_error") { keys.positioning_error_m } else { offset.abs() };
    if error_m.is_nan() {
        return None;
    }
    let room = Room { half_palm_m: 0.5 * palm_width_m, error_m };
    if offset.abs() <= error_m {
        return Some(room);
    }
    let [error, offset] = [error_m, offset.abs()].map(|value| format(value, Dimension::Length));
    c.push(
        raw.keys.span("positioning_error"),
        format!("`positioning_error` is {error}, but the object is {offset} off the middle of the palm"),
        "the object is further off",
        "raise it, bring `object.offset` nearer to 0, or leave it out: it is the object's own then",
    );
    None
}

/// What a finger stands in.
struct Place<'a> {
    side: Side,
    keys: &'a FingerKeys,
    gravity_m_s2: [f64; 2],
    seesaw: Option<Seesaw>,
    object: Grasped,
    /// What says where the object is.
    span: Option<Range<usize>>,
}

/// One finger, and what its motor and spring were sized to.
fn resolve_finger(
    c: &mut Checker<'_>,
    RawFinger { raw, .. }: &RawFinger,
    plan: &Plan,
    Place { side, keys, gravity_m_s2: [x, y], seesaw, object, span: place }: Place<'_>,
    room: &mut Option<Room>,
) -> (Sized, Option<DrivenFinger>) {
    let finger = finger::finger(c, raw, plan);
    let radius_m = object.radius_m;
    let seen = room.map(|room| room.seen(side, object));
    let clear = |(seen, lengths): &(Seen, Lengths)| is_clear(c, place, side, seen, lengths.half_width_m);
    let seen = seen.zip(plan.lengths).filter(clear).map(|(seen, _)| seen);
    if plan.lengths.is_some() && seen.is_none() {
        // The other finger would say the same again.
        *room = None;
    }
    let sized = match (finger.as_ref(), seen) {
        (Some(finger), Some(seen)) => ends_sized(c, raw, keys, finger, seen.ends, [side.mirror() * x, y]),
        _ => sizing::sizing(c, raw, keys, None, [x, y]),
    };
    let motor = match seesaw {
        Some(_) => Some(Motor::NONE),
        None => drive::motor(c, &raw.motor, sized).map(|actuation| bought(c, "motor", &raw.motor.recast(), actuation)),
    };
    let spring = drive::spring(c, &raw.spring, sized);
    let limit = contact::limit(c, &raw.limit);
    let contact = contact::contacts(c, &raw.contact, radius_m);
    let sound = finger.zip(seen).map(|(finger, seen)| ((finger, Some(seen.object)), limit));
    let ends = seen.map_or([Circle { radius_m, centre_m: [0.0; 2] }; 2], |seen| seen.ends);
    let initial = start::initial(c, raw, plan, sound, &ends);
    let whole = (finger, motor, spring, contact, initial);
    let (Some(finger), Some(motor), Some(spring), Some(contact), Some(initial)) = whole else { return (sized, None) };
    (sized, Some(DrivenFinger { linkage: finger, motor, spring, limit, contact, initial }))
}

/// The object as one finger sees it, in the finger's own frame.
#[derive(Clone, Copy)]
struct Seen {
    object: Circle,
    /// At either end of the positioning error.
    ends: [Circle; 2],
}

impl Room {
    fn seen(&self, side: Side, object: Grasped) -> Seen {
        let [x, y] = object.centre_m;
        let at = |x: f64| Circle { radius_m: object.radius_m, centre_m: [x - self.half_palm_m, y] };
        Seen { object: at(side.mirror() * x), ends: [at(-self.error_m), at(self.error_m)] }
    }
}

/// Whether the ground joint of a finger is outside of the object grown by half a link's width, wherever that may be.
fn is_clear(c: &mut Checker<'_>, place: Option<Range<usize>>, side: Side, seen: &Seen, half_width_m: f64) -> bool {
    let near = |disc: &Circle| hypot(disc.centre_m[0], disc.centre_m[1]);
    let [one, other] = seen.ends.each_ref().map(near);
    let distance = near(&seen.object).min(one).min(other);
    let reach = seen.object.radius_m + half_width_m;
    if distance >= reach {
        return true;
    }
    let [distance, reach] = [distance, reach].map(|value| format!("{:.3} mm", value * 1e3));
    c.push(
        place,
        format!("the ground joint of the {} finger is {distance} from the object's centre, but must be at least {reach} away: the radius and half a link's width", side.word()),
        "inside the object",
        "widen the palm (`palm_width`), or bring the object nearer to its middle (`object.offset`, `positioning_error`)",
    );
    false
}

/// Motor and spring that do at either end of the positioning error (thesis §4.2.1.3), of which one may be out of the finger's reach: it
/// meets the object only when the other finger has brought it.
fn ends_sized(
    c: &mut Checker<'_>,
    raw: &super::super::raw::RawScene,
    keys: &FingerKeys,
    finger: &Finger,
    ends: [Circle; 2],
    gravity_m_s2: [f64; 2],
) -> Sized {
    let differ = ends[0] != ends[1];
    let tried = ends.map(|disc| {
        let mut aside = c.aside();
        let sized = sizing::sizing(&mut aside, raw, keys, Some((finger, &Some(disc))), gravity_m_s2);
        if differ {
            let base = -disc.centre_m[0] * 1e3;
            let more =
                format!(" where the positioning error brings it, {base:.3} mm from the ground joint along the palm");
            aside.add_to(sizing::NOT_SIZED, &more);
        }
        (sized, aside)
    });
    let reaches = |sized: Sized| matches!(sized, Sized::By(_));
    let reached = tried.iter().filter(|(sized, _)| reaches(*sized)).count();
    let mut all = None;
    for (sized, aside) in tried {
        if reached == 0 || reaches(sized) {
            c.extend(aside.into_problems());
            all = Some(all.map_or(sized, |before: Sized| before.for_both(sized)));
        }
    }
    all.unwrap_or(Sized::Wrong)
}

fn bought(c: &mut Checker<'_>, path: &str, raw: &Section<Keys<BoughtMotor>>, actuation: Actuation) -> Motor {
    let motor = read(c, path, raw, BoughtMotor::usual());
    if let Some(brake) = motor.brake
        && motor.release_s().is_some_and(|release_s| release_s < brake.start_s + brake.rise_s)
    {
        c.push(
            raw.span("brake_release"),
            format!("`{path}.brake_release` is before the brake has gripped, at brake_at + brake_rise"),
            "too early",
            "release it later, or leave it out: it holds for good then",
        );
    }
    motor.with(actuation)
}

/// The motor at the input of the differential.
fn input(
    c: &mut Checker<'_>,
    raw: &RawGripper,
    fingers: &[RawFinger; 2],
    seesaw: Seesaw,
    [right, left]: [Sized; 2],
) -> Option<Differential> {
    for (side, finger) in Side::BOTH.into_iter().zip(fingers) {
        let why = "with a [differential], whose input is the only motor: give it in [motor]";
        c.unused_at(&format!("{}.motor", side.word()), finger.own_motor.clone(), why);
    }
    let actuation = drive::motor(c, &raw.motor.recast(), right.of_both_motors(left))?;
    let mut motor = bought(c, "motor", &raw.motor, actuation);
    motor.inertia_kg_m2 += seesaw.input_inertia_kg_m2;
    Some(Differential { motor, seesaw_inertia_kg_m2: seesaw.seesaw_inertia_kg_m2 })
}

/// Palm and table must not be inside the object.
fn judge_object(c: &mut Checker<'_>, raw: &RawGripper, object: Grasped, palm: bool, level_m: Option<f64>) {
    let [_, y] = object.centre_m;
    let span = |key: &str| raw.object.span(key).or(raw.object.span.clone());
    let planes: [(&str, f64, Option<Range<usize>>); 2] = [
        ("palm", if palm { object.radius_m - y } else { 0.0 }, span("height")),
        ("table", level_m.map_or(0.0, |level_m| y + object.radius_m - level_m), raw.table.span("level")),
    ];
    for (plane, depth, place) in planes {
        if depth <= MAX_PENETRATION_M {
            continue;
        }
        let message = format!(
            "the object starts {:.3} mm inside the {plane}, but at most {} is allowed",
            depth * 1e3,
            format(MAX_PENETRATION_M, Dimension::Length)
        );
        c.push(place, message, "starts inside", "move the object by `object.height`, or the table by `table.level`");
    }
}

/// The other construction is one of a single finger.
fn refuse_joints(c: &mut Checker<'_>, raw: &Section<Keys<Engine>>, engine: Engine) {
    if engine.construction == Construction::Reduced {
        c.push(
            raw.span("construction"),
            "`engine.construction` is \"reduced\", but joint coordinates are for one finger, not for grippers",
            "one finger only",
            "leave it out: every body moves freely in the engine",
        );
    }
}
