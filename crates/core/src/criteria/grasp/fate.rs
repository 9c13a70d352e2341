//! The fate of an object, with its reason.

use super::hold::{HoldHistory, HoldState};
use super::pairs::PairCriteria;

/// Fate of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// The object is gripped at the end, or at the release, and has been gripped for at least the time that the scene
    /// requires.
    Held,
    /// The hand carries the object without a grip.
    Carried,
    /// The hand lifted the object and released it at `until_s`, and it rests outside the hand.
    Placed { until_s: f64 },
    /// The object was gripped for the required time, for the last time until `since_s`. An object that is lost, gripped
    /// again and held at the end is not dropped. The travel does not matter.
    Dropped { since_s: f64 },
    /// The object left the region that the fingers of a five-bar hand can reach ([`Reach`](crate::trace::Reach)) at
    /// `at_s`, after a contact. The run ends there.
    Ejected { at_s: f64 },
    /// An object that was never gripped for the required time left the hand at `at_s`, after a contact.
    Escaped { at_s: f64 },
    /// None of the other fates.
    NotGrasped,
}

impl Fate {
    /// Names of all fates, from best to worst.
    pub const NAMES: [&str; 7] = ["held", "carried", "placed", "dropped", "ejected", "escaped", "not grasped"];

    /// Returns the name in results and reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[match self {
            Fate::Held => 0,
            Fate::Carried => 1,
            Fate::Placed { .. } => 2,
            Fate::Dropped { .. } => 3,
            Fate::Ejected { .. } => 4,
            Fate::Escaped { .. } => 5,
            Fate::NotGrasped => 6,
        }]
    }

    /// Returns the time since which the object has not been held, or at which it left the hand, s; `None` for other
    /// fates.
    pub fn lost_at_s(self) -> Option<f64> {
        match self {
            Fate::Dropped { since_s } => Some(since_s),
            Fate::Placed { until_s } => Some(until_s),
            Fate::Ejected { at_s } | Fate::Escaped { at_s } => Some(at_s),
            Fate::Held | Fate::Carried | Fate::NotGrasped => None,
        }
    }
}

/// Figures that decide a fate.
pub(super) struct Evidence<'a> {
    pub hold: &'a HoldHistory,
    pub held_time_s: f64,
    pub pairs: &'a [PairCriteria],
    /// Whether the object is slow in the frame of the base.
    pub is_slow_in_base: bool,
    /// Whether the object is slow in the world.
    pub is_slow_in_world: bool,
    /// Speeds of the centre of the object in the frame of the base and in the world, m/s.
    pub speeds_m_s: [f64; 2],
    /// Time at which the object left the hand, s.
    pub escaped_s: Option<f64>,
    /// Time at which the object left the reach of the fingers of a five-bar hand, s.
    pub ejected_s: Option<f64>,
}

impl Evidence<'_> {
    /// Returns the fate and its reason.
    pub fn decide(&self) -> (Fate, String) {
        let Evidence { hold, held_time_s, .. } = *self;
        if let Some(at_s) = self.ejected_s {
            return (Fate::Ejected { at_s }, format!("out of the reach of both fingers at {}", ms(at_s)));
        }
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
            return (
                Fate::Placed { until_s: lifted.until_s },
                format!("released at {at}; it lies on its surroundings"),
            );
        }
        let past = hold.past.map(|past| past.until_s);
        if let Some(until_s) = steady.map(|_| end_s).or(past) {
            return (Fate::Dropped { since_s: until_s }, self.dropped(until_s, steady.is_some()));
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

    fn dropped(&self, until_s: f64, is_steady: bool) -> String {
        let (hold, at) = (self.hold, ms(until_s));
        match (hold.grip, hold.end_state()) {
            (Some(grip), _) if is_steady => {
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
            (None, Some((since_s, HoldState::Carried))) => {
                format!("no longer gripped from {at} on; {}", self.not_carried(since_s))
            }
            (None, _) => match self.escaped_s {
                Some(left_s) => format!("no longer gripped from {at} on; it left the hand at {}", ms(left_s)),
                None => format!("no longer gripped from {at} on"),
            },
        }
    }

    /// Reason why an object in the state `carried` since a time is not carried: too short a time, or its speed.
    fn not_carried(&self, since_s: f64) -> String {
        let [speed, _] = self.speeds_m_s;
        match self.hold.until_s - since_s >= self.held_time_s {
            true => format!("it moves in the hand at {}", mm_s(speed)),
            false => format!("the hand carries it only from {} on, less than {}", ms(since_s), ms(self.held_time_s)),
        }
    }

    fn not_grasped(&self) -> String {
        let (hold, required) = (self.hold, ms(self.held_time_s));
        let touched = self.pairs.iter().filter(|pair| pair.is_hand && pair.first_s.is_some()).count();
        let rest = match hold.end_state() {
            Some((_, HoldState::Resting)) => "it lies on its surroundings".to_string(),
            Some((since_s, HoldState::Carried)) => self.not_carried(since_s),
            Some((_, HoldState::Free)) => "nothing touches it at the end".to_string(),
            Some((_, HoldState::Gripped)) | None => String::new(),
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

#[cfg(test)]
mod tests {
    use super::super::hold::Part;
    use super::super::pose::RelativePose;
    use super::*;

    const HELD_S: f64 = 1.0;

    /// History of parts that last up to their times: gripped, hand near, surroundings near and active.
    fn history(parts: &[(f64, bool, bool, bool)]) -> HoldHistory {
        let mut history = HoldHistory::new(0.1, HELD_S);
        let mut from_s = 0.0;
        for &(to_s, is_gripped, is_hand_near, touches) in parts {
            let pose = RelativePose::default();
            let (are_surroundings_near, are_surroundings_active) = (touches, touches);
            history.add(&Part {
                from_s,
                to_s,
                is_gripped,
                is_hand_near,
                are_surroundings_near,
                are_surroundings_active,
                pose,
            });
            from_s = to_s;
        }
        history
    }

    /// An active pair of the hand.
    fn pair(is_sliding: bool) -> PairCriteria {
        PairCriteria {
            name: "pad/object".to_string(),
            is_hand: true,
            first_s: Some(0.0),
            active_since_s: Some(0.0),
            times_lost: 0,
            lost_s: 0.0,
            gap_m: None,
            normal_n: 1.0,
            friction_n: 0.0,
            friction_used: None,
            pressure_centre_m: None,
            points: Vec::new(),
            is_sliding,
        }
    }

    fn decide(hold: &HoldHistory, is_sliding: bool, is_slow: bool) -> (Fate, String) {
        Evidence {
            hold,
            held_time_s: HELD_S,
            pairs: &[pair(is_sliding)],
            is_slow_in_base: is_slow,
            is_slow_in_world: is_slow,
            speeds_m_s: [0.5, 0.25],
            escaped_s: None,
            ejected_s: None,
        }
        .decide()
    }

    #[test]
    fn the_last_of_two_grips_that_slides_is_lost_at_the_end() {
        let hold = history(&[(2.0, true, true, false), (3.0, false, true, false), (5.0, true, true, false)]);
        let (fate, reason) = decide(&hold, true, true);
        assert_eq!(fate, Fate::Dropped { since_s: 5.0 });
        assert_eq!(reason, "gripped from 3000 ms on, but every pair of the hand slides at the end");
        assert_eq!(decide(&hold, false, true).0, Fate::Held);
        // A last grip that is too short is none.
        let hold = history(&[(2.0, true, true, false), (3.0, false, true, false), (3.5, true, true, false)]);
        let (fate, reason) = decide(&hold, true, true);
        assert_eq!(fate, Fate::Dropped { since_s: 2.0 });
        assert!(reason.ends_with("gripped again only from 3000 ms on, less than 1000 ms"), "{reason}");
    }

    #[test]
    fn a_slow_object_is_not_carried_because_of_the_time() {
        let short = [(2.0, true, true, false), (2.5, false, true, false)];
        let (fate, reason) = decide(&history(&short), false, true);
        assert_eq!(fate, Fate::Dropped { since_s: 2.0 });
        assert!(reason.ends_with("the hand carries it only from 2000 ms on, less than 1000 ms"), "{reason}");
        let long = [(2.0, true, true, false), (3.5, false, true, false)];
        assert_eq!(decide(&history(&long), false, true).0, Fate::Carried);
        let (_, reason) = decide(&history(&long), false, false);
        assert!(reason.ends_with("it moves in the hand at 500 mm/s"), "{reason}");
        // Never gripped.
        let (fate, reason) = decide(&history(&[(0.5, false, true, false)]), false, true);
        assert_eq!(fate, Fate::NotGrasped);
        assert!(reason.ends_with("the hand carries it only from 0 ms on, less than 1000 ms"), "{reason}");
        let (_, reason) = decide(&history(&[(2.0, false, true, true)]), false, true);
        assert!(reason.ends_with("it lies on its surroundings"), "{reason}");
    }
}
