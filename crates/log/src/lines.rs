//! Event lines of the channel `/events`.
//!
//! Changing their text makes `replay --verify` reject older logs.

use phalanx_core::trace::{Event, EventKind};

/// Which phalanges are in contact.
#[derive(Clone, Copy, Debug)]
pub struct GraspState {
    /// Contacts of the proximal and the distal phalanx.
    phalanges: [Option<usize>; 2],
    in_contact: [bool; 2],
}

impl GraspState {
    pub fn new(phalanges: [Option<usize>; 2]) -> Self {
        Self { phalanges, in_contact: [false; 2] }
    }

    /// Takes an event into account. Returns a sentence if the grasp begins or ends with this event.
    pub fn update(&mut self, event: &Event) -> Option<String> {
        if event.kind.is_friction_event() {
            return None;
        }
        let was_grasped = self.in_contact == [true; 2];
        let phalanx = self.phalanges.iter().position(|contact| *contact == Some(event.contact))?;
        self.in_contact[phalanx] = event.kind != EventKind::LiftOff;
        let time_ms = event.time_s * 1e3;
        match (was_grasped, self.in_contact == [true; 2]) {
            (false, true) => Some(format!("both phalanges hold the object from {time_ms:.6} ms")),
            (true, false) => Some(format!("no longer held by both phalanges from {time_ms:.6} ms")),
            _ => None,
        }
    }
}

/// Describes a contact event in one line; `angular`: the gap is an angle.
pub(crate) fn describe_event(event: &Event, contact_name: &str, angular: bool) -> String {
    let Event { time_s, kind, approach_speed: speed, impulse, .. } = *event;
    let [speed_unit, impulse_unit] = if angular { ["rad/s", "N·m·s"] } else { ["m/s", "N·s"] };
    let time_ms = time_s * 1e3;
    match kind {
        EventKind::TouchDown => {
            format!("{contact_name}: touch-down at {time_ms:.6} ms, approach speed {speed:.6} {speed_unit}")
        }
        EventKind::LiftOff => {
            format!(
                "{contact_name}: lift-off at {time_ms:.6} ms, impulse {impulse:.6e} {impulse_unit} since touch-down"
            )
        }
        EventKind::Reload => format!("{contact_name}: pressed again at {time_ms:.6} ms, before it had parted"),
        EventKind::Slips => format!("{contact_name}: {SLIP_PHRASE} {time_ms:.6} ms"),
        EventKind::Sticks => format!("{contact_name}: {STICK_PHRASE} {time_ms:.6} ms"),
    }
}

const SLIP_PHRASE: &str = "begins to slip at";
const STICK_PHRASE: &str = "sticks again at";

/// Whether an event line is about friction.
pub(crate) fn is_friction_line(line: &str) -> bool {
    [SLIP_PHRASE, STICK_PHRASE].iter().any(|phrase| line.contains(phrase))
}
