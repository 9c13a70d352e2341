//! Contact figures of a run that broke off, gathered from its stream: such a run has no [`crate::trace::Outcome`].

use crate::trace::{Event, EventKind, Sample, Sink, SinkError, Site, SiteSummary};

/// A [`Sink`] that keeps the last sample and sums up each site.
///
/// Touch-downs are exact; peaks are those of the samples, and impulses those of finished contacts.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub last: Option<Sample>,
    pub sites: [SiteSummary; 3],
    /// Impulse of each site before its latest touch-down.
    earlier: [f64; 3],
}

impl Sink for Tally {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let figures = [
            (sample.proximal.normal_n, sample.proximal.gap_m),
            (sample.distal.normal_n, sample.distal.gap_m),
            (sample.limit.torque_n_m, sample.limit.gap_rad),
        ];
        for (site, (force, gap)) in self.sites.iter_mut().zip(figures) {
            site.peak_normal_n = site.peak_normal_n.max(force);
            site.max_penetration_m = site.max_penetration_m.max(-gap);
            if self.last.is_none() && gap < 0.0 {
                site.first_s = Some(sample.time_s);
            }
        }
        self.last = Some(*sample);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let site = &mut self.sites[event.site as usize];
        let earlier = &mut self.earlier[event.site as usize];
        match event.kind {
            EventKind::TouchDown => {
                site.first_s.get_or_insert(event.time_s);
                site.touchdowns += 1;
                *earlier = site.impulse_n_s;
            }
            // Gathered since the touch-down, whatever was let go and pressed again in between.
            EventKind::LiftOff => site.impulse_n_s = *earlier + event.impulse,
            EventKind::Reload => {}
        }
        Ok(())
    }
}

impl Tally {
    pub fn site(&self, site: Site) -> &SiteSummary {
        &self.sites[site as usize]
    }
}
