//! Motion of the palm.

use super::super::check::Checker;
use super::super::table::input::SectionInput;
use super::super::table::motion::{MoveSettings, PathSettings, VibrationSettings};
use super::super::table::{SettingsSection, read};
use super::super::{PalmMotion, Path};

/// Resolves the motion of the palm; `None` if it is at rest. Reports a moving palm with a fixed object.
pub fn palm_motion(checker: &mut Checker<'_>, input: &SectionInput<'_>, is_fixed: bool) -> Option<PalmMotion> {
    let mut motion = PalmMotion::default();
    for (name, keys) in input.subsection("moves").subsections() {
        let path = format!("moves.{name}");
        let settings = read(checker, &path, &keys, MoveSettings::defaults());
        check_duration(checker, &path, &keys, &settings);
        motion.moves.extend(settings.moves());
        motion.names[0].resize(motion.moves.len(), name.to_string());
    }
    for (name, keys) in input.subsection("vibrations").subsections() {
        let path = format!("vibrations.{name}");
        motion.vibrations.extend(read(checker, &path, &keys, VibrationSettings::defaults()).vibrations());
        motion.names[1].resize(motion.vibrations.len(), name.to_string());
    }
    let path_input = input.subsection("path");
    motion.path = path_input.is_present().then(|| path(checker, &path_input)).flatten();
    if motion == PalmMotion::default() {
        return None;
    }
    if is_fixed {
        let spans = ["moves", "vibrations", "path"].map(|section| input.span(section));
        checker.push(
            spans.into_iter().flatten().next(),
            "the palm moves, but the object is fixed in the world",
            "requires a free object",
            "write object.motion = \"free\", or remove the motion of the palm",
        );
    }
    Some(motion)
}

/// The duration of a move is given by either `time` or `acceleration`.
fn check_duration(checker: &mut Checker<'_>, path: &str, keys: &SectionInput<'_>, settings: &MoveSettings) {
    let (key, key_span) = (format!("{path}.acceleration"), keys.span("acceleration"));
    if keys.has("time") {
        checker.report_unused_at(&key, key_span, "with `time`");
    } else if key_span.is_none() {
        let help = "add the duration or the peak acceleration: time = \"40 ms\" or acceleration = \"2 g\"";
        checker.report_missing_at(&format!("{path}.time"), keys.span.clone(), help);
    } else if settings.distance_m() == 0.0 {
        checker.report_unused_at(&key, key_span, "without a distance x or y: give `time` instead");
    }
}

fn path(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> Option<Path> {
    let keys = read(checker, "path", input, PathSettings::defaults());
    let times = &keys.times_s;
    let ordered = times.iter().all(|time| *time >= 0.0) && times.windows(2).all(|pair| pair[0] < pair[1]);
    if times.len() < 2 || !ordered {
        checker.push(
            input.span("times").or(input.span.clone()),
            "`path.times` must have two or more times, at least 0 and increasing",
            "invalid times",
            "write times = [\"0 ms\", \"50 ms\", \"100 ms\"]",
        );
        return None;
    }
    let mut is_valid = true;
    for (key, values) in ["x", "y", "angle"].into_iter().zip(&keys.coordinates) {
        if !values.is_empty() && values.len() != times.len() {
            is_valid = false;
            let (count, expected_count) = (values.len(), times.len());
            checker.push(
                input.span(key),
                format!("`path.{key}` has {count} values, but there are {expected_count} times"),
                "different number",
                "give one value per time, or remove the key (default: 0)",
            );
        }
        if values.first().is_some_and(|first| *first != 0.0) {
            is_valid = false;
            checker.push(
                input.span(key),
                format!("`path.{key}` must begin at 0, the initial position of the palm"),
                "does not begin at 0",
                "give all values relative to the first one",
            );
        }
    }
    is_valid.then(|| keys.path()).flatten()
}
