//! How the palm of a gripper moves.

use super::super::check::Checker;
use super::super::raw_gripper::RawGripper;
use super::super::table::gripper::{Grasped, GraspedMotion};
use super::super::table::motion::{MoveKeys, PathKeys, VibrationKeys};
use super::super::table::{Table, read};
use super::super::{PalmMotion, Path};

/// `None` where nothing moves it; what is wrong is noted.
pub fn palm_motion(c: &mut Checker<'_>, raw: &RawGripper, object: Grasped) -> Option<PalmMotion> {
    let mut motion = PalmMotion::default();
    for (name, keys) in &raw.moves.0 {
        let path = format!("moves.{}", name.get_ref());
        motion.moves.extend(read(c, &path, keys, MoveKeys::usual()).moves());
    }
    for (name, keys) in &raw.vibrations.0 {
        let path = format!("vibrations.{}", name.get_ref());
        motion.vibrations.extend(read(c, &path, keys, VibrationKeys::usual()).vibrations());
    }
    motion.path = raw.path.is_given().then(|| path(c, raw)).flatten();
    if motion == PalmMotion::default() {
        return None;
    }
    if object.motion == GraspedMotion::Fixed {
        let places = [&raw.moves.span, &raw.vibrations.span, &raw.path.span];
        c.push(
            places.into_iter().flatten().next().cloned(),
            "the palm moves, but the object is fixed in the world: the gripper would leave it, or be torn",
            "nothing to carry",
            "let the object move: object.motion = \"free\", or leave the motion out",
        );
    }
    Some(motion)
}

fn path(c: &mut Checker<'_>, raw: &RawGripper) -> Option<Path> {
    let keys = read(c, "path", &raw.path, PathKeys::usual());
    let times = &keys.times_s;
    let ordered = times.iter().all(|time| *time >= 0.0) && times.windows(2).all(|pair| pair[0] < pair[1]);
    if times.len() < 2 || !ordered {
        c.push(
            raw.path.span("times").or(raw.path.span.clone()),
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
                raw.path.span(key),
                format!("`path.{key}` has {count} values, but there are {wanted} times"),
                "not one for each time",
                "give one value for each time, or leave it out: it stays 0 then",
            );
        }
        if values.first().is_some_and(|first| *first != 0.0) {
            whole = false;
            c.push(
                raw.path.span(key),
                format!("`path.{key}` does not begin at 0, where the palm is when the scene begins"),
                "starts elsewhere",
                "count all its values from the first one",
            );
        }
    }
    whole.then(|| keys.path()).flatten()
}
