//! Errors during a hold study.

use super::evaluation::LoadOutcome;
use crate::criteria::Fate;
use crate::scene::WrongKind;
use crate::units::MAX_TIME_S;

/// Error during a hold study.
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
         of the loads with --at", fate.name(), end_s * 1e3
    )]
    NotGrasped { end_s: f64, fate: Fate },
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
    #[error("interrupted after {done} runs")]
    Stopped { done: u64 },
}
