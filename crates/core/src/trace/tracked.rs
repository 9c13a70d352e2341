//! One place of contact of the engine model through time: from the changes a step reports to events and summary figures.

use super::slipping::Slipping;
use super::{ContactSummary, EventKind};
use crate::engine::ChangeKind;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tracked {
    pub summary: ContactSummary,
    pub touching: bool,
    pub pressing: bool,
    /// Whether the force has ended since the last touch-down.
    released: bool,
    /// Impulse up to the start of the present step, and at the last touch-down.
    pub impulse: f64,
    at_touchdown: f64,
    slipping: Slipping,
}

/// What a change is to whoever watches: `approach` at a touch-down, `impulse` at a lift-off, 0 otherwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told {
    pub kind: EventKind,
    pub approach: f64,
    pub impulse: f64,
}

impl Tracked {
    /// Takes a change over; `impulse` is that of the present step up to here. `None` where it is no event.
    pub fn change(&mut self, kind: ChangeKind, time_s: f64, closing: f64, impulse: f64) -> Option<Told> {
        let so_far = self.impulse + impulse;
        let mut told = Told { kind: EventKind::TouchDown, approach: 0.0, impulse: 0.0 };
        match kind {
            ChangeKind::Meets if !self.touching => {
                (self.touching, self.released, self.at_touchdown) = (true, false, so_far);
                told.approach = closing;
                self.summary.first_s.get_or_insert(time_s);
                self.summary.touchdowns += 1;
            }
            ChangeKind::Slips => return self.slip(Some(true)),
            ChangeKind::Sticks => return self.slip(Some(false)),
            ChangeKind::LetsGo if self.pressing => {
                (self.pressing, self.released) = (false, true);
                self.slip(None);
                (told.kind, told.impulse) = (EventKind::LiftOff, so_far - self.at_touchdown);
            }
            ChangeKind::Presses if !self.pressing => {
                self.pressing = true;
                if !self.released {
                    return None;
                }
                self.released = false;
                told.kind = EventKind::Reload;
            }
            ChangeKind::Parts => {
                self.touching = false;
                return None;
            }
            _ => return None,
        }
        Some(told)
    }

    /// Takes over what its friction does, if it presses and holds.
    pub fn slip(&mut self, slips: Option<bool>) -> Option<Told> {
        let kind = self.slipping.change(slips, &mut self.summary)?;
        Some(Told { kind, approach: 0.0, impulse: 0.0 })
    }

    /// Adds the impulse of a step.
    pub fn add_step(&mut self, impulse: f64) {
        self.impulse += impulse;
        self.summary.impulse_n_s = self.impulse;
    }

    /// The change that fell between two steps: a force that is there at the end of one, and was not, or the other way round.
    pub fn unnoticed(&self, force: f64) -> Option<ChangeKind> {
        match (self.pressing, force > 0.0) {
            (true, false) => Some(ChangeKind::LetsGo),
            (false, true) => Some(ChangeKind::Presses),
            _ => None,
        }
    }
}
