//! Parameters and errors of a hold study.

use crate::criteria::{Fate, ObjectCriteria, Travel};
use crate::scene::{Axis, WrongKind};
use crate::statics::NoGrasp;
use crate::trace::{Model, Outcome};
use crate::units::MAX_TIME_S;
use phalanx_parallel::ComputeError;

/// Time for which a run continues after its load, s. An object without contacts has left the hand by then, while a
/// rattling one has not.
pub(crate) const SETTLING_S: f64 = 30e-3;

#[derive(Clone, Debug, PartialEq)]
pub enum Loads {
    /// Pulses of this duration in evenly spaced directions.
    Pulses { directions: usize, length_s: f64 },
    /// Vibrations along each of the axes at each of the frequencies.
    Vibrations { axes: Vec<Axis>, frequencies_hz: Vec<f64> },
    /// The moves and the path of the scene with a scaled duration, together with its vibrations. If the scene has no
    /// moves, the standard cycle is used.
    Move,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub model: Model,
    pub loads: Loads,
    /// Time at which the loads begin, s. With `None`, it is determined from the rest of the object, or from the scene's
    /// own motion.
    pub start_s: Option<f64>,
    /// Largest allowed slip of the object in the hand, m.
    pub slip_m: f64,
    pub from_m_s2: f64,
    pub to_m_s2: f64,
    /// Number of loads of the scan, including the smallest and the largest; at least 2.
    pub scan: usize,
    /// Relative tolerance of the limits.
    pub tolerance: f64,
    /// Number of threads; 0 for one per core. Results do not depend on it.
    pub threads: usize,
}

impl Default for Plan {
    /// Default parameters of `phalanx hold`.
    fn default() -> Self {
        Plan {
            model: Model::Analytic,
            loads: Loads::Pulses { directions: 8, length_s: 40e-3 },
            start_s: None,
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
    /// Checks the parameters.
    ///
    /// # Errors
    /// Returns an error that names the invalid parameter and the allowed values.
    pub fn check(&self) -> Result<(), String> {
        if self.from_m_s2 >= self.to_m_s2 {
            return Err(format!(
                "--from is {} m/s² and --to {} m/s²; --from must be smaller, such as --from \"1 m/s^2\" --to \"1000 m/s^2\"",
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
            Loads::Vibrations { axes, .. } if has_duplicates(axes) => {
                Err("--along names an axis twice; name each axis once, such as --along x,y,angle".to_string())
            }
            Loads::Vibrations { frequencies_hz, .. } if has_duplicates(frequencies_hz) => {
                Err("a frequency is given twice; expected frequencies such as \"50 Hz, 200 Hz\"".to_string())
            }
            _ => Ok(()),
        }
    }
}

fn has_duplicates<T: PartialEq>(values: &[T]) -> bool {
    values.iter().enumerate().any(|(index, value)| values[..index].contains(value))
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOutcome {
    pub fate: Fate,
    /// Slip in the hand since the start of the load. It is `grasp.cycle.carried` of a run.
    pub slip: Travel,
    /// Largest rotation of a driven joint against its brake, rad; 0 without brakes.
    pub brake_slip_rad: f64,
    pub end_s: f64,
    pub steps: u64,
}

impl LoadOutcome {
    pub(super) fn new(criteria: &ObjectCriteria, outcome: &Outcome) -> Self {
        LoadOutcome {
            fate: criteria.fate,
            // None only if the object left the hand before the load; `fate` reports this.
            slip: criteria.cycle.motion_travel.unwrap_or_default(),
            brake_slip_rad: criteria.cycle.brake_slip_rad.iter().copied().flatten().fold(0.0, f64::max),
            end_s: outcome.last.time_s,
            steps: outcome.work.steps,
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum HoldError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "the object is fixed in the world, so the gripper does not hold it; set object.motion = \"free\" or remove that key"
    )]
    FixedObject,
    #[error("the scene could not be simulated without a load: {reason}; check it with `phalanx run`")]
    Scene { reason: String },
    #[error(
        "without a load, the object is {} at {:.3} ms, so no load can be applied; use a scene that holds its object, or set the start \
         of the loads with --at", fate.name(), at_s * 1e3
    )]
    NotGrasped { at_s: f64, fate: Fate },
    #[error(
        "loads would start at {:.3} ms, but the fingers release at {:.3} ms; set an earlier start: --at TIME",
        start_s * 1e3, release_s * 1e3
    )]
    ReleasedBeforeLoad { start_s: f64, release_s: f64 },
    #[error(
        "without a load, the object slips by {:.4} mm from {:.3} ms to {:.3} ms and is {} at the end, so the bound of {:.4} mm cannot be \
         applied to loads; use friction with stiction (contact.friction.law = \"bristle\"), a larger --slip, or another --at",
        outcome.slip.displacement_m * 1e3, start_s * 1e3, outcome.end_s * 1e3, outcome.fate.name(), bound_m * 1e3
    )]
    SlipsUnloaded { start_s: f64, bound_m: f64, outcome: LoadOutcome },
    #[error(
        "the object lies on a table, and the smallest load, {peak_m_s2} m/s², would press it against the table; lift it first, for example with \
         --set moves.lift.y=\"-25 mm\" --set moves.lift.start=\"20 ms\" --set moves.lift.time=\"40 ms\", or remove the table with --set \
         table.present=false"
    )]
    PressedAgainstTable { peak_m_s2: f64 },
    #[error(
        "a run under these loads would last {end_s:.2e} s, more than the {MAX_TIME_S} s allowed; set a higher frequency (--vibration), a \
         larger --from for --move, a shorter --pulse, or an earlier --at"
    )]
    TooLong { end_s: f64 },
    #[error("the scene has no grasp: {0}")]
    NoGrasp(NoGrasp),
    #[error(
        "the base `{base}` still moves at {:.3} ms, at {speed_m_s:.2e} m/s, but a load starts from rest; set another start of the loads: --at \
         TIME", time_s * 1e3
    )]
    BaseMoves { base: String, time_s: f64, speed_m_s: f64 },
    #[error(
        "loads move the base `{base}`, but `moves`, `vibrations` or `path` move `{moving}`; give both the same body, with `base` in [grasp] or \
         `body` of the motion"
    )]
    OtherBodyMoves { base: String, moving: String },
    #[error(
        "{what} connects the hand with what carries its base `{base}`, which a load moves alone; fix its end on the ground to `{base}`"
    )]
    TiedBase { base: String, what: String },
    #[error(transparent)]
    Stopped(#[from] ComputeError),
}

impl HoldError {
    pub(super) fn no_grasp() -> Self {
        HoldError::NoGrasp(NoGrasp::Nothing)
    }
}
