//! Rebound formula and dynamic classes.

use serde::Serialize;

/// ε: largest deviation from the final angles at which the finger is in position, 0.2° (thesis §4.1.1.1; the value from
/// 2-design §2.4, wide enough for the penetration and narrow enough to detect a rebound).
pub const EPSILON_RAD: f64 = 0.2 * std::f64::consts::PI / 180.0;

/// Duration of one impact, 1 µs: with the contact parameters of the thesis an impact ends within a microsecond, so a
/// shorter loss is the impact itself and not a rebound.
pub const RESOLUTION_S: f64 = 1e-6;

/// Time to stability below which a finger can be "stable" or "semi-stable" (thesis §4.1.1.1: 15 ms).
pub const STABLE_WITHIN_S: f64 = 15e-3;

/// Time to stability below which a finger is at least "semi-unstable" (thesis §4.2: 20 ms).
pub const SEMI_UNSTABLE_WITHIN_S: f64 = 20e-3;

/// Largest rebound of a "semi-stable" finger, in percent (thesis §4.1.1.2).
pub const SMALL_REBOUND_PERCENT: f64 = 5.0;

/// Returns the rebound in percent (4.1): 100 |mean(t_geo…T) / mean(tts…T) − 1| = 100 |(t_geo + T)/(tts + T) − 1|.
///
/// The mean of a uniform time vector from a to T is (a + T)/2.
///
/// `lost_s` is the time after t_geo in which the finger was out of position again, or a phalanx had lifted off the
/// object. Below [`RESOLUTION_S`] there was no rebound, and the result is exactly 0: the interval from t_geo to tts is
/// then only the end of the approach, from the edge of the ε band to the contact (some 10 µs for a fast finger), which
/// the formula alone would count as a rebound.
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
}
