//! Intervals in which the object is gripped, carried, resting or free.

use serde::Serialize;

use super::pose::RelativePose;

/// How the object is held at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HoldState {
    /// Contacts of the hand press on the object from all sides: the origin is in the convex hull of their wrenches.
    Gripped,
    /// The hand touches the object, and nothing else does.
    Carried,
    /// Something other than the hand touches the object.
    Resting,
    /// Nothing touches the object.
    Free,
}

impl HoldState {
    pub fn name(self) -> &'static str {
        match self {
            HoldState::Gripped => "gripped",
            HoldState::Carried => "carried",
            HoldState::Resting => "resting",
            HoldState::Free => "free",
        }
    }
}

/// A part of the run in which nothing changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub from_s: f64,
    pub to_s: f64,
    pub is_gripped: bool,
    pub is_hand_near: bool,
    pub are_surroundings_near: bool,
    pub are_surroundings_active: bool,
    /// Pose of the object in the frame of the base at the start of the part.
    pub pose: RelativePose,
}

/// The current interval in which the object is gripped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grip {
    pub since_s: f64,
    pub pose: RelativePose,
    /// Whether, for long enough, nothing but the hand pressed on the object.
    pub is_lifted: bool,
}

/// An interval in which the object was gripped for long enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PastGrip {
    pub since_s: f64,
    pub until_s: f64,
}

/// The end of a grip that was lifted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lifted {
    pub until_s: f64,
    /// Whether the surroundings were near soon after this time.
    pub is_set_down: bool,
}

/// History of an object. Interruptions of a grip that are shorter than `loss_time_s` are none.
#[derive(Clone, Debug)]
pub(super) struct HoldHistory {
    loss_time_s: f64,
    held_time_s: f64,
    pub grip: Option<Grip>,
    /// Start of the current interruption.
    interrupted_s: Option<f64>,
    /// States during the current interruption.
    interruption: Vec<(f64, HoldState)>,
    unsupported_since_s: Option<f64>,
    pub first_gripped_s: Option<f64>,
    /// The last grip that has ended and was long enough.
    pub past: Option<PastGrip>,
    pub lifted: Option<Lifted>,
    /// Changes of the state with their times; the first entry is the state at the start.
    pub states: Vec<(f64, HoldState)>,
    pub until_s: f64,
}

impl HoldHistory {
    pub fn new(loss_time_s: f64, held_time_s: f64) -> Self {
        HoldHistory {
            loss_time_s,
            held_time_s,
            grip: None,
            interrupted_s: None,
            interruption: Vec::new(),
            unsupported_since_s: None,
            first_gripped_s: None,
            past: None,
            lifted: None,
            states: Vec::new(),
            until_s: 0.0,
        }
    }

    /// Adds the next part of the run.
    pub fn add(&mut self, part: &Part) {
        self.until_s = part.to_s;
        self.unsupported_since_s = match part.are_surroundings_active {
            true => None,
            false => self.unsupported_since_s.or(Some(part.from_s)),
        };
        if part.is_gripped {
            self.add_gripped(part);
        } else {
            self.add_other(part);
        }
    }

    fn add_gripped(&mut self, part: &Part) {
        self.interrupted_s = None;
        self.interruption.clear();
        let new = Grip { since_s: part.from_s, pose: part.pose, is_lifted: false };
        let grip = self.grip.get_or_insert(new);
        let since_s = grip.since_s.max(self.unsupported_since_s.unwrap_or(f64::INFINITY));
        grip.is_lifted |= part.to_s - since_s >= self.held_time_s;
        self.first_gripped_s.get_or_insert(grip.since_s);
        push(&mut self.states, part.from_s, HoldState::Gripped);
    }

    fn add_other(&mut self, part: &Part) {
        let state = match (part.is_hand_near, part.are_surroundings_near) {
            (_, true) => HoldState::Resting,
            (true, false) => HoldState::Carried,
            (false, false) => HoldState::Free,
        };
        if let Some(grip) = self.grip {
            let interrupted_s = *self.interrupted_s.get_or_insert(part.from_s);
            push(&mut self.interruption, part.from_s, state);
            if part.to_s - interrupted_s < self.loss_time_s {
                return;
            }
            self.grip = None;
            if interrupted_s - grip.since_s >= self.held_time_s {
                self.past = Some(PastGrip { since_s: grip.since_s, until_s: interrupted_s });
            }
            if grip.is_lifted {
                let is_set_down = self.interruption.iter().any(|(_, state)| *state == HoldState::Resting);
                self.lifted = Some(Lifted { until_s: interrupted_s, is_set_down });
            }
            let states = std::mem::take(&mut self.interruption);
            states.into_iter().for_each(|(time_s, state)| push(&mut self.states, time_s, state));
        } else {
            push(&mut self.states, part.from_s, state);
        }
        if let Some(lifted) = self.lifted.as_mut().filter(|lifted| part.from_s <= lifted.until_s + self.held_time_s) {
            lifted.is_set_down |= state == HoldState::Resting;
        }
    }

    /// State at the end, and the time since which it has lasted. An interruption that is not finished at the end is
    /// ignored.
    pub fn end_state(&self) -> Option<(f64, HoldState)> {
        self.states.last().copied()
    }
}

/// Appends a state, if it is a change.
fn push(states: &mut Vec<(f64, HoldState)>, time_s: f64, state: HoldState) {
    if states.last().is_none_or(|(_, last)| *last != state) {
        states.push((time_s, state));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOSS_S: f64 = 0.1;
    const HELD_S: f64 = 1.0;

    /// History of parts that last up to their times: gripped, hand near, surroundings near and active.
    fn history(parts: &[(f64, bool, bool, bool)]) -> HoldHistory {
        let mut history = HoldHistory::new(LOSS_S, HELD_S);
        let mut from_s = 0.0;
        for &(to_s, is_gripped, is_hand_near, touches) in parts {
            history.add(&Part {
                from_s,
                to_s,
                is_gripped,
                is_hand_near,
                are_surroundings_near: touches,
                are_surroundings_active: touches,
                pose: RelativePose::default(),
            });
            from_s = to_s;
        }
        history
    }

    #[test]
    fn a_short_interruption_is_none_also_at_the_end() {
        let found = history(&[(2.0, true, true, false), (2.05, false, true, false), (4.0, true, true, false)]);
        assert_eq!(found.states, [(0.0, HoldState::Gripped)]);
        assert_eq!(found.grip.map(|grip| grip.since_s), Some(0.0));
        let found = history(&[(2.0, true, true, false), (2.05, false, false, false)]);
        assert_eq!(found.end_state(), Some((0.0, HoldState::Gripped)));
        assert!(found.grip.is_some() && found.past.is_none());
    }

    #[test]
    fn a_long_interruption_ends_the_grip_where_it_began() {
        // The interruption is recognised in its second part.
        let parts = [(2.0, true, true, false), (2.08, false, true, false), (2.2, false, false, false)];
        let found = history(&parts);
        assert!(found.grip.is_none());
        assert_eq!(found.past, Some(PastGrip { since_s: 0.0, until_s: 2.0 }));
        let expected = [(0.0, HoldState::Gripped), (2.0, HoldState::Carried), (2.08, HoldState::Free)];
        assert_eq!(found.states, expected);
        // A grip that is too short is not one of the past.
        let found = history(&[(0.9, true, true, false), (2.0, false, false, false)]);
        assert!(found.past.is_none() && found.first_gripped_s == Some(0.0));
    }

    #[test]
    fn a_lifted_object_is_set_down_where_it_rests_soon_after_the_grip() {
        let lifted = |parts: &[(f64, bool, bool, bool)]| history(parts).lifted.map(|lifted| lifted.is_set_down);
        // Never without the table for long enough.
        assert_eq!(lifted(&[(0.5, true, true, true), (1.4, true, true, false), (4.0, false, true, true)]), None);
        let grip = [(0.5, true, true, true), (2.0, true, true, false)];
        // The table is there again before the end of the grip, at its end, soon after, and too late.
        let set_down = |more: &[(f64, bool, bool, bool)]| lifted(&[&grip[..], more].concat());
        assert_eq!(set_down(&[(3.0, true, true, true), (5.0, false, true, true)]), Some(true));
        assert_eq!(set_down(&[(5.0, false, false, true)]), Some(true));
        assert_eq!(set_down(&[(2.9, false, false, false), (5.0, false, false, true)]), Some(true));
        assert_eq!(set_down(&[(3.1, false, false, false), (5.0, false, false, true)]), Some(false));
    }
}
