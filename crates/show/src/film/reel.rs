//! A sink that keeps what a page needs of a run, in bounded memory however long the run is.

use super::{Film, film};
use crate::scene::Scene;
use crate::trace::{Event, Sample, Sink, SinkError};
use crate::wording::Report;

/// Samples that are held at most; some 500 bytes each of a finger.
const MOST_HELD: usize = 60_000;

/// Samples kept from an event on, however coarse the rest is.
const AFTER_EVENT: u32 = 4;

/// Samples and events of a run as it goes by. Beyond 60,000 samples only every second, fourth, … is kept, and
/// those at events and at peaks of any contact's force; of these too only every second, where they alone are too many.
#[derive(Clone, Debug)]
pub struct Reel<S = Sample, E = Event> {
    held: Vec<Held<S>>,
    events: Vec<E>,
    recorded: usize,
    stride: usize,
    special_stride: usize,
    /// Samples so far that are special.
    specials: usize,
    /// The latest sample: whether it is a peak is known when the next one has come.
    latest: Option<Held<S>>,
    /// Which forces grew up to the latest sample.
    rising: Vec<bool>,
    near_event: u32,
    most: usize,
}

#[derive(Clone, Debug)]
struct Held<S> {
    /// Of every contact between surfaces.
    forces_n: Vec<f64>,
    /// At an event or at a peak.
    special: bool,
    /// Which of its kind: of all samples, or of those that are special.
    ordinal: usize,
    sample: S,
}

impl<S> Held<S> {
    fn stays(&self, stride: usize, special_stride: usize) -> bool {
        self.ordinal.is_multiple_of(if self.special { special_stride } else { stride })
    }
}

impl<S, E> Default for Reel<S, E> {
    fn default() -> Self {
        Reel {
            held: Vec::new(),
            events: Vec::new(),
            recorded: 0,
            stride: 1,
            special_stride: 1,
            specials: 0,
            latest: None,
            rising: Vec::new(),
            near_event: 0,
            most: MOST_HELD,
        }
    }
}

impl<S, E> Reel<S, E> {
    fn take(&mut self, sample: S, forces_n: Vec<f64>) {
        let special = self.near_event > 0 || self.recorded == 0;
        self.near_event = self.near_event.saturating_sub(1);
        let before = self.latest.as_ref().map_or(&[][..], |latest| &latest.forces_n);
        let rises: Vec<bool> = forces_n.iter().zip(before).map(|(now, before)| now > before).collect();
        let latest = self.latest.replace(Held { forces_n, special, ordinal: self.recorded, sample });
        self.recorded += 1;
        if let Some(mut held) = latest {
            held.special |= self.rising.iter().zip(&rises).any(|(rising, rises)| *rising && !rises);
            if held.special {
                held.ordinal = self.specials;
                self.specials += 1;
            }
            self.keep(held);
        }
        self.rising = rises;
    }

    fn keep(&mut self, held: Held<S>) {
        if !held.stays(self.stride, self.special_stride) {
            return;
        }
        self.held.push(held);
        if self.held.len() < self.most {
            return;
        }
        // Whichever kind has more is thinned out.
        let special = self.held.iter().filter(|held| held.special).count();
        match 2 * special > self.held.len() {
            true => self.special_stride *= 2,
            false => self.stride *= 2,
        }
        self.held.retain(|held| held.stays(self.stride, self.special_stride));
    }

    fn note(&mut self, event: E) {
        self.near_event = AFTER_EVENT;
        if let Some(latest) = &mut self.latest {
            latest.special = true;
        }
        self.events.push(event);
    }

    /// Samples of the run, kept or not.
    pub fn recorded(&self) -> usize {
        self.recorded
    }

    /// What was kept.
    pub fn into_parts(self) -> (Vec<S>, Vec<E>) {
        let held = self.held.into_iter().chain(self.latest);
        (held.map(|held| held.sample).collect(), self.events)
    }
}

impl Reel {
    /// The film of a scene.
    pub fn film(self, label: &str, scene: &Scene, summary: impl Into<Report>) -> Film {
        let recorded = self.recorded;
        let (samples, events) = self.into_parts();
        Film { recorded, ..film(label, scene, &samples, &events, summary) }
    }
}

impl Sink for Reel {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.take(sample.clone(), sample.surfaces().map(|contact| contact.normal_n).collect());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.note(*event);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reel(most: usize) -> Reel<usize, usize> {
        Reel { most, ..Reel::default() }
    }

    #[test]
    fn a_short_run_is_kept_whole() {
        let mut reel = reel(100);
        (0..99).for_each(|k| reel.take(k, vec![0.0]));
        assert_eq!(reel.into_parts().0, (0..99).collect::<Vec<usize>>());
    }

    #[test]
    fn a_long_run_is_kept_evenly_with_its_peaks_and_events() {
        let mut reel = reel(500);
        for k in 0..100_000 {
            if k == 33_333 {
                reel.note(k);
            }
            reel.take(k, vec![if k == 55_555 { 2.0 } else { 0.0 }]);
        }
        assert_eq!(reel.recorded(), 100_000);
        let (kept, events) = reel.into_parts();
        assert_eq!(events, [33_333]);
        assert!(kept.len() <= 500 && kept.is_sorted_by(|a, b| a < b), "{}", kept.len());
        for wanted in [0, 33_332, 33_333, 33_334, 55_555, 99_999] {
            assert!(kept.contains(&wanted), "{wanted}");
        }
        let widest = kept.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest <= Some(512), "{widest:?}");
    }

    #[test]
    fn peaks_alone_do_not_break_the_bound() {
        let mut reel = reel(500);
        (0..100_000).for_each(|k| reel.take(k, vec![(k % 2) as f64]));
        let kept = reel.into_parts().0;
        assert!(kept.len() <= 501 && kept.len() > 200, "{}", kept.len());
        let widest = kept.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest <= Some(1024), "{widest:?}");
    }
}
