//! Motion of the palm.

use super::super::section_input::SectionInput;
use super::super::settings::{MoveSettings, PathSettings, VibrationSettings};
use super::super::{PalmMotion, Path};

/// Resolves the motion of the palm; `None` if it is at rest. Reports a moving palm with a fixed object.
pub fn palm_motion(input: &SectionInput<'_>, is_fixed: bool) -> Option<PalmMotion> {
    let mut motion = PalmMotion::default();
    for (name, keys) in input.subsection("moves").subsections() {
        let settings: MoveSettings = keys.read();
        check_duration(&keys, &settings);
        motion.moves.extend(settings.moves());
        motion.names[0].resize(motion.moves.len(), name.to_string());
    }
    for (name, keys) in input.subsection("vibrations").subsections() {
        motion.vibrations.extend(keys.read::<VibrationSettings>().vibrations());
        motion.names[1].resize(motion.vibrations.len(), name.to_string());
    }
    let path_input = input.subsection("path");
    motion.path = path_input.is_present().then(|| path(&path_input)).flatten();
    if motion == PalmMotion::default() {
        return None;
    }
    if is_fixed {
        let section = ["moves", "vibrations", "path"].into_iter().find(|section| input.has(section)).unwrap_or("moves");
        let help = "write object.motion = \"free\", or remove the motion of the palm";
        let message = "the palm moves, but the object is fixed in the world";
        input.report(section, message, "requires a free object", help);
    }
    Some(motion)
}

/// The duration of a move is given by either `time` or `acceleration`.
fn check_duration(input: &SectionInput<'_>, settings: &MoveSettings) {
    if input.has("time") {
        input.report_unused("acceleration", "with `time`");
    } else if !input.has("acceleration") {
        let help = "add the duration or the peak acceleration: time = \"40 ms\" or acceleration = \"2 g\"";
        input.report_missing("time", help);
    } else if settings.distance_m() == 0.0 {
        input.report_unused("acceleration", "without a distance x or y: give `time` instead");
    }
}

fn path(input: &SectionInput<'_>) -> Option<Path> {
    let settings: PathSettings = input.read();
    let times = settings.times_s();
    let is_ordered = times.iter().all(|time| *time >= 0.0) && times.windows(2).all(|pair| pair[0] < pair[1]);
    if times.len() < 2 || !is_ordered {
        let message = "`path.times` must have two or more times, at least 0 and increasing";
        input.report("times", message, "invalid times", "write times = [\"0 ms\", \"50 ms\", \"100 ms\"]");
        return None;
    }
    let problem_count = input.checker.count();
    for (key, values) in ["x", "y", "angle"].into_iter().zip(settings.coordinates()) {
        if !values.is_empty() && values.len() != times.len() {
            let message = format!("`path.{key}` has {} values, but there are {} times", values.len(), times.len());
            let help = "give one value per time, or remove the key (default: 0)";
            input.report(key, message, "different number", help);
        }
        if values.first().is_some_and(|first| *first != 0.0) {
            let message = format!("`path.{key}` must begin at 0, the initial position of the palm");
            input.report(key, message, "does not begin at 0", "give all values relative to the first one");
        }
    }
    (input.checker.count() == problem_count).then(|| settings.path()).flatten()
}
