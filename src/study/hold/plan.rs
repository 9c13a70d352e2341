//! What is asked.

use crate::scene::Axis;
use crate::trace::Model;

/// How long a run goes on when its load is over, s: what has lost its contacts is gone by then, and what rattles is not.
pub const AFTER_S: f64 = 30e-3;
/// Slower than this, m/s, an object is at rest in the hand: in a pulse of 40 ms it would creep by 40 µm.
pub const REST_M_S: f64 = 1e-3;

/// What moves the palm.
#[derive(Clone, Debug, PartialEq)]
pub enum Loads {
    /// In so many directions all around, each a pulse of this length.
    Pulses { directions: usize, length_s: f64 },
    /// Along each of the axes at each of the frequencies.
    Vibrations { axes: Vec<Axis>, frequencies_hz: Vec<f64> },
    /// The scene's own moves and path in another time, with its vibrations, or the standard cycle of a scene without any.
    Move,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub model: Model,
    pub loads: Loads,
    /// When they begin; `None`: when the object is at rest, or the scene's own motion says.
    pub begins_s: Option<f64>,
    /// How far the object may slip in the hand.
    pub slip_m: f64,
    /// Peak accelerations of the scan: from, to, and how many in between and at both ends, from 2.
    pub from_m_s2: f64,
    pub to_m_s2: f64,
    pub scan: usize,
    /// How finely limits are found, as part of themselves.
    pub tolerance: f64,
    /// 0: one for each core. The answer does not depend on it.
    pub threads: usize,
}

/// Whether to go on, asked once a step.
pub type GoOn<'a> = &'a (dyn Fn() -> bool + Sync);

impl Default for Plan {
    /// What `phalanx hold` asks if nothing else is said.
    fn default() -> Self {
        Plan {
            model: Model::Analytic,
            loads: Loads::Pulses { directions: 8, length_s: 40e-3 },
            begins_s: None,
            slip_m: 0.5e-3,
            from_m_s2: 1.0,
            to_m_s2: 1000.0,
            scan: 11,
            tolerance: 0.02,
            threads: 0,
        }
    }
}

impl Plan {
    /// Refuses what makes no sense together.
    ///
    /// # Errors
    /// What is wrong, and what is allowed.
    pub fn check(&self) -> Result<(), String> {
        if self.from_m_s2 >= self.to_m_s2 {
            return Err(format!(
                "--from is {} m/s² and --to {} m/s²; the first must be smaller, such as --from \"1 m/s^2\" --to \"1000 m/s^2\"",
                self.from_m_s2, self.to_m_s2
            ));
        }
        if !(2..=1000).contains(&self.scan) {
            return Err(format!("--scan is {}; expected a number from 2 to 1000, such as 11", self.scan));
        }
        if !(1e-9..1.0).contains(&self.tolerance) {
            return Err(format!("--tol is {}; expected a number from 1e-9 to below 1, such as 0.02", self.tolerance));
        }
        match &self.loads {
            Loads::Pulses { directions, .. } if !(1..=360).contains(directions) => {
                Err(format!("--directions is {directions}; expected a number from 1 to 360, such as 8"))
            }
            Loads::Vibrations { axes, .. } if twice(axes) => {
                Err("--along names an axis twice; each once, such as --along x,y,angle".to_string())
            }
            Loads::Vibrations { frequencies_hz, .. } if twice(frequencies_hz) => {
                Err("a frequency is there twice; expected frequencies such as \"50 Hz, 200 Hz\"".to_string())
            }
            _ => Ok(()),
        }
    }
}

fn twice<T: PartialEq>(of: &[T]) -> bool {
    of.iter().enumerate().any(|(index, one)| of[..index].contains(one))
}
