//! How the palm moves.

use super::super::check::Checker;
use super::super::table::keys::Keys;
use super::super::table::motion::{MoveKeys, PathKeys, VibrationKeys};
use super::super::table::{Table, read};
use super::super::{PalmMotion, Path};

/// `None` where nothing moves it; what is wrong is noted, as that the object `is_fixed`.
pub fn palm_motion(c: &mut Checker<'_>, raw: &Keys<'_>, is_fixed: bool) -> Option<PalmMotion> {
    let mut motion = PalmMotion::default();
    for (name, keys) in raw.inner("moves").named() {
        let path = format!("moves.{name}");
        let said = read(c, &path, &keys, MoveKeys::usual());
        judge_time(c, &path, &keys, &said);
        motion.moves.extend(said.moves());
        motion.names[0].resize(motion.moves.len(), name.to_string());
    }
    for (name, keys) in raw.inner("vibrations").named() {
        let path = format!("vibrations.{name}");
        motion.vibrations.extend(read(c, &path, &keys, VibrationKeys::usual()).vibrations());
        motion.names[1].resize(motion.vibrations.len(), name.to_string());
    }
    let said = raw.inner("path");
    motion.path = said.is_given().then(|| path(c, &said)).flatten();
    if motion == PalmMotion::default() {
        return None;
    }
    if is_fixed {
        let places = ["moves", "vibrations", "path"].map(|section| raw.span(section));
        c.push(
            places.into_iter().flatten().next(),
            "the palm moves, but the object is fixed in the world: the gripper would leave it, or be torn",
            "nothing to carry",
            "let the object move: object.motion = \"free\", or leave the motion out",
        );
    }
    Some(motion)
}

/// Either of time and acceleration says how long a move takes.
fn judge_time(c: &mut Checker<'_>, path: &str, keys: &Keys<'_>, said: &MoveKeys) {
    let (key, place) = (format!("{path}.acceleration"), keys.span("acceleration"));
    if keys.has("time") {
        c.unused_at(&key, place, "beside `time`");
    } else if place.is_none() {
        let help = "add how long it takes, or its largest acceleration: time = \"40 ms\" or acceleration = \"2 g\"";
        c.lacks(&format!("{path}.time"), keys.span.clone(), help);
    } else if said.way_m() == 0.0 {
        c.unused_at(&key, place, "without a way along x or y: give `time` instead");
    }
}

fn path(c: &mut Checker<'_>, raw: &Keys<'_>) -> Option<Path> {
    let keys = read(c, "path", raw, PathKeys::usual());
    let times = &keys.times_s;
    let ordered = times.iter().all(|time| *time >= 0.0) && times.windows(2).all(|pair| pair[0] < pair[1]);
    if times.len() < 2 || !ordered {
        c.push(
            raw.span("times").or(raw.span.clone()),
            "`path.times` must be two times or more from 0 on, each later than the one before",
            "no such times",
            "write times = [\"0 ms\", \"50 ms\", \"100 ms\"]",
        );
        return None;
    }
    let mut whole = true;
    for (key, values) in ["x", "y", "angle"].into_iter().zip(&keys.coordinates) {
        if !values.is_empty() && values.len() != times.len() {
            whole = false;
            let (count, wanted) = (values.len(), times.len());
            c.push(
                raw.span(key),
                format!("`path.{key}` has {count} values, but there are {wanted} times"),
                "not one for each time",
                "give one value for each time, or leave it out: it stays 0 then",
            );
        }
        if values.first().is_some_and(|first| *first != 0.0) {
            whole = false;
            c.push(
                raw.span(key),
                format!("`path.{key}` does not begin at 0, where the palm is when the scene begins"),
                "starts elsewhere",
                "count all its values from the first one",
            );
        }
    }
    whole.then(|| keys.path()).flatten()
}
