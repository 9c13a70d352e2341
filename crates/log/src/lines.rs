//! Events as text: what the channel `/events` says of them.

use phalanx_core::trace::{Event, EventKind, Site};

/// Which phalanges press.
#[derive(Clone, Copy, Debug, Default)]
pub struct Grasp {
    pressed: [bool; 2],
}

impl Grasp {
    /// What an event means for the grasp, if anything.
    pub fn change(&mut self, event: &Event) -> Option<String> {
        if event.kind.is_of_friction() {
            return None;
        }
        let held = self.pressed == [true; 2];
        match event.site() {
            Site::Proximal => self.pressed[0] = event.kind != EventKind::LiftOff,
            Site::Distal => self.pressed[1] = event.kind != EventKind::LiftOff,
            Site::Limit => return None,
        }
        let time_ms = event.time_s * 1e3;
        match (held, self.pressed == [true; 2]) {
            (false, true) => Some(format!("both phalanges hold the object from {time_ms:.6} ms")),
            (true, false) => Some(format!("no longer held by both phalanges from {time_ms:.6} ms")),
            _ => None,
        }
    }
}

/// A change of contact in words and figures; `place` is what touches, `angular` whether its gap is an angle.
pub fn change(event: &Event, place: &str, angular: bool) -> String {
    let Event { time_s, kind, approach_speed: speed, impulse, .. } = *event;
    let [speed_unit, impulse_unit] = if angular { ["rad/s", "N·m·s"] } else { ["m/s", "N·s"] };
    let time_ms = time_s * 1e3;
    match kind {
        EventKind::TouchDown => {
            format!("{place}: touch-down at {time_ms:.6} ms, approach speed {speed:.6} {speed_unit}")
        }
        EventKind::LiftOff => {
            format!("{place}: lift-off at {time_ms:.6} ms, impulse {impulse:.6e} {impulse_unit} since touch-down")
        }
        EventKind::Reload => format!("{place}: pressed again at {time_ms:.6} ms, before it had parted"),
        EventKind::Slips => format!("{place}: {SLIPS} {time_ms:.6} ms"),
        EventKind::Sticks => format!("{place}: {STICKS} {time_ms:.6} ms"),
    }
}

const SLIPS: &str = "begins to slip at";
const STICKS: &str = "sticks again at";

/// Whether a line of a contact is one of friction.
pub fn is_of_friction(line: &str) -> bool {
    [SLIPS, STICKS].iter().any(|words| line.contains(words))
}
