//! The criteria found while a run streams by.

use super::hermite::Hermite;
use super::pieces::{Judge, Piece, Pieces};
use super::reason::{is_in_position, is_positive};
use super::{AtEnd, ClassReason, Condition, Criteria, EPSILON_RAD, Loss, RESOLUTION_S, rebound_percent};
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
    /// In the order of [`Condition::ALL`].
    conditions: [History; 4],
    /// |q11 − q11,f| and |q21 − q21,f| in the middle of the last piece, rad, by which that is judged; `None` without a piece.
    off_rad: Option<[f64; 2]>,
}

/// One condition of stability through the run.
#[derive(Clone, Copy, Debug, Default)]
struct History {
    /// When it was first met; of a phalanx, when it first touched.
    first_s: Option<f64>,
    holds: bool,
    times_lost: u32,
    /// Start and end of the last loss, the end while it lasts that of the last piece.
    lost_s: Option<[f64; 2]>,
}

impl History {
    /// Takes a piece of the run. `met`: in position in this piece, or touched so far.
    fn take(&mut self, [from_s, to_s]: [f64; 2], met: bool, holds: bool) {
        if met {
            self.first_s.get_or_insert(from_s);
        }
        if !holds && self.first_s.is_some() {
            match &mut self.lost_s {
                Some([_, until_s]) if !self.holds => *until_s = to_s,
                lost_s => {
                    *lost_s = Some([from_s, to_s]);
                    self.times_lost = self.times_lost.saturating_add(1);
                }
            }
        }
        self.holds = holds;
    }

    fn at_end(&self) -> AtEnd {
        match (self.holds, self.lost_s) {
            (true, _) => AtEnd::Presses,
            (false, Some([at_s, _])) => AtEnd::LiftedOff { at_s },
            (false, None) => AtEnd::NeverTouched,
        }
    }
}

impl Tracker {
    pub fn new(target: FinalAngles) -> Self {
        let found = Found {
            target,
            t_geo_s: None,
            stable_since_s: None,
            lost_s: 0.0,
            conditions: Default::default(),
            off_rad: None,
        };
        Tracker { pieces: Pieces::default(), found }
    }

    /// The criteria of the run up to the last sample; `None` of a run without duration. `static_forces_n`: normal forces of both
    /// phalanges in the grasp at rest (thesis (2.32)), N; `None` where these are not known or judged elsewhere.
    pub fn criteria(&self, static_forces_n: Option<[f64; 2]>) -> Option<Criteria> {
        let Found { t_geo_s, stable_since_s, lost_s, off_rad, .. } = self.found;
        let (last, judged_rad) = (self.pieces.last()?, off_rad?);
        let off_rad = self.found.off_rad(last.finger().q11_rad, last.finger().q21_rad);
        // A crossing of the band's edge at the very end does not change how the last piece was judged.
        let off_rad = [0, 1].map(|joint| match is_in_position(off_rad[joint]) == is_in_position(judged_rad[joint]) {
            true => off_rad[joint],
            false => judged_rad[joint],
        });
        let rebound_percent =
            t_geo_s.zip(stable_since_s).map(|(t_geo_s, tts_s)| rebound_percent(t_geo_s, tts_s, last.time_s, lost_s));
        let pulls = static_forces_n.filter(|forces_n| !is_positive(forces_n));
        let class_reason = match (pulls, stable_since_s.zip(rebound_percent)) {
            (Some(forces_n), _) => ClassReason::StaticForces { forces_n },
            (None, Some((tts_s, rebound_percent))) => {
                ClassReason::Settled { tts_s, rebound_percent, loss: self.found.last_loss() }
            }
            (None, None) if off_rad.into_iter().all(is_in_position) => {
                let [_, _, proximal, tip] = &self.found.conditions;
                ClassReason::NotPressing { phalanges: [proximal, tip].map(History::at_end) }
            }
            (None, None) => ClassReason::OutOfPosition { off_rad },
        };
        Some(Criteria {
            t_geo_s,
            tts_s: stable_since_s,
            lost_s,
            rebound_percent,
            statically_stable: pulls.is_none(),
            class: class_reason.class(),
            class_reason,
        })
    }
}

impl Found {
    fn off_rad(&self, q11_rad: f64, q21_rad: f64) -> [f64; 2] {
        [(q11_rad - self.target.q11_rad).abs(), (q21_rad - self.target.q21_rad).abs()]
    }

    /// The loss that ended last, if it is one that counts as a rebound.
    fn last_loss(&self) -> Option<Loss> {
        let t_geo_s = self.t_geo_s.filter(|_| self.lost_s >= RESOLUTION_S)?;
        let [_, _, proximal, tip] = &self.conditions;
        let tip_first = tip.first_s.zip(proximal.first_s).is_some_and(|(tip_s, proximal_s)| tip_s < proximal_s);
        let losses = Condition::ALL.into_iter().zip(&self.conditions).filter_map(|(of, history)| {
            let [from_s, until_s] = history.lost_s?;
            let touched_first = of == Condition::Tip && tip_first;
            Some(Loss { of, from_s, until_s, times: history.times_lost, touched_first, all_s: self.lost_s })
        });
        losses.filter(|loss| loss.until_s > t_geo_s).max_by(|a, b| a.until_s.total_cmp(&b.until_s))
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
        let off_rad = self.off_rad(q11.value(middle), q21.value(middle));
        self.off_rad = Some(off_rad);
        let ([q11_in, q21_in], [proximal, tip]) = (off_rad.map(is_in_position), piece.pressing);
        let in_position = q11_in && q21_in;
        let met = [q11_in, q21_in, piece.touched[0], piece.touched[1]];
        for ((history, met), holds) in self.conditions.iter_mut().zip(met).zip([q11_in, q21_in, proximal, tip]) {
            history.take([piece.from_s, piece.to_s], met, holds);
        }
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
