//! The criteria found while a run streams by.

use super::hermite::Hermite;
use super::pieces::{Judge, Piece, Pieces};
use super::{Class, Criteria, EPSILON_RAD, rebound_percent};
use crate::trace::{Event, Sample, Sink, SinkError, Wants};

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
    pieces: Pieces<2>,
    found: Found,
}

/// What the pieces so far have said.
#[derive(Clone, Debug)]
struct Found {
    target: FinalAngles,
    t_geo_s: Option<f64>,
    stable_since_s: Option<f64>,
    lost_s: f64,
}

impl Tracker {
    pub fn new(target: FinalAngles) -> Self {
        let found = Found { target, t_geo_s: None, stable_since_s: None, lost_s: 0.0 };
        Tracker { pieces: Pieces::default(), found }
    }

    /// The criteria of the run up to the last sample. `statically_stable`: whether the static forces of the grasp are
    /// positive (thesis (2.32)); `true` if that is judged elsewhere.
    pub fn criteria(&self, statically_stable: bool) -> Criteria {
        let Found { t_geo_s, stable_since_s, lost_s, .. } = self.found;
        let rebound_percent = match (t_geo_s, stable_since_s, self.pieces.last()) {
            (Some(t_geo_s), Some(tts_s), Some(last)) => Some(rebound_percent(t_geo_s, tts_s, last.time_s, lost_s)),
            _ => None,
        };
        Criteria {
            t_geo_s,
            tts_s: stable_since_s,
            lost_s,
            rebound_percent,
            statically_stable,
            class: Class::of(stable_since_s, rebound_percent, statically_stable),
        }
    }
}

/// Of the proximal and the distal phalanx: the first two of a finger's contacts.
impl Judge<2> for Found {
    /// q11 and q21.
    type Path = [Hermite; 2];

    fn begin(&mut self, _: &Sample) {}

    fn path(&self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> [Hermite; 2] {
        let ([from, to], [t0, t1]) = ([last.finger(), next.finger()], [last.time_s, next.time_s]);
        let q11 = Hermite::new((t0, from.q11_rad, from.qd11_rad_s), (t1, to.q11_rad, to.qd11_rad_s));
        let q21 = Hermite::new((t0, from.q21_rad, from.qd21_rad_s), (t1, to.q21_rad, to.qd21_rad_s));
        for (angle, target) in [(&q11, self.target.q11_rad), (&q21, self.target.q21_rad)] {
            angle.crossings(target - EPSILON_RAD, cuts_s);
            angle.crossings(target + EPSILON_RAD, cuts_s);
        }
        [q11, q21]
    }

    fn judge(&mut self, [q11, q21]: &[Hermite; 2], piece: &Piece<2>) {
        let middle = 0.5 * (piece.from_s + piece.to_s);
        let in_position = (q11.value(middle) - self.target.q11_rad).abs() <= EPSILON_RAD
            && (q21.value(middle) - self.target.q21_rad).abs() <= EPSILON_RAD;
        if in_position {
            self.t_geo_s.get_or_insert(piece.from_s);
        }
        if in_position && piece.pressing == [true; 2] {
            self.stable_since_s.get_or_insert(piece.from_s);
            return;
        }
        self.stable_since_s = None;
        let off = piece.touched.iter().zip(piece.pressing).any(|(touched, pressing)| *touched && !pressing);
        if self.t_geo_s.is_some() && (!in_position || off) {
            self.lost_s += piece.to_s - piece.from_s;
        }
    }
}

impl Sink for Tracker {
    fn wants(&self) -> Wants {
        Wants { energies: false, passive: false, peaks: true }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.pieces.sample(sample, &mut self.found);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.pieces.event(event);
        Ok(())
    }
}
