//! Tension of a tendon: its spring and damper, which cannot push, and its actuator.

use crate::analytic::ContactState;
use crate::mechanism::Tendon;
use crate::mechanism::tendon::Bend;

/// A tendon of a mechanism in the model.
#[derive(Clone, Debug)]
pub(super) struct Cable {
    /// The tendon; the tension of its actuator is never negative.
    pub tendon: Tendon,
    /// Index of the cable among the contacts, if it has a spring or a damper.
    pub contact: Option<usize>,
    /// Index of its first path element among those of all cables.
    pub first: usize,
    /// Index among the contacts of the friction of each path element; empty if none has friction.
    pub frictions: Vec<Option<usize>>,
}

/// Tension of the spring and damper with its derivatives by elongation and rate, and the tension of the actuator with its
/// rate.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tension {
    pub elastic: f64,
    pub by_elongation: f64,
    pub by_rate: f64,
    pub pull: f64,
    pub pull_rate: f64,
}

impl Tension {
    pub fn total(&self) -> f64 {
        self.elastic + self.pull
    }
}

impl Cable {
    /// Builds a cable without contacts.
    pub fn new(tendon: &Tendon) -> Self {
        let mut tendon = tendon.clone();
        tendon.actuator.iter_mut().for_each(|actuator| actuator.tension = actuator.tension.positive_part());
        Self { tendon, contact: None, first: 0, frictions: Vec::new() }
    }

    /// Builds all cables without contacts.
    pub fn all(tendons: &[Tendon]) -> Vec<Self> {
        let mut first = 0;
        let cable = |tendon: &Tendon| {
            let cable = Self { first, ..Self::new(tendon) };
            first += tendon.path.len();
            cable
        };
        tendons.iter().map(cable).collect()
    }

    /// How the cable passes its path, from the bends at the path elements of all cables. One without places between its ends
    /// passes both: a measured distance is such a cable, and is not among those of the mechanism.
    #[inline(always)]
    pub fn bends<'a>(&self, all: &'a [Bend]) -> &'a [Bend] {
        const ENDS: [Bend; 2] = [Bend::Left; 2];
        if self.tendon.path.len() == ENDS.len() { &ENDS } else { &all[self.first..][..self.tendon.path.len()] }
    }

    /// Tension of the actuator and its rate.
    pub fn pull(&self, t: f64) -> (f64, f64) {
        self.tendon.actuator.as_ref().map_or((0.0, 0.0), |actuator| actuator.tension.at(t))
    }

    /// Tension on a branch of the law. The law of the active branch continues beyond the end of the branch, so that the
    /// force of the damper does not jump within a step.
    pub fn tension(&self, t: f64, state: Option<ContactState>, value: f64, rate: f64) -> Tension {
        let (pull, pull_rate) = self.pull(t);
        let (k, c) = (self.tendon.stiffness_n_per_m, self.tendon.damping_n_s_per_m);
        let elastic = k * value + c * rate;
        let is_taut = match state {
            Some(ContactState::Active) => true,
            Some(ContactState::Clamped) => value > 0.0 && elastic > 0.0,
            _ => false,
        };
        let spring = Tension { elastic, by_elongation: k, by_rate: c, ..Tension::default() };
        Tension { pull, pull_rate, ..if is_taut { spring } else { Tension::default() } }
    }
}
