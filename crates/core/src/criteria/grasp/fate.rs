//! The fate of an object, with its reason.

use super::hold::{HoldHistory, HoldState};
use super::pairs::PairCriteria;
use crate::criteria::Fate;

/// What decides a fate.
pub(super) struct Evidence<'a> {
    pub hold: &'a HoldHistory,
    pub held_time_s: f64,
    pub pairs: &'a [PairCriteria],
    /// Whether the object is slow in the frame of the base, and in the world.
    pub is_slow_in_base: bool,
    pub is_slow_in_world: bool,
    /// Speed of its centre in these frames, m/s.
    pub speeds_m_s: [f64; 2],
    pub escaped_s: Option<f64>,
}

impl Evidence<'_> {
    /// Returns the fate and its reason.
    pub fn decide(&self) -> (Fate, String) {
        let Evidence { hold, held_time_s, .. } = *self;
        let end_s = hold.until_s;
        let grip = hold.grip.map(|grip| grip.since_s);
        let steady = grip.filter(|since_s| end_s - since_s >= held_time_s);
        let slides = self.slides();
        if let (Some(since_s), false) = (steady, slides) {
            return (Fate::Held, self.held(since_s));
        }
        if let Some((since_s, HoldState::Carried)) = hold.end_state()
            && end_s - since_s >= held_time_s
            && self.is_slow_in_base
        {
            return (Fate::Carried, format!("the hand carries it from {} on, without a grip", ms(since_s)));
        }
        if let Some(lifted) = hold.lifted
            && lifted.is_set_down
            && matches!(hold.end_state(), Some((_, HoldState::Resting)))
            && self.active(true) == 0
            && self.is_slow_in_world
        {
            let at = ms(lifted.until_s);
            return (Fate::Placed { until_s: lifted.until_s }, format!("released at {at}; it rests outside the hand"));
        }
        let past = hold.past.map(|past| past.until_s);
        if let Some(until_s) = past.or(steady.map(|_| end_s)) {
            return (Fate::Dropped { since_s: until_s }, self.dropped(until_s, slides));
        }
        match self.escaped_s {
            Some(at_s) => (
                Fate::Escaped { at_s },
                format!("left the hand at {} without having been gripped for {}", ms(at_s), ms(held_time_s)),
            ),
            None => (Fate::NotGrasped, self.not_grasped()),
        }
    }

    /// Number of active pairs of the hand, or of the surroundings.
    fn active(&self, is_hand: bool) -> usize {
        self.pairs.iter().filter(|pair| pair.is_hand == is_hand && pair.active_since_s.is_some()).count()
    }

    /// Whether every active pair of the hand slides faster than slow.
    fn slides(&self) -> bool {
        let mut active = self.pairs.iter().filter(|pair| pair.is_hand && pair.active_since_s.is_some()).peekable();
        active.peek().is_some() && active.all(|pair| pair.is_sliding)
    }

    fn held(&self, since_s: f64) -> String {
        let active = self.active(true);
        let pairs = if active == 1 { "1 pair" } else { &format!("{active} pairs") };
        let grip_n: f64 = self.pairs.iter().filter(|pair| pair.is_hand).map(|pair| pair.normal_n).sum();
        format!("gripped from {} on by {pairs} with {} in all", ms(since_s), newtons(grip_n))
    }

    fn dropped(&self, until_s: f64, slides: bool) -> String {
        let (hold, at) = (self.hold, ms(until_s));
        match (hold.grip, hold.end_state()) {
            (Some(grip), _) if slides => {
                format!("gripped from {} on, but every pair of the hand slides at the end", ms(grip.since_s))
            }
            (Some(grip), _) => {
                let (again, required) = (ms(grip.since_s), ms(self.held_time_s));
                format!("no longer gripped from {at} on; gripped again only from {again} on, less than {required}")
            }
            (None, Some((_, HoldState::Resting))) => match (hold.lifted, self.active(true)) {
                (None, _) => format!("no longer gripped from {at} on; it never left its surroundings for {}", {
                    ms(self.held_time_s)
                }),
                (Some(lifted), _) if !lifted.is_set_down => {
                    format!("no longer gripped from {at} on; it fell for more than {}", ms(self.held_time_s))
                }
                (Some(_), 0) => {
                    let [_, speed] = self.speeds_m_s;
                    format!("no longer gripped from {at} on; it still moves at {}", mm_s(speed))
                }
                (Some(_), _) => format!("no longer gripped from {at} on; the hand still presses on it"),
            },
            (None, Some((_, HoldState::Carried))) => {
                let [speed, _] = self.speeds_m_s;
                format!("no longer gripped from {at} on; it moves in the hand at {}", mm_s(speed))
            }
            (None, _) => match self.escaped_s {
                Some(left_s) => format!("no longer gripped from {at} on; it left the hand at {}", ms(left_s)),
                None => format!("no longer gripped from {at} on"),
            },
        }
    }

    fn not_grasped(&self) -> String {
        let (hold, required) = (self.hold, ms(self.held_time_s));
        let touched = self.pairs.iter().filter(|pair| pair.is_hand && pair.first_s.is_some()).count();
        let rest = match hold.end_state() {
            Some((_, HoldState::Resting)) => "it rests outside the hand",
            Some((_, HoldState::Carried)) => "the hand touches it at the end, but does not grip it",
            Some((_, HoldState::Free)) => "nothing touches it at the end",
            Some((_, HoldState::Gripped)) | None => "",
        };
        match (hold.grip, hold.first_gripped_s, touched) {
            (Some(grip), ..) => format!("gripped only from {} on, less than {required}", ms(grip.since_s)),
            (None, Some(first_s), _) => format!("gripped from {} on for less than {required}; {rest}", ms(first_s)),
            (None, None, 0) => "the hand never touched it".to_string(),
            (None, None, 1) => format!("never gripped: only 1 pair of the hand touched it; {rest}"),
            (None, None, count) => {
                format!("never gripped: {count} pairs of the hand touched it, but did not press from all sides; {rest}")
            }
        }
    }
}

fn ms(time_s: f64) -> String {
    let [milliseconds] = [time_s * 1e3].map(|time| significant(time, 6));
    format!("{milliseconds} ms")
}

fn newtons(force_n: f64) -> String {
    format!("{} N", significant(force_n, 3))
}

fn mm_s(speed_m_s: f64) -> String {
    format!("{} mm/s", significant(speed_m_s * 1e3, 3))
}

/// A number with this number of significant digits, without trailing zeros.
fn significant(value: f64, digits: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    format!("{rounded}")
}
