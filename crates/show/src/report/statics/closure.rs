//! Form closure with its certificate by the names of its constraints: JSON document and text.

use serde::Serialize;

use super::super::named::Object;
use super::millimetres;
use crate::format::numbers::format_number;
use crate::format::report::{Report, list};
use crate::grasp::finger::Palm;
use crate::gripper::FingerContact;
use crate::statics::{Certificate, Decision, FormClosure, Row, RowKind, Unknown};

/// Returns the JSON object of a form closure. `palm` states whether the object rests on the palm.
pub(super) fn document<'a>(found: &'a FormClosure, palm: &Palm) -> Object<'a> {
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
    let by_constraint = |values: &[f64], contact_key: &'static str, motor_key: &'static str| -> Vec<Object<'static>> {
        let key = |is_motor: bool| if is_motor { motor_key } else { contact_key };
        constraints(found, values)
            .map(|(name, is_motor, value)| Object::default().with("constraint", name).with(key(is_motor), value))
            .collect()
    };
    let (multipliers, motion) = match &found.certificate {
        Certificate::Multipliers { values, .. } => (Some(by_constraint(values, "force_n", "torque_n_m")), None),
        Certificate::Motion { values, rates, .. } => {
            let motion = FreeMotion::new(found, values, rates);
            let object = Object::default()
                .with("words", motion.sentences(found, rates))
                .with("object_m_s", motion.object_m_s)
                .with("fingers", motion.fingers)
                .with("rates", by_constraint(rates, "rate_m_s", "rate_rad_s"));
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

/// A motion that violates no constraint.
struct FreeMotion {
    object_m_s: [f64; 2],
    fingers: Vec<FingerMotion>,
}

#[derive(Serialize)]
struct FingerMotion {
    finger: String,
    qd21_rad_s: f64,
    qd22_rad_s: f64,
    motor_rad_s: Option<f64>,
}

impl FreeMotion {
    fn new(found: &FormClosure, values: &[f64], rates: &[f64]) -> Self {
        let value_of = |unknown: Unknown| found.unknowns.iter().position(|&k| k == unknown).map_or(0.0, |i| values[i]);
        let motor = |finger: usize| found.rows.iter().position(|&row| row == Row::Motor { finger });
        let finger = |finger: usize| FingerMotion {
            finger: finger_name(finger),
            qd21_rad_s: value_of(Unknown::Proximal { finger }),
            qd22_rad_s: value_of(Unknown::Distal { finger }),
            motor_rad_s: motor(finger).map(|index| rates[index]),
        };
        let fingers = (0..).take_while(|&finger| found.unknowns.contains(&Unknown::Proximal { finger }));
        let object_m_s = [Unknown::ObjectX, Unknown::ObjectY].map(value_of);
        FreeMotion { object_m_s, fingers: fingers.map(finger).collect() }
    }

    /// Describes the motion: one sentence for the object, one for each finger (one for both if they move alike), one
    /// for the contacts.
    fn sentences(&self, found: &FormClosure, rates: &[f64]) -> Vec<String> {
        let mut sentences = vec![object_sentence(self.object_m_s)];
        match &self.fingers[..] {
            [right, left] if right.equals(left) => sentences.push(format!("Both fingers: {}.", right.description())),
            fingers => {
                let sentence = |finger: &FingerMotion| {
                    let (first, rest) = finger.finger.split_at(1);
                    format!("{}{rest} finger: {}.", first.to_uppercase(), finger.description())
                };
                sentences.extend(fingers.iter().map(sentence));
            }
        }
        let contacts = constraints(found, rates).filter(|(_, is_motor, _)| !is_motor);
        let (open, maintained): (Vec<_>, Vec<_>) = contacts.partition(|(_, _, rate)| *rate > 0.0);
        let [open, maintained] = [open, maintained]
            .map(|contacts| contacts.into_iter().map(|(name, ..)| name).collect::<Vec<_>>().join(", "));
        sentences.push(match (open.is_empty(), maintained.is_empty()) {
            (true, true) => "The object has no contacts.".to_string(),
            (true, false) => format!("All contacts are maintained: {maintained}."),
            (false, true) => format!("All contacts open: {open}."),
            (false, false) => format!("Contact is lost at: {open}; maintained at: {maintained}."),
        });
        sentences
    }
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
        let is_close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * (a.abs() + b.abs());
        let motors = match (self.motor_rad_s, other.motor_rad_s) {
            (Some(a), Some(b)) => is_close(a, b),
            (a, b) => a == b,
        };
        is_close(self.qd21_rad_s, other.qd21_rad_s) && is_close(self.qd22_rad_s, other.qd22_rad_s) && motors
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
pub(super) fn text(found: &FormClosure, palm: &Palm, mechanism: &str, pure: Option<[f64; 3]>) -> Report {
    let and_palm = if palm.supports_object() { " and the palm" } else { "" };
    let verdict = if found.closed { "closed" } else { "not closed" };
    let mut text = Report::from(format!("{mechanism}{and_palm}: {verdict}\n"));
    match palm {
        Palm::Separated { gap_m } => {
            text.push(format!("the object is {} mm above the palm, which does not support it\n", millimetres(*gap_m)))
        }
        Palm::Penetrating { depth_m } => text.push(format!(
            "the object penetrates the palm by {} mm and counts as resting on it\n",
            millimetres(*depth_m)
        )),
        Palm::None if pure.is_some() => text.push_str("the scene has no palm\n"),
        Palm::None | Palm::Resting => {}
    }
    let n = &found.necessary;
    let (sign, met) = if n.is_met() { ("≥", "met") } else { ("<", "not met") };
    text.push(format!(
        "necessary count: {} contacts + {} motors {sign} {} degrees of freedom of the fingers + {} of the object + 1, {met}\n",
        n.contacts, n.motors, n.hand, n.object
    ));
    let number = |value: f64, digits: usize| format_number(value, digits);
    if let Some(pure) = pure.filter(|_| palm.supports_object()) {
        let [f21, f22, pfp] = pure.map(|force_n| number(force_n, 5));
        text.push(format!(
            "without spring and friction, 1 N·m causes F21 {f21} N, F22 {f22} N, PFP {pfp} N; closed if all are positive\n"
        ));
    }
    let residual = number(residual(found), 1);
    match &found.certificate {
        Certificate::Multipliers { values, .. } => {
            text.push(format!(
                "certificate: U has full rank {}, and these positive forces are in equilibrium (residual {residual})\n",
                found.rank
            ));
            let line = |(name, is_motor, value): (String, bool, f64)| {
                vec![name, number(value, 5), if is_motor { "N·m" } else { "N" }.to_string()]
            };
            text.push(list(&constraints(found, values).map(line).collect::<Vec<_>>()));
        }
        Certificate::Motion { values, rates, .. } => {
            text.push(format!("certificate: a motion that violates no constraint (residual {residual})\n"));
            let sentences = FreeMotion::new(found, values, rates).sentences(found, rates);
            sentences.iter().for_each(|sentence| text.push(format!("  {sentence}\n")));
            text.push_str("opening rate of each constraint\n");
            let line = |(name, is_motor, rate): (String, bool, f64)| match is_motor {
                true => vec![name, number(rate, 4), "rad/s".to_string()],
                false => vec![name, number(rate * 1e3, 4), "mm/s".to_string()],
            };
            text.push(list(&constraints(found, rates).map(line).collect::<Vec<_>>()));
        }
    }
    text
}
