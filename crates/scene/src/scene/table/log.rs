//! `[log]`: what is logged.

use super::lines;
use crate::limits::{MOST_PICTURES, MOST_SAMPLES};
use crate::numeric::elementary::{log10, powi};
use crate::scene::check::{NOT_NEGATIVE, POSITIVE};
use crate::scene::kinds::Frequency;

/// How often the log gets a sample, besides every integrator step within an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogRates {
    pub numeric_hz: f64,
    /// How often it gets a picture for 3-D views; 0 for none.
    pub picture_hz: f64,
}

/// A log that would be larger than anybody can use.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{:.0} {} (a rate of {:e} Hz over {} s) are more than the {:e} that a log takes",
    .rate_hz * .duration_s, if *.pictures { "pictures" } else { "samples" }, .rate_hz, .duration_s, .most
)]
pub struct LogExcess {
    /// Of pictures, or else of numbers.
    pub pictures: bool,
    pub rate_hz: f64,
    pub duration_s: f64,
    pub most: f64,
}

impl LogExcess {
    /// The largest rate for this run, as a scene says it.
    pub fn remedy(&self) -> String {
        let key = if self.pictures { "picture_rate" } else { "numeric_rate" };
        format!("{key} = \"{}\"", self.remedy_rate())
    }

    /// The largest rate for this run, rounded down to one digit.
    pub fn remedy_rate(&self) -> String {
        let rate_hz = self.most / self.duration_s;
        let digit = powi(10.0, log10(rate_hz).floor() as i32);
        format!("{:e} Hz", (rate_hz / digit).floor() * digit)
    }
}

impl LogRates {
    /// Those of a run of this length whose criteria follow its steps: a grid between them would only cost.
    #[must_use]
    pub fn without_grid(self, duration_s: f64) -> Self {
        Self { numeric_hz: 1.0 / duration_s, ..self }
    }

    /// What there would be too much of in a run of this length, if anything.
    pub fn excess(&self, duration_s: f64) -> Option<LogExcess> {
        let of = |pictures, rate_hz, most| LogExcess { pictures, rate_hz, duration_s, most };
        [of(false, self.numeric_hz, MOST_SAMPLES), of(true, self.picture_hz, MOST_PICTURES)]
            .into_iter()
            .find(|excess| excess.rate_hz * duration_s > excess.most)
    }
}

lines! {
    /// What is logged.
    LogRates = Self { numeric_hz: 10e3, picture_hz: 5e3 }, log;
    /// Samples a second of simulated time; impacts are logged at every step besides. In runs of grippers with more than 1000
    /// samples the analytic model gives 4 to 7 of them in each step that is longer, as where nothing happens.
    "numeric_rate": Frequency = Some(&mut log.numeric_hz), allowed(POSITIVE), column("numeric_hz");
    /// Pictures (frames, force arrows) a second of simulated time for 3-D views; they are drawn at samples, so no more often
    /// than these. 0: none.
    "picture_rate": Frequency = Some(&mut log.picture_hz), allowed(NOT_NEGATIVE), column("picture_hz");
}
