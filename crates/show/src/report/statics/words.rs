//! A free motion in words.

use super::motion::{FingerMotionReport, MotionReport};
use crate::grasp::finger::Palm;
use crate::wording::figures::figure;

/// One sentence for the object, one for each finger (one for both if they move alike), one for contacts.
pub fn motion_words(motion: &MotionReport) -> Vec<String> {
    let mut words = vec![object(motion.object_m_s)];
    match &motion.fingers[..] {
        [right, left] if alike(right, left) => words.push(format!("Both fingers: {}.", finger(right))),
        fingers => words.extend(fingers.iter().map(|of| format!("{} finger: {}.", capital(&of.finger), finger(of)))),
    }
    let contacts = motion.rates.iter().filter_map(|rate| Some((rate.constraint.as_str(), rate.rate_m_s?)));
    let (open, kept): (Vec<_>, Vec<_>) = contacts.partition(|(_, rate)| *rate > 0.0);
    let names = |of: &[(&str, f64)]| of.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    words.push(match (open.is_empty(), kept.is_empty()) {
        (true, true) => "Nothing touches the object.".to_string(),
        (true, false) => format!("Every contact stays: {}.", names(&kept)),
        (false, true) => format!("Every contact opens: {}.", names(&open)),
        (false, false) => format!("Contact is lost at: {}; kept at: {}.", names(&open), names(&kept)),
    });
    words
}

fn object([x, y]: [f64; 2]) -> String {
    let speed = x.hypot(y);
    if speed == 0.0 {
        return "The object stays.".to_string();
    }
    let angle = y.atan2(x).to_degrees();
    let direction = match (x == 0.0, y == 0.0) {
        (true, _) if y > 0.0 => "straight away from the palm".to_string(),
        (true, _) => "straight towards the palm".to_string(),
        (_, true) if x > 0.0 => "along the palm to the right".to_string(),
        (_, true) => "along the palm to the left".to_string(),
        _ => format!("at {}° (0° is along the palm to the right, 90° away from it)", figure(angle, 4)),
    };
    format!("The object moves {direction} at {} mm/s.", figure(speed * 1e3, 3))
}

fn finger(of: &FingerMotionReport) -> String {
    let joint = |name: &str, rate: f64, positive: &str, negative: &str| match rate {
        0.0 => format!("{name} stays"),
        rate => format!("{name} {} at {} rad/s", if rate > 0.0 { positive } else { negative }, figure(rate.abs(), 4)),
    };
    let mut parts = vec![
        joint("the proximal phalanx", of.qd21_rad_s, "closes", "opens"),
        joint("the tip", of.qd22_rad_s, "bends", "unbends"),
    ];
    match of.motor_rad_s {
        Some(rate) => parts.push(joint("the motor", rate, "advances", "goes back")),
        None => parts.push("the motor gives way".to_string()),
    }
    parts.join(", ")
}

fn alike(a: &FingerMotionReport, b: &FingerMotionReport) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
    let motors = match (a.motor_rad_s, b.motor_rad_s) {
        (Some(a), Some(b)) => near(a, b),
        (a, b) => a == b,
    };
    near(a.qd21_rad_s, b.qd21_rad_s) && near(a.qd22_rad_s, b.qd22_rad_s) && motors
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// What the report says of the palm.
pub(super) fn palm(palm: &Palm) -> &'static str {
    match palm {
        Palm::Rests => "rests",
        Palm::None => "none",
        Palm::Apart { .. } => "apart",
        Palm::Within { .. } => "within",
    }
}
