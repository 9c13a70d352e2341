//! The criteria found while a run streams by.

use super::hermite::Hermite;
use super::{Class, Criteria, EPSILON_RAD, rebound_percent};
use crate::trace::{ContactSample, Event, EventKind, Sample, Sink, SinkError, Site};

/// The two angles of the geometric final configuration, in which both phalanges touch the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinalAngles {
    pub q11_rad: f64,
    pub q21_rad: f64,
}

/// A [`Sink`] that finds the [`Criteria`] of a run, in constant memory.
///
/// Between two samples the angles follow the cubic Hermite interpolant of values and rates; the times at which they
/// cross ±ε are found to 1e-9 s. Contacts change at the times of their events. Within a contact the normal force counts
/// as positive between two samples if it is positive at both; the zero at the very touch-down does not count against
/// it.
#[derive(Clone, Debug)]
pub struct Tracker {
    target: FinalAngles,
    last: Option<Sample>,
    contacts: [ContactState; 2],
    /// Contact changes since the last sample.
    events: Vec<Event>,
    /// Ends of the pieces of the step at hand, reused.
    cuts: Vec<f64>,
    t_geo_s: Option<f64>,
    stable_since_s: Option<f64>,
    lost_s: f64,
}

/// What is known of one contact.
#[derive(Clone, Copy, Debug, Default)]
struct ContactState {
    closed: bool,
    /// Has ever been closed.
    touched: bool,
    /// A positive force has been seen since the touch-down.
    pressed: bool,
    /// Normal force at the last sample was zero although the contact had been pressed: the clamp of the normal law.
    slack: bool,
}

impl ContactState {
    fn touch_down(&mut self) {
        *self = ContactState {
            closed: true,
            touched: true,
            // A contact that is known to be closed already stays what it is.
            pressed: self.closed && self.pressed,
            slack: self.closed && self.slack,
        };
    }

    fn lift_off(&mut self) {
        *self = ContactState { touched: true, ..ContactState::default() };
    }

    /// Takes the force of a sample.
    fn press(&mut self, normal_n: f64) {
        if normal_n > 0.0 {
            self.closed = true;
            self.touched = true;
            self.pressed = true;
            self.slack = false;
        } else {
            self.slack = self.closed && self.pressed;
        }
    }
}

impl Tracker {
    pub fn new(target: FinalAngles) -> Self {
        Tracker {
            target,
            last: None,
            contacts: Default::default(),
            events: Vec::new(),
            cuts: Vec::new(),
            t_geo_s: None,
            stable_since_s: None,
            lost_s: 0.0,
        }
    }

    /// The criteria of the run up to the last sample. `statically_stable`: whether the static forces of the grasp are
    /// positive (thesis (2.32)); `true` if that is judged elsewhere.
    pub fn criteria(&self, statically_stable: bool) -> Criteria {
        let rebound_percent = match (self.t_geo_s, self.stable_since_s, &self.last) {
            (Some(t_geo_s), Some(tts_s), Some(last)) => Some(rebound_percent(t_geo_s, tts_s, last.time_s, self.lost_s)),
            _ => None,
        };
        Criteria {
            t_geo_s: self.t_geo_s,
            tts_s: self.stable_since_s,
            lost_s: self.lost_s,
            rebound_percent,
            statically_stable,
            class: Class::of(self.stable_since_s, rebound_percent, statically_stable),
        }
    }

    fn start(&mut self, sample: &Sample) {
        for (state, contact) in self.contacts.iter_mut().zip(&sample.contacts) {
            if contact.gap_m < 0.0 {
                state.touch_down();
            }
        }
        self.press(sample);
    }

    fn press(&mut self, sample: &Sample) {
        for (state, contact) in self.contacts.iter_mut().zip(&sample.contacts) {
            state.press(contact.normal_n);
        }
    }

    /// The step from the last sample to `next`.
    fn step(&mut self, last: &Sample, next: &Sample) {
        let ([from, to], [t0, t1]) = ([last.finger(), next.finger()], [last.time_s, next.time_s]);
        let q11 = Hermite::new((t0, from.q11_rad, from.qd11_rad_s), (t1, to.q11_rad, to.qd11_rad_s));
        let q21 = Hermite::new((t0, from.q21_rad, from.qd21_rad_s), (t1, to.q21_rad, to.qd21_rad_s));
        let mut cuts = std::mem::take(&mut self.cuts);
        cuts.clear();
        for (angle, target) in [(&q11, self.target.q11_rad), (&q21, self.target.q21_rad)] {
            angle.crossings(target - EPSILON_RAD, &mut cuts);
            angle.crossings(target + EPSILON_RAD, &mut cuts);
        }
        cuts.extend(self.events.iter().map(|event| event.time_s.clamp(last.time_s, next.time_s)));
        cuts.push(next.time_s);
        cuts.sort_by(f64::total_cmp);

        let events = std::mem::take(&mut self.events);
        let mut pending = events.iter().peekable();
        let mut from = last.time_s;
        for &to in &cuts {
            while let Some(event) = pending.next_if(|event| event.time_s <= from) {
                self.change(event);
            }
            if to > from {
                let middle = 0.5 * (from + to);
                let in_position = (q11.value(middle) - self.target.q11_rad).abs() <= EPSILON_RAD
                    && (q21.value(middle) - self.target.q21_rad).abs() <= EPSILON_RAD;
                let lifts_off =
                    |site| pending.clone().any(|event| event.site() == site && event.kind == EventKind::LiftOff);
                let positive =
                    [Site::Proximal, Site::Distal].map(|site| self.positive(site, next.contact(site), lifts_off(site)));
                self.judge(from, to, in_position, positive);
                from = to;
            }
        }
        for event in pending {
            self.change(event);
        }
        self.events = events;
        self.events.clear();
        self.cuts = cuts;
        self.press(next);
    }

    fn change(&mut self, event: &Event) {
        let state = match event.site() {
            Site::Proximal => &mut self.contacts[0],
            Site::Distal => &mut self.contacts[1],
            Site::Limit => return,
        };
        match event.kind {
            EventKind::TouchDown | EventKind::Reload => state.touch_down(),
            EventKind::LiftOff => state.lift_off(),
        }
    }

    /// Whether the normal force is positive on the way to a sample: closed, pressed at the last sample (or just touched
    /// down), and pressed at the next one (or about to lift off before it).
    fn positive(&self, site: Site, end: &ContactSample, lifts_off: bool) -> bool {
        let state = &self.contacts[site as usize];
        state.closed && !state.slack && (end.normal_n > 0.0 || lifts_off)
    }

    /// Counts one piece of time in which nothing changes.
    fn judge(&mut self, from: f64, to: f64, in_position: bool, positive: [bool; 2]) {
        if in_position {
            self.t_geo_s.get_or_insert(from);
        }
        if in_position && positive == [true; 2] {
            self.stable_since_s.get_or_insert(from);
            return;
        }
        self.stable_since_s = None;
        let off = self.contacts.iter().zip(positive).any(|(state, positive)| state.touched && !positive);
        if self.t_geo_s.is_some() && (!in_position || off) {
            self.lost_s += to - from;
        }
    }
}

impl Sink for Tracker {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let Some(mut last) = self.last.take() else {
            self.start(sample);
            self.last = Some(sample.clone());
            return Ok(());
        };
        if sample.time_s > last.time_s {
            self.step(&last, sample);
        } else {
            // A second sample of the same instant (before and after an event): the later one holds.
            let events = std::mem::take(&mut self.events);
            for event in &events {
                self.change(event);
            }
            self.press(sample);
        }
        last.clone_from(sample);
        self.last = Some(last);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if event.site() != Site::Limit {
            self.events.push(*event);
        }
        Ok(())
    }
}
