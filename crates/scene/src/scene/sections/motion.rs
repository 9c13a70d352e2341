//! Motion of the palm of a gripper, and of a body of a mechanism.

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};

use super::{MECHANISM, check_point_count, extend};
use crate::numeric::elementary::hypot;
use crate::scene::keys::is_name;
use crate::scene::quantity::{
    Acceleration, Angle, Frequency, Keyword, Length, NotNegative, Plain, Positive, Quantity, Time, Word, keywords,
    si_values,
};
use crate::scene::section_input::SectionInput;
use crate::scene::{Axis, Move, PalmMotion, Path, Ramp, Vibration};

/// Sections of a motion.
pub(super) const MOTION_SECTIONS: [&str; 3] = ["moves", "vibrations", "path"];

/// Coordinates that are not 0.
fn nonzero(x: f64, y: f64, angle: f64) -> impl Iterator<Item = (Axis, f64)> {
    [(Axis::X, x), (Axis::Y, y), (Axis::Angle, angle)].into_iter().filter(|(_, value)| *value != 0.0)
}

/// A move of the palm from rest to rest along a polynomial of order 7, with zero rate, acceleration and jerk at both
/// ends. Overlapping moves add up.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(extend("x-mechanism" = { "description": "A move of a body from rest to rest along a polynomial of order 7, with zero rate, acceleration and jerk at both ends. Overlapping moves add up." }))]
pub struct MoveSettings {
    /// The body that moves: a body without joints to the ground, or `ground` with everything fixed to it except the
    /// surroundings of the grasp. All sections of a motion have the same body. Default: that of another section, or
    /// else the base of the grasp, or `ground` without a grasp.
    #[schemars(extend("minLength" = 1, "x-kinds" = MECHANISM))]
    pub body: Option<String>,
    /// Distance along the palm.
    #[schemars(extend("default" = "0 mm", "x-mechanism" = { "description": "Distance along x of the world." }))]
    pub x: Quantity<Length>,
    /// Distance out of the palm; negative to lift an object with the gripper upside down.
    #[schemars(extend("default" = "0 mm", "x-mechanism" = { "description": "Distance along y of the world." }))]
    pub y: Quantity<Length>,
    /// Rotation, counter-clockwise.
    #[schemars(extend("default" = "0 deg", "x-mechanism" = {
        "description": "Rotation about the origin of the body, counter-clockwise."
    }))]
    pub angle: Quantity<Angle>,
    /// Time at which the move begins.
    #[schemars(extend("x-required" = "add the start of the move: start = \"20 ms\""))]
    pub start: Option<NotNegative<Time>>,
    /// Duration. Alternative to `acceleration`.
    pub time: Option<Positive<Time>>,
    /// Peak acceleration a, in place of `time`. With the distance s = √(x² + y²), the duration is T = √(16.8/√5 s/a),
    /// with 16.8/√5 = 7.513.
    pub acceleration: Option<Positive<Acceleration>>,
}

/// A vibration of the palm, amplitude × sin(2π f (t − start) + phase), with a ramp over the first periods.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(extend("x-mechanism" = { "description": "A vibration of a body, amplitude × sin(2π f (t − start) + phase), with a ramp over the first periods." }))]
pub struct VibrationSettings {
    /// The body that moves: a body without joints to the ground, or `ground` with everything fixed to it except the
    /// surroundings of the grasp. All sections of a motion have the same body. Default: that of another section, or
    /// else the base of the grasp, or `ground` without a grasp.
    #[schemars(extend("minLength" = 1, "x-kinds" = MECHANISM))]
    pub body: Option<String>,
    /// Amplitude along x, in the direction of the palm.
    #[schemars(extend("default" = "0 mm", "x-mechanism" = { "description": "Amplitude along x of the world." }))]
    pub x: Quantity<Length>,
    /// Amplitude along y, out of the palm.
    #[schemars(extend("default" = "0 mm", "x-mechanism" = { "description": "Amplitude along y of the world." }))]
    pub y: Quantity<Length>,
    /// Amplitude of the angle.
    #[schemars(extend("default" = "0 deg", "x-mechanism" = {
        "description": "Amplitude of the angle, about the origin of the body."
    }))]
    pub angle: Quantity<Angle>,
    /// Frequency. Required.
    #[schemars(extend("x-required" = "add the frequency: frequency = \"200 Hz\""))]
    pub frequency: Option<Positive<Frequency>>,
    /// Phase at the start.
    #[schemars(extend("default" = "0 deg"))]
    pub phase: Quantity<Angle>,
    /// Time at which the vibration begins.
    #[schemars(extend("default" = "0 ms"))]
    pub start: NotNegative<Time>,
    /// Duration of the ramp of the amplitude, in periods.
    #[schemars(extend("default" = 2.0))]
    pub ramp_periods: Positive<Plain>,
    /// Shape of the ramp: "quintic": 10 s³ − 15 s⁴ + 6 s⁵, with continuous acceleration; "cubic": 3 s² − 2 s³.
    #[schemars(extend("default" = "quintic"))]
    pub ramp: Word<Ramp>,
}

keywords! { Ramp { "quintic" => Ramp::Quintic, "cubic" => Ramp::Cubic } }

/// A path of the palm: a cubic spline through poses, at rest before the first and after the last pose. It is added to
/// moves and vibrations.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(extend("x-mechanism" = { "description": "A path of a body: a cubic spline through poses relative to that at the start, at rest before the first and after the last; added to moves and vibrations." }))]
pub struct PathSettings {
    /// The body that moves: a body without joints to the ground, or `ground` with everything fixed to it except the
    /// surroundings of the grasp. All sections of a motion have the same body. Default: that of another section, or
    /// else the base of the grasp, or `ground` without a grasp.
    #[schemars(extend("minLength" = 1, "x-kinds" = MECHANISM))]
    pub body: Option<String>,
    /// Times of the poses, increasing.
    pub times: Option<Vec<Quantity<Time>>>,
    /// Positions along the palm, one per time. Default: 0.
    #[schemars(extend("x-mechanism" = { "description": "Displacements along x of the world, one per time. Default: 0." }))]
    pub x: Option<Vec<Quantity<Length>>>,
    /// Positions out of the palm, one per time. Default: 0.
    #[schemars(extend("x-mechanism" = { "description": "Displacements along y of the world, one per time. Default: 0." }))]
    pub y: Option<Vec<Quantity<Length>>>,
    /// Angles, one per time. Default: 0.
    #[schemars(extend("x-mechanism" = { "description": "Rotations about the origin of the body, one per time. Default: 0." }))]
    pub angle: Option<Vec<Quantity<Angle>>>,
}

/// Settings that describe the motion of a body; `None` is the palm of a gripper. They are the moves, the vibrations and
/// the path; motions without a name are numbered.
pub fn palm_motion_settings(motion: &PalmMotion, body: Option<&str>) -> Value {
    let mut settings = json!({ "moves": {}, "vibrations": {} });
    let mut add = |section: &str, names: &[String], index: usize, (axis, value): (Axis, f64), more: Value| {
        let name = names.get(index).filter(|name| is_name(name)).cloned();
        let item = &mut settings[section][name.unwrap_or(format!("{}{}", &section[..1], index + 1))];
        item[["x", "y", "angle"][axis as usize]] = value.into();
        extend(item, more);
    };
    for (index, Move { axis, distance, start_s, length_s }) in motion.moves.iter().enumerate() {
        let more = json!({ "body": body, "start": start_s, "time": length_s });
        add("moves", &motion.names[0], index, (*axis, *distance), more);
    }
    for (index, item) in motion.vibrations.iter().enumerate() {
        let more = json!({
            "body": body,
            "frequency": item.frequency_hz,
            "phase": item.phase_rad,
            "start": item.start_s,
            "ramp_periods": item.ramp_periods,
            "ramp": item.ramp.keyword(),
        });
        add("vibrations", &motion.names[1], index, (item.axis, item.amplitude), more);
    }
    if let Some(path) = &motion.path {
        let axis = |axis: usize| path.points().iter().map(|point| point.1[axis]).collect::<Value>();
        let times = path.points().iter().map(|point| point.0).collect::<Value>();
        settings["path"] = json!({ "body": body, "times": times, "x": axis(0), "y": axis(1), "angle": axis(2) });
    }
    settings
}

/// Resolves the motion of the palm; `None` if it is at rest. Reports a problem if the palm moves and its object is
/// fixed.
pub fn palm_motion(input: &SectionInput<'_>, is_fixed: bool) -> Option<PalmMotion> {
    let mut motion = PalmMotion::default();
    for (name, keys) in input.subsection("moves").subsections() {
        motion.moves.extend(moves(&keys));
        motion.names[0].resize(motion.moves.len(), name.to_string());
    }
    for (name, keys) in input.subsection("vibrations").subsections() {
        let settings: VibrationSettings = keys.read();
        let (phase_rad, start_s, ramp_periods) = (*settings.phase, *settings.start, *settings.ramp_periods);
        let (frequency_hz, ramp) = (settings.frequency.map_or(f64::NAN, |frequency| *frequency), settings.ramp.0);
        let vibration =
            |(axis, amplitude)| Vibration { axis, amplitude, frequency_hz, phase_rad, start_s, ramp_periods, ramp };
        motion.vibrations.extend(nonzero(*settings.x, *settings.y, *settings.angle).map(vibration));
        motion.names[1].resize(motion.vibrations.len(), name.to_string());
    }
    let path_input = input.subsection("path");
    motion.path = path_input.is_present().then(|| path(&path_input)).flatten();
    if motion == PalmMotion::default() {
        return None;
    }
    if is_fixed {
        let section = MOTION_SECTIONS.into_iter().find(|section| input.has(section)).unwrap_or("moves");
        let help = "write object.motion = \"free\", or remove the motion of the palm";
        let message = "the palm moves, but the object is fixed in the world";
        input.report(section, message, "requires a free object", help);
    }
    Some(motion)
}

/// Moves along each coordinate that changes. The duration is given, or follows from the peak acceleration.
fn moves(input: &SectionInput<'_>) -> impl Iterator<Item = Move> {
    let MoveSettings { x, y, angle, start, time, acceleration, .. } = input.read();
    let distance_m = hypot(*x, *y);
    if input.has("time") {
        input.report_unused(["acceleration"], "with `time`");
    } else if !input.has("acceleration") {
        let help = "add the duration or the peak acceleration: time = \"40 ms\" or acceleration = \"2 g\"";
        input.report_missing("time", help);
    } else if distance_m == 0.0 {
        input.report_unused(["acceleration"], "without a distance x or y: give `time` instead");
    }
    let start_s = start.map_or(f64::NAN, |start| *start);
    let length_s = match acceleration {
        None => time.map_or(f64::NAN, |time| *time),
        Some(peak) => (Move::unit_peak_acceleration() * distance_m / *peak).sqrt(),
    };
    nonzero(*x, *y, *angle).map(move |(axis, distance)| Move { axis, distance, start_s, length_s })
}

fn path(input: &SectionInput<'_>) -> Option<Path> {
    let PathSettings { times, x, y, angle, .. } = input.read();
    check_point_count(input, times.as_ref().map_or(0, Vec::len))?;
    let (times, coordinates) = (si_values(times), [si_values(x), si_values(y), si_values(angle)]);
    let is_ordered = times.iter().all(|time| *time >= 0.0) && times.windows(2).all(|pair| pair[0] < pair[1]);
    if times.len() < 2 || !is_ordered {
        let message = "`path.times` must have two or more times, at least 0 and increasing";
        return input.refuse("times", message, "invalid times", "write times = [\"0 ms\", \"50 ms\", \"100 ms\"]");
    }
    let problem_count = input.checker.count();
    for (key, values) in ["x", "y", "angle"].into_iter().zip(&coordinates) {
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
    // A coordinate that is not given is 0.
    let at = |index: usize| coordinates.each_ref().map(|values| values.get(index).copied().unwrap_or(0.0));
    let points = times.into_iter().enumerate().map(|(index, time)| (time, at(index)));
    (input.checker.count() == problem_count).then(|| Path::new(points.collect())).flatten()
}
