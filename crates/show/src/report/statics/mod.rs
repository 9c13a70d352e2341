//! The statics of the grasp of a finger or of a gripper: JSON document and text, with the form closure and its
//! certificate by the names of its constraints.

mod finger;
mod gripper;
mod mechanism;

pub use finger::StaticsReport;
pub use gripper::GripperStaticsReport;
pub use mechanism::MechanismStaticsReport;

use serde::Serialize;

use super::named::Object;
use crate::format::numbers::format_number;
use crate::format::report::{Report, list};
use crate::grasp::finger::Palm;
use crate::gripper::FingerContact;
use crate::statics::{Certificate, Decision, ForceClosure, FormClosure, Row, RowKind, Unknown};

fn millimetres(length_m: f64) -> String {
    format!("{:.4}", length_m * 1e3)
}

/// A friction coefficient with at most three significant digits.
fn format_mu(mu: f64) -> String {
    // A short number stays as it was written.
    let (exact, rounded) = (mu.to_string(), format_number(mu, 3));
    if exact.len() <= rounded.len() { exact } else { rounded }
}

/// Returns the JSON object of a form closure. `palm` states whether the object rests on the palm.
fn closure_document<'a>(found: &'a FormClosure, palm: &Palm) -> Object<'a> {
    let (palm, palm_gap_m) = match palm {
        Palm::Resting => ("rests", None),
        Palm::None => ("none", None),
        Palm::Separated { gap_m } => ("apart", Some(*gap_m)),
        Palm::Penetrating { depth_m } => ("within", Some(-depth_m)),
    };
    let decision = match found.decision {
        Decision::Rank => "rank",
        Decision::Signs => "signs",
        Decision::Programme => "programme",
    };
    let by_constraint = |values, [contact_key, motor_key]: [&'static str; 2]| -> Vec<Object<'static>> {
        let key = |is_motor| if is_motor { motor_key } else { contact_key };
        constraints(found, values)
            .map(|(name, is_motor, value)| Object::default().with("constraint", name).with(key(is_motor), value))
            .collect()
    };
    let (multipliers, motion) = match &found.certificate {
        Certificate::Multipliers { values, .. } => (Some(by_constraint(values, ["force_n", "torque_n_m"])), None),
        Certificate::Motion { values, rates, .. } => {
            let (object_m_s, fingers) = free_motion(found, values, rates);
            let object = Object::default()
                .with("words", motion_sentences(found, values, rates))
                .with("object_m_s", object_m_s)
                .with("fingers", fingers)
                .with("rates", by_constraint(rates, ["rate_m_s", "rate_rad_s"]));
            (None, Some(object))
        }
    };
    // (1.19): contacts + motors ≥ hand + object + 1.
    let count = found.necessary;
    let necessary = Object::default()
        .with("contacts", count.contacts)
        .with("motors", count.motors)
        .with("hand", count.hand)
        .with("object", count.object)
        .with("met", count.is_met());
    Object::default()
        .with("closed", found.closed)
        .with("palm", palm)
        .with_some("palm_gap_m", palm_gap_m)
        .with("necessary", necessary)
        .with("rank", found.rank)
        .with("unknowns", found.unknowns.len())
        .with("margin", found.margin)
        .with("decision", decision)
        .with_some("multipliers", multipliers)
        .with_some("motion", motion)
        .with("residual", residual(found))
}

/// Residual of the certificate, relative to its terms.
fn residual(found: &FormClosure) -> f64 {
    match found.certificate {
        Certificate::Multipliers { residual, .. } | Certificate::Motion { residual, .. } => residual,
    }
}

/// Name of each constraint, whether it is a motor, and its value.
fn constraints<'a>(found: &'a FormClosure, values: &'a [f64]) -> impl Iterator<Item = (String, bool, f64)> + 'a {
    let rows = found.rows.iter().zip(values);
    rows.map(|(&row, &value)| (constraint_name(row), RowKind::from(row) == RowKind::Motor, value))
}

fn constraint_name(row: Row) -> String {
    match row {
        Row::Contact { finger, site: FingerContact::Proximal } => format!("{} proximal phalanx", finger_name(finger)),
        Row::Contact { finger, .. } => format!("{} tip", finger_name(finger)),
        Row::Palm => "palm".to_string(),
        Row::Motor { finger } => format!("{} motor", finger_name(finger)),
        Row::Input => "input".to_string(),
        Row::Constraint { index } => format!("constraint {}", index + 1),
    }
}

/// "right", "left", or a number for further fingers.
fn finger_name(finger: usize) -> String {
    match finger {
        0 => "right".to_string(),
        1 => "left".to_string(),
        index => format!("finger {}", index + 1),
    }
}

/// Rates of a finger in a motion that violates no constraint.
#[derive(Serialize)]
struct FingerMotion {
    finger: String,
    qd21_rad_s: f64,
    qd22_rad_s: f64,
    motor_rad_s: Option<f64>,
}

/// Velocity of the object and rates of the fingers of a motion.
fn free_motion(found: &FormClosure, values: &[f64], rates: &[f64]) -> ([f64; 2], Vec<FingerMotion>) {
    let value_of = |unknown: Unknown| found.unknowns.iter().position(|&k| k == unknown).map_or(0.0, |i| values[i]);
    let finger = |finger: usize| FingerMotion {
        finger: finger_name(finger),
        qd21_rad_s: value_of(Unknown::Proximal { finger }),
        qd22_rad_s: value_of(Unknown::Distal { finger }),
        motor_rad_s: found.rows.iter().position(|&row| row == Row::Motor { finger }).map(|index| rates[index]),
    };
    let fingers = (0..).take_while(|&finger| found.unknowns.contains(&Unknown::Proximal { finger }));
    ([Unknown::ObjectX, Unknown::ObjectY].map(value_of), fingers.map(finger).collect())
}

/// Describes a motion: one sentence for the object, one for each finger (one for both if they move alike), one for the
/// contacts.
fn motion_sentences(found: &FormClosure, values: &[f64], rates: &[f64]) -> Vec<String> {
    let (object_m_s, fingers) = free_motion(found, values, rates);
    let mut sentences = vec![object_sentence(object_m_s)];
    match &fingers[..] {
        [right, left] if right.equals(left) => sentences.push(format!("Both fingers: {}.", right.description())),
        fingers => sentences.extend(fingers.iter().map(|finger| {
            let (first, rest) = finger.finger.split_at(1);
            format!("{}{rest} finger: {}.", first.to_uppercase(), finger.description())
        })),
    }
    let contacts = constraints(found, rates).filter(|(_, is_motor, _)| !is_motor);
    let (open, maintained): (Vec<_>, Vec<_>) = contacts.partition(|(_, _, rate)| *rate > 0.0);
    let [open, maintained] =
        [open, maintained].map(|contacts| contacts.into_iter().map(|(name, ..)| name).collect::<Vec<_>>().join(", "));
    sentences.push(match (open.is_empty(), maintained.is_empty()) {
        (true, true) => "The object has no contacts.".to_string(),
        (true, false) => format!("All contacts are maintained: {maintained}."),
        (false, true) => format!("All contacts open: {open}."),
        (false, false) => format!("Contact is lost at: {open}; maintained at: {maintained}."),
    });
    sentences
}

impl FingerMotion {
    fn description(&self) -> String {
        let joint = |name: &str, rate: f64, [positive, negative]: [&str; 2]| match rate {
            0.0 => format!("{name} does not move"),
            rate if rate > 0.0 => format!("{name} {positive} at {} rad/s", format_number(rate, 4)),
            rate => format!("{name} {negative} at {} rad/s", format_number(-rate, 4)),
        };
        let motor = self.motor_rad_s.map(|rate| joint("the motor", rate, ["advances", "reverses"]));
        format!(
            "{}, {}, {}",
            joint("the proximal phalanx", self.qd21_rad_s, ["closes", "opens"]),
            joint("the distal phalanx", self.qd22_rad_s, ["bends", "straightens"]),
            motor.unwrap_or_else(|| "the motor yields".to_string())
        )
    }

    /// Whether both fingers move alike, except for rounding.
    fn equals(&self, other: &FingerMotion) -> bool {
        let rates = |motion: &Self| [motion.qd21_rad_s, motion.qd22_rad_s, motion.motor_rad_s.unwrap_or_default()];
        let is_close = |(a, b): (f64, f64)| (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
        let have_motors = self.motor_rad_s.is_some() == other.motor_rad_s.is_some();
        have_motors && rates(self).into_iter().zip(rates(other)).all(is_close)
    }
}

fn object_sentence([x, y]: [f64; 2]) -> String {
    let direction = match (x, y) {
        (0.0, 0.0) => return "The object does not move.".to_string(),
        (0.0, y) if y > 0.0 => "straight away from the palm".to_string(),
        (0.0, _) => "straight towards the palm".to_string(),
        (x, 0.0) if x > 0.0 => "along the palm to the right".to_string(),
        (_, 0.0) => "along the palm to the left".to_string(),
        _ => {
            let angle = format_number(y.atan2(x).to_degrees(), 4);
            format!("at {angle}° (0° is along the palm to the right, 90° away from it)")
        }
    };
    format!("The object moves {direction} at {} mm/s.", format_number(x.hypot(y) * 1e3, 3))
}

/// Describes the form closure of a mechanism. `pure` are the forces per 1 N·m if their signs decide form closure.
fn closure_text(found: &FormClosure, palm: &Palm, mechanism: &str, pure: Option<[f64; 3]>) -> Report {
    let and_palm = if palm.supports_object() { " and the palm" } else { "" };
    let verdict = if found.closed { "closed" } else { "not closed" };
    let mut text = Report::from(format!("{mechanism}{and_palm}: {verdict}\n"));
    text.push(match palm {
        Palm::Separated { gap_m } => {
            format!("the object is {} mm above the palm, which does not support it\n", millimetres(*gap_m))
        }
        Palm::Penetrating { depth_m } => {
            format!("the object penetrates the palm by {} mm and counts as resting on it\n", millimetres(*depth_m))
        }
        Palm::None if pure.is_some() => "the scene has no palm\n".to_string(),
        Palm::None | Palm::Resting => String::new(),
    });
    let n = &found.necessary;
    let (sign, met) = if n.is_met() { ("≥", "met") } else { ("<", "not met") };
    text.push(format!(
        "necessary count: {} contacts + {} motors {sign} {} degrees of freedom of the fingers + {} of the object + 1, {met}\n",
        n.contacts, n.motors, n.hand, n.object
    ));
    text.push(pure.filter(|_| palm.supports_object()).map(|pure| {
        let [f21, f22, pfp] = pure.map(|force_n| format_number(force_n, 5));
        format!("without spring and friction, 1 N·m causes F21 {f21} N, F22 {f22} N, PFP {pfp} N; closed if all are positive\n")
    }));
    let residual = format_number(residual(found), 1);
    let values_list = |values, digits, contact_factor: f64, [contact_unit, motor_unit]: [&str; 2]| {
        let line = |(name, is_motor, value): (String, bool, f64)| match is_motor {
            true => vec![name, format_number(value, digits), motor_unit.to_string()],
            false => vec![name, format_number(value * contact_factor, digits), contact_unit.to_string()],
        };
        list(&constraints(found, values).map(line).collect::<Vec<_>>())
    };
    match &found.certificate {
        Certificate::Multipliers { values, .. } => text
            .with(format!(
                "certificate: U has full rank {}, and these positive forces are in equilibrium (residual {residual})\n",
                found.rank
            ))
            .with(values_list(values, 5, 1.0, ["N", "N·m"])),
        Certificate::Motion { values, rates, .. } => {
            text.push(format!("certificate: a motion that violates no constraint (residual {residual})\n"));
            motion_sentences(found, values, rates).iter().for_each(|line| text.push(format!("  {line}\n")));
            text.with("opening rate of each constraint\n").with(values_list(rates, 4, 1e3, ["mm/s", "rad/s"]))
        }
    }
}

/// Joins what is at its limit.
fn causes(mut parts: Vec<String>, names: Vec<(&str, Vec<&str>)>) -> String {
    let given = names.into_iter().filter(|(_, names)| !names.is_empty());
    parts.extend(given.map(|(verb, names)| format!("{verb} {}", names.join(" "))));
    if parts.is_empty() { "–".to_string() } else { parts.join(", ") }
}

/// Returns two lines on force closure with a friction coefficient (that of the scene for `None`): the verdict with Q1, and
/// the weakest wrench, whose moment is divided by `divisor`.
fn force_closure_text(mu_static: Option<f64>, closure: &ForceClosure, divisor: &str) -> String {
    let number = |value: f64| format_number(value, 4);
    let friction =
        mu_static.map_or("friction of the scene".to_string(), |mu| format!("μ_s {} in all contacts", format_mu(mu)));
    let [sum, each] = [closure.q1_l1, closure.q1_linf].map(number);
    let (verdict, weakest) = match closure.closed {
        true => {
            (format!("closed, Q1 {sum} (sum of normal forces 1) or {each} (each at most 1)"), "weakest direction: ")
        }
        false => ("not closed".to_string(), "cannot be balanced: "),
    };
    let [x, y, moment] = closure.weakest.map(number);
    format!(
        "force closure with {friction}: {verdict}\n{weakest}wrench ({x}, {y}; {moment}) of force and moment divided by {divisor}\n"
    )
}
