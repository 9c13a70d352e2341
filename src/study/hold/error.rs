//! Why there is no answer.

use super::attempt::Found;
use crate::criteria::Fate;
use crate::scene::WrongKind;
use crate::units::LONGEST_S;

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum HoldError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "the object is fixed in the world, so that nothing carries it; let it move: object.motion = \"free\", or leave that key out"
    )]
    Fixed,
    #[error("without any load, the scene could not be simulated: {reason}; see `phalanx run` of it")]
    Scene { reason: String },
    #[error(
        "without any load, the object is {} at {:.3} ms, so that there is nothing to be loaded; give a scene that holds its object, or \
         say by --at when it does", fate.name(), ends_s * 1e3
    )]
    NotGrasped { ends_s: f64, fate: Fate },
    #[error(
        "loads would begin at {:.3} ms, but the fingers let go at {:.3} ms; let them begin earlier: --at TIME",
        begins_s * 1e3, releases_s * 1e3
    )]
    LetGo { begins_s: f64, releases_s: f64 },
    #[error(
        "without any load, the object slips by {:.4} mm from {:.3} ms to {:.3} ms and is {} then: the bound of {:.4} mm says nothing of \
         loads; give friction that holds (contact.friction.law = \"bristle\"), a larger --slip, or another --at",
        found.slip.displacement_m * 1e3, begins_s * 1e3, found.end_s * 1e3, found.fate.name(), bound_m * 1e3
    )]
    Unloaded { begins_s: f64, bound_m: f64, found: Found },
    #[error(
        "the object lies on a table, and under the smallest load, {peak_m_s2} m/s², the palm would press it against it; lift it before, such as by \
         --set moves.lift.y=\"-25 mm\" --set moves.lift.start=\"20 ms\" --set moves.lift.time=\"40 ms\", take the table away by --set \
         table.present=false"
    )]
    Table { peak_m_s2: f64 },
    #[error(
        "a run under these loads would go on for {over_s:.2e} s, and a run may take {LONGEST_S} s; give a higher frequency \
         (--vibration), a larger --from of a --move, a shorter --pulse, or an earlier --at"
    )]
    TooLong { over_s: f64 },
    #[error("it was stopped after {done} runs")]
    Stopped { done: u64 },
}
