//! Rebound formula, dynamic classes, and the reason for the class of a run: the deciding figure and its limit.

use std::fmt::{self, Display, Formatter};

use serde::{Serialize, Serializer};

/// ε: largest deviation from the final angles at which the finger is in position, 0.2° (thesis §4.1.1.1). The value is
/// wide enough for the penetration and narrow enough to detect a rebound.
pub const EPSILON_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;

/// Duration of one impact, 1 µs. With the contact parameters of the thesis an impact ends within a microsecond, so a
/// shorter loss of contact is the impact itself and not a rebound.
pub const RESOLUTION_S: f64 = 1e-6;

/// Time to stability below which a finger can be "stable" or "semi-stable" (thesis §4.1.1.1: 15 ms).
pub(crate) const STABLE_WITHIN_S: f64 = 15e-3;

/// Time to stability below which a finger is at least "semi-unstable" (thesis §4.2: 20 ms).
pub(crate) const SEMI_UNSTABLE_WITHIN_S: f64 = 20e-3;

/// Largest rebound of a "semi-stable" finger, in percent (thesis §4.1.1.2).
pub(crate) const SMALL_REBOUND_PERCENT: f64 = 5.0;

/// Returns the rebound in percent (4.1): 100 |mean(t_geo…T) / mean(tts…T) − 1| = 100 |(t_geo + T)/(tts + T) − 1|.
///
/// The mean of a uniform time vector from a to T is (a + T)/2.
///
/// `lost_s` is the time after t_geo in which the finger was out of position again, or a phalanx had lifted off the
/// object. If it is below [`RESOLUTION_S`], there was no rebound, and the result is exactly 0. The interval from t_geo
/// to tts is then only the end of the approach, from the edge of the ε band to the contact (some 10 µs for a fast
/// finger). The formula alone would count it as a rebound.
///
/// Arguments in seconds, 0 ≤ t_geo ≤ tts ≤ T, T > 0.
pub fn rebound_percent(t_geo_s: f64, tts_s: f64, duration_s: f64, lost_s: f64) -> f64 {
    if lost_s < RESOLUTION_S {
        return 0.0;
    }
    100.0 * ((t_geo_s + duration_s) / (tts_s + duration_s) - 1.0).abs()
}

/// Dynamic class of a design (thesis §4.1.1.2 and §4.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    Stable,
    SemiStable,
    SemiUnstable,
    Unstable,
}

impl Class {
    /// All classes from best to worst.
    pub const ALL: [Class; 4] = [Class::Stable, Class::SemiStable, Class::SemiUnstable, Class::Unstable];

    /// Returns the class of a finger:
    ///
    /// | class | rebound | tts |
    /// |---|---|---|
    /// | stable | 0 | < 15 ms |
    /// | semi-stable | ≤ 5 % | < 15 ms |
    /// | semi-unstable | any other | < 20 ms |
    /// | unstable | – | none or ≥ 20 ms, or the grasp is not statically stable |
    ///
    /// The thesis defines no class for a small rebound with a tts between 15 and 20 ms. Such a finger is neither stable
    /// within 15 ms nor unstable, hence semi-unstable.
    pub fn classify(tts_s: Option<f64>, rebound_percent: Option<f64>, statically_stable: bool) -> Class {
        let (Some(tts_s), Some(rebound_percent), true) = (tts_s, rebound_percent, statically_stable) else {
            return Class::Unstable;
        };
        if tts_s < STABLE_WITHIN_S && rebound_percent == 0.0 {
            Class::Stable
        } else if tts_s < STABLE_WITHIN_S && rebound_percent <= SMALL_REBOUND_PERCENT {
            Class::SemiStable
        } else if tts_s < SEMI_UNSTABLE_WITHIN_S {
            Class::SemiUnstable
        } else {
            Class::Unstable
        }
    }

    /// Returns the name in reports and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Class::Stable => "stable",
            Class::SemiStable => "semi-stable",
            Class::SemiUnstable => "semi-unstable",
            Class::Unstable => "unstable",
        }
    }
}

/// Reason for the class of a finger. Pairs are in the order (q11, q21) or (proximal phalanx, tip); the tip is the
/// distal phalanx.
///
/// Its `Display` gives the sentence that reports print after the name of the class;
/// [`Criteria::verdict`](super::Criteria::verdict) puts the name in front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClassReason {
    /// A phalanx would have to pull in the static grasp: at least one static normal force, N, is negative or NaN.
    StaticForces { forces_n: [f64; 2] },
    /// The run ends out of position: |q11 − q11,f| or |q21 − q21,f|, rad, is above [`EPSILON_RAD`] at its end.
    OutOfPosition { deviation_rad: [f64; 2] },
    /// The run ends in position, but a phalanx is not in contact.
    NotInContact { phalanges: [FinalContact; 2] },
    /// The finger is in position with both contacts active from `tts_s` on. `loss` is the last loss of a rebound, if
    /// there was one.
    Settled { tts_s: f64, rebound_percent: f64, loss: Option<Loss> },
}

/// Contact of a phalanx at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FinalContact {
    Active,
    NeverTouched,
    /// No normal force since this time.
    LiftedOff {
        at_s: f64,
    },
}

/// The last loss of a stability condition before the final stable interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    pub condition: Condition,
    pub from_s: f64,
    pub until_s: f64,
    /// Number of losses of this condition during the run.
    pub times: u32,
    /// Whether this is the phalanx that touched the object first.
    pub touched_first: bool,
    /// Total time lost to rebounds, [`Criteria::lost_s`](super::Criteria::lost_s).
    pub total_lost_s: f64,
}

/// The conditions of stability: each angle is in position, and each phalanx is in contact.
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
            Condition::Tip => "the distal phalanx",
        }
    }
}

impl ClassReason {
    pub fn class(&self) -> Class {
        match *self {
            ClassReason::Settled { tts_s, rebound_percent, .. } => {
                Class::classify(Some(tts_s), Some(rebound_percent), true)
            }
            _ => Class::classify(None, None, !matches!(self, ClassReason::StaticForces { .. })),
        }
    }
}

/// Serialises the reason as a sentence.
impl Serialize for ClassReason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Display for ClassReason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            ClassReason::StaticForces { forces_n } => write_static_forces(f, *forces_n),
            ClassReason::OutOfPosition { deviation_rad } => write_out_of_position(f, *deviation_rad),
            ClassReason::NotInContact { phalanges } => write_not_in_contact(f, *phalanges),
            ClassReason::Settled { tts_s, rebound_percent, loss } => {
                write_settled(f, self.class(), *tts_s, *rebound_percent)?;
                loss.iter().try_for_each(|loss| write!(f, "; {loss}"))
            }
        }
    }
}

/// Returns whether the forces are positive (thesis §1.2.3): no phalanx has to pull. NaN is not positive.
pub(super) fn is_positive(forces_n: &[f64]) -> bool {
    forces_n.iter().all(|force_n| *force_n >= 0.0)
}

fn write_static_forces(f: &mut Formatter<'_>, forces_n: [f64; 2]) -> fmt::Result {
    let negative = Condition::PHALANGES.iter().zip(forces_n).filter(|(_, force_n)| !is_positive(&[*force_n]));
    let (names, forces): (Vec<_>, Vec<_>) =
        negative.map(|(phalanx, n)| (phalanx.name(), format!("{} N", format_with_limit(n, 0.0, 3)))).unzip();
    let (names, forces) = (names.join(" and "), forces.join(" and "));
    match forces.contains(" and ") {
        false => write!(f, "the static force on {names} is {forces}; it must not be negative"),
        true => write!(f, "the static forces on {names} are {forces}; they must not be negative"),
    }
}

/// Returns whether an angle with this deviation from the grasp is in position.
pub(super) fn is_in_position(deviation_rad: f64) -> bool {
    deviation_rad <= EPSILON_RAD
}

fn write_out_of_position(f: &mut Formatter<'_>, deviation_rad: [f64; 2]) -> fmt::Result {
    // Removes the rounding error of the conversion.
    let limit_deg = (EPSILON_RAD.to_degrees() * 1e9).round() / 1e9;
    let outside =
        Condition::ANGLES.iter().zip(deviation_rad).filter(|(_, deviation_rad)| !is_in_position(*deviation_rad));
    let ends = outside.map(|(condition, deviation_rad)| {
        format!("{} ends {}°", condition.name(), format_with_limit(deviation_rad.to_degrees(), limit_deg, 3))
    });
    let ends = ends.collect::<Vec<_>>().join(" and ");
    write!(f, "{ends} from the grasp; at most {limit_deg}° count as in position")
}

fn write_not_in_contact(f: &mut Formatter<'_>, phalanges: [FinalContact; 2]) -> fmt::Result {
    let inactive = Condition::PHALANGES.iter().zip(phalanges).filter_map(|(condition, contact)| match contact {
        FinalContact::Active => None,
        FinalContact::NeverTouched => Some(format!("{} has not touched the object", condition.name())),
        FinalContact::LiftedOff { at_s } => {
            Some(format!("{} lifted off permanently at {}", condition.name(), milliseconds(at_s, f64::NAN)))
        }
    });
    write!(f, "{}; both phalanges must be in contact at the end", inactive.collect::<Vec<_>>().join(" and "))
}

fn write_settled(f: &mut Formatter<'_>, class: Class, tts_s: f64, rebound_percent: f64) -> fmt::Result {
    let [stable, settled] = [STABLE_WITHIN_S, SEMI_UNSTABLE_WITHIN_S].map(|limit_s| format!("{} ms", limit_s * 1e3));
    let tts = |limit_s| milliseconds(tts_s, limit_s);
    let percent = format_with_limit(rebound_percent, SMALL_REBOUND_PERCENT, 2);
    match class {
        Class::Stable => write!(
            f,
            "in position with both contacts active from {} on, in less than {stable}, without a rebound",
            tts(STABLE_WITHIN_S)
        ),
        Class::SemiStable => write!(f, "rebound {percent} %, at most {SMALL_REBOUND_PERCENT} %"),
        Class::SemiUnstable if tts_s < STABLE_WITHIN_S => {
            write!(f, "rebound {percent} %, more than {SMALL_REBOUND_PERCENT} %")
        }
        Class::SemiUnstable => {
            // Between two limits, the nearer one decides the number of digits.
            let nearer_s = if tts_s - STABLE_WITHIN_S < SEMI_UNSTABLE_WITHIN_S - tts_s {
                STABLE_WITHIN_S
            } else {
                SEMI_UNSTABLE_WITHIN_S
            };
            write!(
                f,
                "stable only after {}; semi-stable needs less than {stable}, the limit is {settled}",
                tts(nearer_s)
            )
        }
        Class::Unstable => write!(f, "stable only after {}; the limit is {settled}", tts(SEMI_UNSTABLE_WITHIN_S)),
    }
}

/// Relative difference below which two lost times count as equal; three digits are displayed.
const SAME_LOSS_FRACTION: f64 = 5e-3;

impl Display for Loss {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let first = if self.touched_first { " touched first and" } else { "" };
        let lost = match self.condition {
            Condition::Q11 | Condition::Q21 => "was out of position",
            Condition::Proximal | Condition::Tip => "lifted off",
        };
        let times = if self.times > 1 { format!(" {} times, last", self.times) } else { String::new() };
        let [from, until] = format_distinguishable([self.from_s * 1e3, self.until_s * 1e3], 3);
        write!(f, "{}{first} {lost}{times} from {from} ms to {until} ms", self.condition.name())?;
        // There was an earlier loss, or part of this one was before the finger was in position.
        match (self.total_lost_s - (self.until_s - self.from_s)).abs() > SAME_LOSS_FRACTION * self.total_lost_s {
            true => write!(
                f,
                "; {} lost in total after it was first in position",
                milliseconds(self.total_lost_s, f64::NAN)
            ),
            false => Ok(()),
        }
    }
}

fn milliseconds(time_s: f64, limit_s: f64) -> String {
    format!("{} ms", format_with_limit(time_s * 1e3, limit_s * 1e3, 3))
}

/// Formats a number with `digits` significant digits, or with more if needed to show on which side of a limit it is.
fn format_with_limit(value: f64, limit: f64, digits: usize) -> String {
    let side = |number: f64| number.partial_cmp(&limit);
    let shown = (digits..=17).map(|digits| format_significant(value, digits));
    let is_on_correct_side =
        |text: &String| side(value).is_none() || text.parse().is_ok_and(|read: f64| side(read) == side(value));
    shown.into_iter().find(is_on_correct_side).unwrap_or_else(|| value.to_string())
}

/// Formats two different numbers with `digits` significant digits, or with more if needed to distinguish them.
fn format_distinguishable(values: [f64; 2], digits: usize) -> [String; 2] {
    let mut shown = (digits..=17).map(|digits| values.map(|value| format_significant(value, digits)));
    shown.find(|[a, b]| a != b).unwrap_or_else(|| values.map(|value| value.to_string()))
}

/// Formats a number with `digits` significant digits, without trailing zeros after the decimal point.
fn format_significant(value: f64, digits: usize) -> String {
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

    #[test]
    fn rebound_is_the_ratio_of_the_means_of_the_two_time_vectors() {
        let (t_geo, tts, duration) = (6e-3, 8e-3, 20e-3);
        let mean = |from: f64| {
            let n = 1000;
            (0..=n).map(|i| from + (duration - from) * i as f64 / n as f64).sum::<f64>() / (n + 1) as f64
        };
        let from_vectors = 100.0 * (mean(t_geo) / mean(tts) - 1.0).abs();
        let rebound = rebound_percent(t_geo, tts, duration, tts - t_geo);
        assert!((rebound - from_vectors).abs() < 1e-10, "{rebound} {from_vectors}");
        assert!((rebound - 100.0 * 2.0 / 28.0).abs() < 1e-12);
    }

    #[test]
    fn rebound_is_zero_when_nothing_is_lost() {
        assert_eq!(rebound_percent(7e-3, 7e-3, 20e-3, 0.0), 0.0);
        // The approach through the ε band takes time, but is not a loss.
        assert_eq!(rebound_percent(6.98e-3, 7e-3, 20e-3, 0.0), 0.0);
        assert_eq!(rebound_percent(6.98e-3, 7e-3, 20e-3, 0.99e-6), 0.0);
        assert!(rebound_percent(6.98e-3, 7e-3, 20e-3, 1e-6) > 0.0);
    }

    #[test]
    fn classifies_at_the_limits() {
        let class = |tts, rebound| Class::classify(Some(tts), Some(rebound), true);
        assert_eq!(class(7e-3, 0.0), Class::Stable);
        assert_eq!(class(7e-3, 1e-9), Class::SemiStable);
        assert_eq!(class(7e-3, 5.0), Class::SemiStable);
        assert_eq!(class(7e-3, 5.0 + 1e-12), Class::SemiUnstable);
        assert_eq!(class(15e-3, 0.0), Class::SemiUnstable);
        assert_eq!(class(19.99e-3, 30.0), Class::SemiUnstable);
        assert_eq!(class(20e-3, 0.0), Class::Unstable);
        assert_eq!(Class::classify(None, None, true), Class::Unstable);
        assert_eq!(Class::classify(Some(7e-3), Some(0.0), false), Class::Unstable);
    }

    fn verdict(reason: ClassReason) -> String {
        format!("{}: {reason}", reason.class().name())
    }

    fn settled(tts_s: f64, rebound_percent: f64, loss: Option<Loss>) -> String {
        verdict(ClassReason::Settled { tts_s, rebound_percent, loss })
    }

    #[test]
    fn sentences_contain_figure_and_limit() {
        let tip = Loss {
            condition: Condition::Tip,
            from_s: 7.1e-3,
            until_s: 8.2e-3,
            times: 1,
            touched_first: true,
            total_lost_s: 1.1e-3,
        };
        let repeated =
            Loss { condition: Condition::Proximal, times: 3, touched_first: false, total_lost_s: 2.3e-3, ..tip };
        let q21 = Loss { condition: Condition::Q21, touched_first: false, ..tip };
        let deviation_rad = [0.1f64.to_radians(), 0.249f64.to_radians()];
        let both = [0.3f64.to_radians(), 0.249f64.to_radians()];
        let lifted = [FinalContact::Active, FinalContact::LiftedOff { at_s: 18.2e-3 }];
        let neither = [FinalContact::LiftedOff { at_s: 18.2e-3 }, FinalContact::NeverTouched];
        for (text, expected) in [
            (
                verdict(ClassReason::StaticForces { forces_n: [-1.2, 3.0] }),
                "unstable: the static force on the proximal phalanx is -1.2 N; it must not be negative",
            ),
            (
                verdict(ClassReason::StaticForces { forces_n: [-1.2, -30.0] }),
                "unstable: the static forces on the proximal phalanx and the distal phalanx are -1.2 N and -30 N; they must not be negative",
            ),
            (
                verdict(ClassReason::OutOfPosition { deviation_rad }),
                "unstable: q21 ends 0.249° from the grasp; at most 0.2° count as in position",
            ),
            (
                verdict(ClassReason::OutOfPosition { deviation_rad: both }),
                "unstable: q11 ends 0.3° and q21 ends 0.249° from the grasp; at most 0.2° count as in position",
            ),
            (
                verdict(ClassReason::NotInContact { phalanges: lifted }),
                "unstable: the distal phalanx lifted off permanently at 18.2 ms; both phalanges must be in contact at the end",
            ),
            (
                verdict(ClassReason::NotInContact { phalanges: neither }),
                "unstable: the proximal phalanx lifted off permanently at 18.2 ms and the distal phalanx has not touched the object; both phalanges must be in \
                 contact at the end",
            ),
            (
                settled(6.883746e-3, 0.0, None),
                "stable: in position with both contacts active from 6.88 ms on, in less than 15 ms, without a rebound",
            ),
            (
                settled(8.2e-3, 2.1, Some(tip)),
                "semi-stable: rebound 2.1 %, at most 5 %; the distal phalanx touched first and lifted off from 7.1 ms to 8.2 ms",
            ),
            (
                settled(8.2e-3, 7.34, Some(repeated)),
                "semi-unstable: rebound 7.3 %, more than 5 %; the proximal phalanx lifted off 3 times, last from 7.1 ms to 8.2 ms; 2.3 ms lost in total after it was first in position",
            ),
            (
                settled(16.2e-3, 0.0, None),
                "semi-unstable: stable only after 16.2 ms; semi-stable needs less than 15 ms, the limit is 20 ms",
            ),
            (
                settled(21.3e-3, 9.0, Some(q21)),
                "unstable: stable only after 21.3 ms; the limit is 20 ms; q21 was out of position from 7.1 ms to 8.2 ms",
            ),
        ] {
            assert_eq!(text, expected);
        }
    }

    #[test]
    fn figures_near_a_limit_are_displayed_on_the_correct_side() {
        for (text, expected) in [
            (settled(15e-3 - 1e-9, 0.0, None), "from 14.999999 ms on"),
            (settled(15e-3, 0.0, None), "after 15 ms; semi-stable needs less than 15 ms"),
            (settled(20e-3 - 1e-8, 0.0, None), "after 19.99999 ms"),
            (settled(20e-3, 0.0, None), "after 20 ms; the limit is 20 ms"),
            (settled(7e-3, 5.0, None), "rebound 5 %, at most 5 %"),
            (settled(7e-3, 5.000001, None), "rebound 5.000001 %, more than 5 %"),
            (settled(7e-3, 4.9999, None), "rebound 4.9999 %, at most 5 %"),
            (verdict(ClassReason::StaticForces { forces_n: [1.0, -1e-12] }), "on the distal phalanx is -1.00e-12 N"),
            (verdict(ClassReason::OutOfPosition { deviation_rad: [EPSILON_RAD + 1e-9, 0.0] }), "q11 ends 0.2000001°"),
        ] {
            assert!(text.contains(expected), "{text} does not contain {expected}");
        }
        let short = Loss {
            condition: Condition::Tip,
            from_s: 7.1e-3,
            until_s: 7.1e-3 + 2e-9,
            times: 1,
            touched_first: false,
            total_lost_s: 2e-9,
        };
        let equal_when_rounded = Loss { from_s: 13.99e-3, until_s: 14.02e-3, total_lost_s: 0.03e-3, ..short };
        assert_eq!(equal_when_rounded.to_string(), "the distal phalanx lifted off from 13.99 ms to 14.02 ms");
        assert_eq!(short.to_string(), "the distal phalanx lifted off from 7.1 ms to 7.100002 ms");
    }
}
