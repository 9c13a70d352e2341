//! Events that answer each other without time passing.

/// Events at one site within this time of each other are chatter…
const SPACING_S: f64 = 1e-15;
/// …and after this many of them one step is left to the natural branches of the law.
const ENOUGH: u32 = 6;

/// Counts rapid events per site.
#[derive(Clone, Copy, Debug)]
pub struct Chatter<const S: usize> {
    recent: [(f64, u32); S],
    natural: bool,
}

impl<const S: usize> Chatter<S> {
    pub fn new() -> Self {
        Self { recent: [(f64::NEG_INFINITY, 0); S], natural: false }
    }

    /// Notes an event; true if the next step should take the natural branches at this site.
    pub fn note(&mut self, site: usize, t: f64) -> bool {
        let (last, count) = &mut self.recent[site];
        *count = if t - *last <= SPACING_S { *count + 1 } else { 0 };
        *last = t;
        let enough = *count >= ENOUGH;
        if enough {
            *count = 0;
            self.natural = true;
        }
        enough
    }

    /// Whether a step on natural branches has just been taken.
    pub fn over(&mut self) -> bool {
        std::mem::take(&mut self.natural)
    }
}
