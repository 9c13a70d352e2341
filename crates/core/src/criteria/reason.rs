//! Why a run has its class: the figure that decides, and its limit.

use std::fmt::{self, Display, Formatter};

use serde::{Serialize, Serializer};

use super::Class;
use super::formula::{EPSILON_RAD, SETTLED_WITHIN_S, SMALL_REBOUND_PERCENT, STABLE_WITHIN_S};

/// What decides the class of a finger. Pairs are of q11 and q21, or of the proximal phalanx and the tip (the distal phalanx).
///
/// Its text is the sentence that every report prints, without the name of the class; [`Criteria::verdict`](super::Criteria::verdict)
/// has that too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClassReason {
    /// At rest a phalanx would have to pull. Static normal forces, N; at least one is not 0 or more.
    StaticForces { forces_n: [f64; 2] },
    /// The run ends out of position. |q11 − q11,f| and |q21 − q21,f| at its end, rad; at least one is above [`EPSILON_RAD`].
    OutOfPosition { off_rad: [f64; 2] },
    /// The run ends in position, but a phalanx does not press.
    NotPressing { phalanges: [AtEnd; 2] },
    /// In position, and pressed by both phalanges from `tts_s` to the end of the run. `loss`: of the rebound, unless that is 0.
    Settled { tts_s: f64, rebound_percent: f64, loss: Option<Loss> },
}

/// A phalanx at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AtEnd {
    Presses,
    NeverTouched,
    /// Without normal force since this time.
    LiftedOff {
        at_s: f64,
    },
}

/// The last loss of a condition of stability before the run is stable for good.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    pub of: Condition,
    pub from_s: f64,
    pub until_s: f64,
    /// How often this condition was lost in the run.
    pub times: u32,
    /// Whether this is a phalanx that touched the object before the other did.
    pub touched_first: bool,
    /// Time lost to all rebounds, [`Criteria::lost_s`](super::Criteria::lost_s).
    pub all_s: f64,
}

/// The conditions of stability: both angles in position, both phalanges pressing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    Q11,
    Q21,
    Proximal,
    Tip,
}

impl Condition {
    pub const ALL: [Condition; 4] = [Condition::Q11, Condition::Q21, Condition::Proximal, Condition::Tip];
    const ANGLES: [Condition; 2] = [Condition::Q11, Condition::Q21];
    const PHALANGES: [Condition; 2] = [Condition::Proximal, Condition::Tip];

    fn name(self) -> &'static str {
        match self {
            Condition::Q11 => "q11",
            Condition::Q21 => "q21",
            Condition::Proximal => "the proximal phalanx",
            Condition::Tip => "the tip",
        }
    }
}

impl ClassReason {
    /// The class that follows from it.
    pub fn class(&self) -> Class {
        match *self {
            ClassReason::Settled { tts_s, rebound_percent, .. } => Class::of(Some(tts_s), Some(rebound_percent), true),
            _ => Class::of(None, None, !matches!(self, ClassReason::StaticForces { .. })),
        }
    }
}

/// As its sentence.
impl Serialize for ClassReason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Display for ClassReason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            ClassReason::StaticForces { forces_n } => static_forces(f, *forces_n),
            ClassReason::OutOfPosition { off_rad } => out_of_position(f, *off_rad),
            ClassReason::NotPressing { phalanges } => not_pressing(f, *phalanges),
            ClassReason::Settled { tts_s, rebound_percent, loss } => {
                settled(f, self.class(), *tts_s, *rebound_percent)?;
                loss.iter().try_for_each(|loss| write!(f, "; {loss}"))
            }
        }
    }
}

/// Force positiveness (thesis §1.2.3): no phalanx has to pull. A force that is not a number is not positive.
pub(super) fn is_positive(forces_n: &[f64]) -> bool {
    forces_n.iter().all(|force_n| *force_n >= 0.0)
}

fn static_forces(f: &mut Formatter<'_>, forces_n: [f64; 2]) -> fmt::Result {
    let pulls = || Condition::PHALANGES.iter().zip(forces_n).filter(|(_, force_n)| !is_positive(&[*force_n]));
    let names = pulls().map(|(of, _)| of.name()).collect::<Vec<_>>().join(" and ");
    let forces = pulls().map(|(_, force_n)| format!("{} N", figure(force_n, 0.0, 3))).collect::<Vec<_>>().join(" and ");
    match pulls().count() {
        1 => write!(f, "the static force on {names} is {forces}; it must not be negative"),
        _ => write!(f, "the static forces on {names} are {forces}; they must not be negative"),
    }
}

/// Whether an angle that is so far from that of the grasp is in position.
pub(super) fn is_in_position(off_rad: f64) -> bool {
    off_rad <= EPSILON_RAD
}

fn out_of_position(f: &mut Formatter<'_>, off_rad: [f64; 2]) -> fmt::Result {
    // Without the rounding of the conversion.
    let limit_deg = (EPSILON_RAD.to_degrees() * 1e9).round() / 1e9;
    let out = Condition::ANGLES.iter().zip(off_rad).filter(|(_, off_rad)| !is_in_position(*off_rad));
    let ends = out.map(|(of, off_rad)| format!("{} ends {}°", of.name(), figure(off_rad.to_degrees(), limit_deg, 3)));
    let ends = ends.collect::<Vec<_>>().join(" and ");
    write!(f, "{ends} from the grasp; at most {limit_deg}° count as in position")
}

fn not_pressing(f: &mut Formatter<'_>, phalanges: [AtEnd; 2]) -> fmt::Result {
    let off = Condition::PHALANGES.iter().zip(phalanges).filter_map(|(of, end)| match end {
        AtEnd::Presses => None,
        AtEnd::NeverTouched => Some(format!("{} has not touched the object", of.name())),
        AtEnd::LiftedOff { at_s } => {
            Some(format!("{} lifted off at {} for good", of.name(), milliseconds(at_s, f64::NAN)))
        }
    });
    write!(f, "{}; both phalanges must press at the end", off.collect::<Vec<_>>().join(" and "))
}

fn settled(f: &mut Formatter<'_>, class: Class, tts_s: f64, rebound_percent: f64) -> fmt::Result {
    let [stable, settled] = [STABLE_WITHIN_S, SETTLED_WITHIN_S].map(|limit_s| format!("{} ms", limit_s * 1e3));
    let late = |limit_s| milliseconds(tts_s, limit_s);
    let percent = figure(rebound_percent, SMALL_REBOUND_PERCENT, 2);
    match class {
        Class::Stable => write!(
            f,
            "both phalanges press in position from {} on, in less than {stable}, without a rebound",
            late(STABLE_WITHIN_S)
        ),
        Class::SemiStable => write!(f, "rebound {percent} %, at most {SMALL_REBOUND_PERCENT} %"),
        Class::SemiUnstable if tts_s < STABLE_WITHIN_S => {
            write!(f, "rebound {percent} %, more than {SMALL_REBOUND_PERCENT} %")
        }
        Class::SemiUnstable => {
            // Between two limits: as many digits as tell it from the nearer one.
            let nearer_s =
                if tts_s - STABLE_WITHIN_S < SETTLED_WITHIN_S - tts_s { STABLE_WITHIN_S } else { SETTLED_WITHIN_S };
            write!(
                f,
                "stable only after {}; semi-stable needs less than {stable}, the limit is {settled}",
                late(nearer_s)
            )
        }
        Class::Unstable => write!(f, "stable only after {}; the limit is {settled}", late(SETTLED_WITHIN_S)),
    }
}

/// Times lost are the same within this share: three digits are shown.
const SAME_LOSS: f64 = 5e-3;

impl Display for Loss {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let first = if self.touched_first { " touched first and" } else { "" };
        let lost = match self.of {
            Condition::Q11 | Condition::Q21 => "left its position",
            Condition::Proximal | Condition::Tip => "lifted off",
        };
        let times = if self.times > 1 { format!(" {} times, last", self.times) } else { String::new() };
        let [from, until] = apart([self.from_s * 1e3, self.until_s * 1e3], 3);
        write!(f, "{}{first} {lost}{times} at {from} ms, until {until} ms", self.of.name())?;
        // Another loss went before, or part of this one was before the finger was in position.
        match (self.all_s - (self.until_s - self.from_s)).abs() > SAME_LOSS * self.all_s {
            true => write!(f, "; {} lost since it was first in position", milliseconds(self.all_s, f64::NAN)),
            false => Ok(()),
        }
    }
}

fn milliseconds(time_s: f64, limit_s: f64) -> String {
    format!("{} ms", figure(time_s * 1e3, limit_s * 1e3, 3))
}

/// A number with `digits` significant digits, or with as many more as show on which side of a limit it is.
fn figure(value: f64, limit: f64, digits: usize) -> String {
    let side = |of: f64| of.partial_cmp(&limit);
    let shown = (digits..=17).map(|digits| rounded(value, digits));
    let tells = |text: &String| side(value).is_none() || text.parse().is_ok_and(|read: f64| side(read) == side(value));
    shown.into_iter().find(tells).unwrap_or_else(|| value.to_string())
}

/// Two different numbers with `digits` significant digits, or with as many more as tell them apart.
fn apart(values: [f64; 2], digits: usize) -> [String; 2] {
    let mut shown = (digits..=17).map(|digits| values.map(|value| rounded(value, digits)));
    shown.find(|[one, other]| one != other).unwrap_or_else(|| values.map(|value| value.to_string()))
}

/// A number with so many significant digits, without zeros behind the point.
fn rounded(value: f64, digits: usize) -> String {
    let scientific = format!("{value:.*e}", digits - 1);
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok());
    match exponent {
        Some(exponent @ -4..6) => {
            let text = format!("{value:.*}", usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0));
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
                false => text,
            }
        }
        _ => scientific,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(reason: ClassReason) -> String {
        format!("{}: {reason}", reason.class().name())
    }

    fn settled(tts_s: f64, rebound_percent: f64, loss: Option<Loss>) -> String {
        verdict(ClassReason::Settled { tts_s, rebound_percent, loss })
    }

    #[test]
    fn every_sentence_has_its_figure_and_its_limit() {
        let tip =
            Loss { of: Condition::Tip, from_s: 7.1e-3, until_s: 8.2e-3, times: 1, touched_first: true, all_s: 1.1e-3 };
        let often = Loss { of: Condition::Proximal, times: 3, touched_first: false, all_s: 2.3e-3, ..tip };
        let q21 = Loss { of: Condition::Q21, touched_first: false, ..tip };
        let off_rad = [0.1f64.to_radians(), 0.249f64.to_radians()];
        let both = [0.3f64.to_radians(), 0.249f64.to_radians()];
        let lifted = [AtEnd::Presses, AtEnd::LiftedOff { at_s: 18.2e-3 }];
        let neither = [AtEnd::LiftedOff { at_s: 18.2e-3 }, AtEnd::NeverTouched];
        for (said, expected) in [
            (
                verdict(ClassReason::StaticForces { forces_n: [-1.2, 3.0] }),
                "unstable: the static force on the proximal phalanx is -1.2 N; it must not be negative",
            ),
            (
                verdict(ClassReason::StaticForces { forces_n: [-1.2, -30.0] }),
                "unstable: the static forces on the proximal phalanx and the tip are -1.2 N and -30 N; they must not be negative",
            ),
            (
                verdict(ClassReason::OutOfPosition { off_rad }),
                "unstable: q21 ends 0.249° from the grasp; at most 0.2° count as in position",
            ),
            (
                verdict(ClassReason::OutOfPosition { off_rad: both }),
                "unstable: q11 ends 0.3° and q21 ends 0.249° from the grasp; at most 0.2° count as in position",
            ),
            (
                verdict(ClassReason::NotPressing { phalanges: lifted }),
                "unstable: the tip lifted off at 18.2 ms for good; both phalanges must press at the end",
            ),
            (
                verdict(ClassReason::NotPressing { phalanges: neither }),
                "unstable: the proximal phalanx lifted off at 18.2 ms for good and the tip has not touched the object; both phalanges must press \
                 at the end",
            ),
            (
                settled(6.883746e-3, 0.0, None),
                "stable: both phalanges press in position from 6.88 ms on, in less than 15 ms, without a rebound",
            ),
            (
                settled(8.2e-3, 2.1, Some(tip)),
                "semi-stable: rebound 2.1 %, at most 5 %; the tip touched first and lifted off at 7.1 ms, until 8.2 ms",
            ),
            (
                settled(8.2e-3, 7.34, Some(often)),
                "semi-unstable: rebound 7.3 %, more than 5 %; the proximal phalanx lifted off 3 times, last at 7.1 ms, until 8.2 ms; 2.3 ms lost since it was first in position",
            ),
            (
                settled(16.2e-3, 0.0, None),
                "semi-unstable: stable only after 16.2 ms; semi-stable needs less than 15 ms, the limit is 20 ms",
            ),
            (
                settled(21.3e-3, 9.0, Some(q21)),
                "unstable: stable only after 21.3 ms; the limit is 20 ms; q21 left its position at 7.1 ms, until 8.2 ms",
            ),
        ] {
            assert_eq!(said, expected);
        }
    }

    #[test]
    fn a_figure_beside_its_limit_is_shown_on_its_side_of_it() {
        for (said, expected) in [
            (settled(15e-3 - 1e-9, 0.0, None), "from 14.999999 ms on"),
            (settled(15e-3, 0.0, None), "after 15 ms; semi-stable needs less than 15 ms"),
            (settled(20e-3 - 1e-8, 0.0, None), "after 19.99999 ms"),
            (settled(20e-3, 0.0, None), "after 20 ms; the limit is 20 ms"),
            (settled(7e-3, 5.0, None), "rebound 5 %, at most 5 %"),
            (settled(7e-3, 5.000001, None), "rebound 5.000001 %, more than 5 %"),
            (settled(7e-3, 4.9999, None), "rebound 4.9999 %, at most 5 %"),
            (verdict(ClassReason::StaticForces { forces_n: [1.0, -1e-12] }), "on the tip is -1.00e-12 N"),
            (verdict(ClassReason::OutOfPosition { off_rad: [EPSILON_RAD + 1e-9, 0.0] }), "q11 ends 0.2000001°"),
        ] {
            assert!(said.contains(expected), "{said} has no {expected}");
        }
        let short = Loss {
            of: Condition::Tip,
            from_s: 7.1e-3,
            until_s: 7.1e-3 + 2e-9,
            times: 1,
            touched_first: false,
            all_s: 2e-9,
        };
        let rounds_alike = Loss { from_s: 13.99e-3, until_s: 14.02e-3, all_s: 0.03e-3, ..short };
        assert_eq!(rounds_alike.to_string(), "the tip lifted off at 13.99 ms, until 14.02 ms");
        assert_eq!(short.to_string(), "the tip lifted off at 7.1 ms, until 7.100002 ms");
    }
}
