//! Python bindings of the library of phalanx, without any computations of their own.
//!
//! | module | purpose |
//! |---|---|
//! | `errors` | errors of the library as exceptions |
//! | `interruptible` | computations without the interpreter lock, interrupted by Ctrl-C |
//! | `conversion` | Python values to scene values and quantities, JSON to Python |
//! | `quantities` | units of numbers in scenes |
//! | `columns` | columns as numpy arrays and Arrow streams |
//! | `scene` | scenes |
//! | `result`, `simulate` | results of runs and logs; running simulations and reading logs |
//! | `table` | tables of sweeps |
//! | `simulation` | simulations that Python advances |
//! | `study`, `evaluate` | sweeps of study files and of arrays |
//! | `optimisation` | study files of optimisations |
//! | `documents` | JSON documents of other commands as dictionaries |

mod columns;
mod conversion;
mod documents;
mod errors;
mod evaluate;
mod interruptible;
mod optimisation;
mod quantities;
mod result;
mod scene;
mod simulate;
mod simulation;
mod study;
mod table;

use pyo3::prelude::*;

/// Compiled module of `phalanx`, a planar simulator of high-speed underactuated grippers with stiff contact and exact
/// events.
#[pymodule]
mod _phalanx {
    #[pymodule_export]
    use super::columns::Column;
    #[pymodule_export]
    use super::documents::{capture, hold, size, statics, validate};
    #[pymodule_export]
    use super::evaluate::evaluate;
    #[pymodule_export]
    use super::optimisation::{_read_optimisation, Variable};
    #[pymodule_export]
    use super::result::Result;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::simulate::{read_log, run};
    #[pymodule_export]
    use super::simulation::{Simulation, SimulationBatch, SimulationState};
    #[pymodule_export]
    use super::study::{_study_files, study_info, sweep, sweep_merge, sweep_shard};
    #[pymodule_export]
    use super::table::Table;

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name is a Python convention")]
    const __version__: &str = phalanx_version();

    /// Version of the library and of the package, which are released together.
    const fn phalanx_version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
