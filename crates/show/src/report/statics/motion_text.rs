//! Sentences that describe a free motion.

use super::motion::{FingerMotionReport, MotionReport};
use crate::format::numbers::format_number;
use crate::grasp::finger::Palm;

/// Describes a motion: one sentence for the object, one for each finger (one for both if they move alike), one for the
/// contacts.
pub fn motion_sentences(motion: &MotionReport) -> Vec<String> {
    let mut sentences = vec![object(motion.object_m_s)];
    match &motion.fingers[..] {
        [right, left] if is_same_motion(right, left) => sentences.push(format!("Both fingers: {}.", finger(right))),
        fingers => {
            sentences.extend(fingers.iter().map(|finger_motion| {
                format!("{} finger: {}.", capitalised(&finger_motion.finger), finger(finger_motion))
            }))
        }
    }
    let contacts = motion.rates.iter().filter_map(|rate| Some((rate.constraint.as_str(), rate.rate_m_s?)));
    let (open, maintained): (Vec<_>, Vec<_>) = contacts.partition(|(_, rate)| *rate > 0.0);
    let names = |rates: &[(&str, f64)]| rates.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    sentences.push(match (open.is_empty(), maintained.is_empty()) {
        (true, true) => "The object has no contacts.".to_string(),
        (true, false) => format!("All contacts are maintained: {}.", names(&maintained)),
        (false, true) => format!("All contacts open: {}.", names(&open)),
        (false, false) => format!("Contact is lost at: {}; maintained at: {}.", names(&open), names(&maintained)),
    });
    sentences
}

fn object([x, y]: [f64; 2]) -> String {
    let speed = x.hypot(y);
    if speed == 0.0 {
        return "The object does not move.".to_string();
    }
    let angle = y.atan2(x).to_degrees();
    let direction = match (x == 0.0, y == 0.0) {
        (true, _) if y > 0.0 => "straight away from the palm".to_string(),
        (true, _) => "straight towards the palm".to_string(),
        (_, true) if x > 0.0 => "along the palm to the right".to_string(),
        (_, true) => "along the palm to the left".to_string(),
        _ => format!("at {}° (0° is along the palm to the right, 90° away from it)", format_number(angle, 4)),
    };
    format!("The object moves {direction} at {} mm/s.", format_number(speed * 1e3, 3))
}

fn finger(motion: &FingerMotionReport) -> String {
    let joint = |name: &str, rate: f64, positive: &str, negative: &str| match rate {
        0.0 => format!("{name} does not move"),
        rate => {
            format!("{name} {} at {} rad/s", if rate > 0.0 { positive } else { negative }, format_number(rate.abs(), 4))
        }
    };
    let mut parts = vec![
        joint("the proximal phalanx", motion.qd21_rad_s, "closes", "opens"),
        joint("the distal phalanx", motion.qd22_rad_s, "bends", "straightens"),
    ];
    match motion.motor_rad_s {
        Some(rate) => parts.push(joint("the motor", rate, "advances", "reverses")),
        None => parts.push("the motor yields".to_string()),
    }
    parts.join(", ")
}

fn is_same_motion(a: &FingerMotionReport, b: &FingerMotionReport) -> bool {
    let is_close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
    let motors = match (a.motor_rad_s, b.motor_rad_s) {
        (Some(a), Some(b)) => is_close(a, b),
        (a, b) => a == b,
    };
    is_close(a.qd21_rad_s, b.qd21_rad_s) && is_close(a.qd22_rad_s, b.qd22_rad_s) && motors
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Key of the state of the palm.
pub(super) fn palm_state(palm: &Palm) -> &'static str {
    match palm {
        Palm::Resting => "rests",
        Palm::None => "none",
        Palm::Separated { .. } => "apart",
        Palm::Penetrating { .. } => "within",
    }
}
