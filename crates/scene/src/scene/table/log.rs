//! `[log]`: rates of samples and pictures in the log.

use super::settings;
use crate::limits::{MAX_PICTURES, MAX_SAMPLES};
use crate::numeric::elementary::{log10, powi};
use crate::scene::check::{NOT_NEGATIVE, POSITIVE};
use crate::scene::value_kinds::Frequency;

/// Rates of the log. In addition, every integrator step during an impact is logged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogRates {
    pub numeric_hz: f64,
    /// Rate of pictures for 3-D views; 0 for none.
    pub picture_hz: f64,
}

/// Error for a log with too many samples or pictures.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{:.0} {} ({:e} Hz over {} s) are more than the limit of {:e} per log",
    .rate_hz * .duration_s, if *.pictures { "pictures" } else { "samples" }, .rate_hz, .duration_s, .max
)]
pub struct LogExcess {
    /// Whether there are too many pictures, or else too many samples.
    pub pictures: bool,
    pub rate_hz: f64,
    pub duration_s: f64,
    pub max: f64,
}

impl LogExcess {
    /// Returns the largest rate for this run as a line of a scene file.
    pub fn suggestion(&self) -> String {
        let key = if self.pictures { "picture_rate" } else { "numeric_rate" };
        format!("{key} = \"{}\"", self.suggested_rate())
    }

    /// Returns the largest rate for this run, rounded down to one digit.
    pub fn suggested_rate(&self) -> String {
        let rate_hz = self.max / self.duration_s;
        let digit = powi(10.0, log10(rate_hz).floor() as i32);
        format!("{:e} Hz", (rate_hz / digit).floor() * digit)
    }
}

impl LogRates {
    /// Disables the sample grid of a run of this duration, for criteria that are evaluated at every step.
    #[must_use]
    pub fn without_sample_grid(self, duration_s: f64) -> Self {
        Self { numeric_hz: 1.0 / duration_s, ..self }
    }

    /// Checks the limits of samples and pictures for a run of this duration.
    pub fn excess(&self, duration_s: f64) -> Option<LogExcess> {
        let excess = |pictures, rate_hz, max| LogExcess { pictures, rate_hz, duration_s, max };
        [excess(false, self.numeric_hz, MAX_SAMPLES), excess(true, self.picture_hz, MAX_PICTURES)]
            .into_iter()
            .find(|excess| excess.rate_hz * duration_s > excess.max)
    }
}

settings! {
    /// Rates of samples and pictures in the log.
    LogRates = Self { numeric_hz: 10e3, picture_hz: 5e3 }, log;
    /// Samples per second of simulated time; during impacts every step is logged in addition. In runs of grippers with
    /// more than 1000 samples, the analytic model logs 4 to 7 samples in each step that is longer than the sample
    /// interval.
    "numeric_rate": Frequency = Some(&mut log.numeric_hz), allowed(POSITIVE), column("numeric_hz");
    /// Pictures (frames, force arrows) per second of simulated time for 3-D views, at most one per sample; 0 for none.
    "picture_rate": Frequency = Some(&mut log.picture_hz), allowed(NOT_NEGATIVE), column("picture_hz");
}
