//! A sink that records a run for playback, in bounded memory regardless of the length of the run.

use super::{Playback, build_playback};
use crate::format::Report;
use crate::scene::Scene;
use crate::trace::{Event, RequiredData, Sample, Sink, SinkError};

/// Maximum number of retained samples; about 500 bytes each for a finger.
const MAX_RETAINED: usize = 60_000;

/// Number of samples retained after an event, regardless of the stride.
const SAMPLES_AFTER_EVENT: u32 = 4;

/// Records samples and events of a run. Beyond 60,000 samples, it keeps only every second, fourth, … sample, and in
/// addition all special samples: those at events and at peaks of any contact force. If there are too many special
/// samples, they are decimated in the same way.
#[derive(Clone, Debug)]
pub struct PlaybackRecorder {
    retained: Vec<RetainedSample>,
    events: Vec<Event>,
    recorded: usize,
    stride: usize,
    special_stride: usize,
    /// Number of special samples so far.
    special_count: usize,
    /// The latest sample; only the next one shows whether it is a peak.
    latest: Option<RetainedSample>,
    /// Whether each contact force increased up to the latest sample.
    was_rising: Vec<bool>,
    special_samples_left: u32,
    max_retained: usize,
}

#[derive(Clone, Debug)]
struct RetainedSample {
    /// Normal force of every contact between surfaces.
    forces_n: Vec<f64>,
    /// Whether the sample is at an event or a peak.
    is_special: bool,
    /// Index among all samples, or among special samples if it is special.
    ordinal: usize,
    sample: Sample,
}

impl RetainedSample {
    fn is_retained(&self, stride: usize, special_stride: usize) -> bool {
        self.ordinal.is_multiple_of(if self.is_special { special_stride } else { stride })
    }
}

impl Default for PlaybackRecorder {
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

impl PlaybackRecorder {
    fn push_sample(&mut self, sample: Sample, forces_n: Vec<f64>) {
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

    fn store(&mut self, retained: RetainedSample) {
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

    /// Builds the playback of the recorded run of a scene.
    pub fn into_playback(self, label: &str, scene: &Scene, summary: impl Into<Report>) -> Playback {
        let recorded = self.recorded;
        let (samples, events) = self.into_parts();
        Playback { recorded, ..build_playback(label, scene, &samples, &events, summary) }
    }

    /// Returns the retained samples and all events.
    fn into_parts(self) -> (Vec<Sample>, Vec<Event>) {
        let retained = self.retained.into_iter().chain(self.latest);
        (retained.map(|retained| retained.sample).collect(), self.events)
    }
}

impl Sink for PlaybackRecorder {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.push_sample(sample.clone(), sample.surfaces().map(|contact| contact.normal_n).collect());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.special_samples_left = SAMPLES_AFTER_EVENT;
        if let Some(latest) = &mut self.latest {
            latest.is_special = true;
        }
        self.events.push(*event);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::EventKind;

    /// Records samples at 0 s, 1 s, … with these forces, and an event before one of them.
    fn record(
        max_retained: usize,
        count: usize,
        event_at: Option<usize>,
        force_n: impl Fn(usize) -> f64,
    ) -> Vec<usize> {
        let slip = Event { time_s: 0.0, contact: 0, kind: EventKind::Slips, approach_speed: 0.0, impulse: 0.0 };
        let mut recorder = PlaybackRecorder { max_retained, ..PlaybackRecorder::default() };
        for k in 0..count {
            if event_at == Some(k) {
                recorder.event(&slip).expect("recorded");
            }
            recorder.push_sample(Sample::of(k as f64, &[], &[], &[]), vec![force_n(k)]);
        }
        assert_eq!(recorder.recorded, count);
        let (samples, events) = recorder.into_parts();
        assert_eq!(events.len(), event_at.iter().len());
        samples.iter().map(|sample| sample.time_s as usize).collect()
    }

    fn widest_gap(retained: &[usize]) -> usize {
        assert!(retained.is_sorted_by(|a, b| a < b));
        retained.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0)
    }

    #[test]
    fn retains_all_samples_of_a_short_run() {
        assert_eq!(record(100, 99, None, |_| 0.0), (0..99).collect::<Vec<usize>>());
    }

    #[test]
    fn decimates_a_long_run_evenly_and_retains_peaks_and_events() {
        let retained = record(500, 100_000, Some(33_333), |k| if k == 55_555 { 2.0 } else { 0.0 });
        assert!(retained.len() <= 500 && widest_gap(&retained) <= 512, "{}", retained.len());
        for index in [0, 33_332, 33_333, 33_334, 55_555, 99_999] {
            assert!(retained.contains(&index), "{index}");
        }
    }

    #[test]
    fn respects_the_limit_if_every_other_sample_is_a_peak() {
        let retained = record(500, 100_000, None, |k| (k % 2) as f64);
        assert!((200..=501).contains(&retained.len()) && widest_gap(&retained) <= 1024, "{}", retained.len());
    }
}
