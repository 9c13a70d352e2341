//! A sink that records a run for playback, in bounded memory regardless of the length of the run.

use super::{Playback, build_playback};
use crate::format::Report;
use crate::scene::Scene;
use crate::trace::{Event, Sample, Sink, SinkError};

/// Maximum number of retained samples; about 500 bytes each for a finger.
const MAX_RETAINED: usize = 60_000;

/// Number of samples retained after an event, regardless of the stride.
const SAMPLES_AFTER_EVENT: u32 = 4;

/// Records samples and events of a run. Beyond 60,000 samples, only every second, fourth, … sample is retained, in
/// addition to special samples: those at events and at peaks of any contact force. If special samples alone are too
/// many, they are decimated in the same way.
#[derive(Clone, Debug)]
pub struct PlaybackRecorder<S = Sample, E = Event> {
    retained: Vec<RetainedSample<S>>,
    events: Vec<E>,
    recorded: usize,
    stride: usize,
    special_stride: usize,
    /// Number of special samples so far.
    special_count: usize,
    /// The latest sample; only the next one shows whether it is a peak.
    latest: Option<RetainedSample<S>>,
    /// Whether each contact force increased up to the latest sample.
    was_rising: Vec<bool>,
    special_samples_left: u32,
    max_retained: usize,
}

#[derive(Clone, Debug)]
struct RetainedSample<S> {
    /// Normal force of every contact between surfaces.
    forces_n: Vec<f64>,
    /// Whether the sample is at an event or a peak.
    is_special: bool,
    /// Index among all samples, or among special samples if it is special.
    ordinal: usize,
    sample: S,
}

impl<S> RetainedSample<S> {
    fn is_retained(&self, stride: usize, special_stride: usize) -> bool {
        self.ordinal.is_multiple_of(if self.is_special { special_stride } else { stride })
    }
}

impl<S, E> Default for PlaybackRecorder<S, E> {
    fn default() -> Self {
        PlaybackRecorder {
            retained: Vec::new(),
            events: Vec::new(),
            recorded: 0,
            stride: 1,
            special_stride: 1,
            special_count: 0,
            latest: None,
            was_rising: Vec::new(),
            special_samples_left: 0,
            max_retained: MAX_RETAINED,
        }
    }
}

impl<S, E> PlaybackRecorder<S, E> {
    fn push_sample(&mut self, sample: S, forces_n: Vec<f64>) {
        let is_special = self.special_samples_left > 0 || self.recorded == 0;
        self.special_samples_left = self.special_samples_left.saturating_sub(1);
        let before = self.latest.as_ref().map_or(&[][..], |latest| &latest.forces_n);
        let is_rising: Vec<bool> = forces_n.iter().zip(before).map(|(now, before)| now > before).collect();
        let latest = self.latest.replace(RetainedSample { forces_n, is_special, ordinal: self.recorded, sample });
        self.recorded += 1;
        if let Some(mut retained) = latest {
            retained.is_special |=
                self.was_rising.iter().zip(&is_rising).any(|(was_rising, is_rising)| *was_rising && !is_rising);
            if retained.is_special {
                retained.ordinal = self.special_count;
                self.special_count += 1;
            }
            self.store(retained);
        }
        self.was_rising = is_rising;
    }

    fn store(&mut self, retained: RetainedSample<S>) {
        if !retained.is_retained(self.stride, self.special_stride) {
            return;
        }
        self.retained.push(retained);
        if self.retained.len() < self.max_retained {
            return;
        }
        // Decimate the more frequent kind.
        let is_special = self.retained.iter().filter(|retained| retained.is_special).count();
        match 2 * is_special > self.retained.len() {
            true => self.special_stride *= 2,
            false => self.stride *= 2,
        }
        self.retained.retain(|retained| retained.is_retained(self.stride, self.special_stride));
    }

    fn push_event(&mut self, event: E) {
        self.special_samples_left = SAMPLES_AFTER_EVENT;
        if let Some(latest) = &mut self.latest {
            latest.is_special = true;
        }
        self.events.push(event);
    }

    /// Number of samples of the run, retained or not.
    pub fn recorded(&self) -> usize {
        self.recorded
    }

    /// Returns the retained samples and all events.
    pub fn into_parts(self) -> (Vec<S>, Vec<E>) {
        let retained = self.retained.into_iter().chain(self.latest);
        (retained.map(|retained| retained.sample).collect(), self.events)
    }
}

impl PlaybackRecorder {
    /// Builds the playback of the recorded run of a scene.
    pub fn into_playback(self, label: &str, scene: &Scene, summary: impl Into<Report>) -> Playback {
        let recorded = self.recorded;
        let (samples, events) = self.into_parts();
        Playback { recorded, ..build_playback(label, scene, &samples, &events, summary) }
    }
}

impl Sink for PlaybackRecorder {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.push_sample(sample.clone(), sample.surfaces().map(|contact| contact.normal_n).collect());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.push_event(*event);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recorder(max_retained: usize) -> PlaybackRecorder<usize, usize> {
        PlaybackRecorder { max_retained, ..PlaybackRecorder::default() }
    }

    #[test]
    fn retains_all_samples_of_a_short_run() {
        let mut recorder = recorder(100);
        (0..99).for_each(|k| recorder.push_sample(k, vec![0.0]));
        assert_eq!(recorder.into_parts().0, (0..99).collect::<Vec<usize>>());
    }

    #[test]
    fn decimates_a_long_run_evenly_and_retains_peaks_and_events() {
        let mut recorder = recorder(500);
        for k in 0..100_000 {
            if k == 33_333 {
                recorder.push_event(k);
            }
            recorder.push_sample(k, vec![if k == 55_555 { 2.0 } else { 0.0 }]);
        }
        assert_eq!(recorder.recorded(), 100_000);
        let (retained_samples, events) = recorder.into_parts();
        assert_eq!(events, [33_333]);
        assert!(
            retained_samples.len() <= 500 && retained_samples.is_sorted_by(|a, b| a < b),
            "{}",
            retained_samples.len()
        );
        for index in [0, 33_332, 33_333, 33_334, 55_555, 99_999] {
            assert!(retained_samples.contains(&index), "{index}");
        }
        let widest = retained_samples.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest <= Some(512), "{widest:?}");
    }

    #[test]
    fn respects_the_limit_if_every_other_sample_is_a_peak() {
        let mut recorder = recorder(500);
        (0..100_000).for_each(|k| recorder.push_sample(k, vec![(k % 2) as f64]));
        let retained_samples = recorder.into_parts().0;
        assert!(retained_samples.len() <= 501 && retained_samples.len() > 200, "{}", retained_samples.len());
        let widest = retained_samples.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest <= Some(1024), "{widest:?}");
    }
}
