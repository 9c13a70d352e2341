//! The Python package of phalanx: a thin face of its library. Nothing is computed here.
//!
//! | file | job |
//! |---|---|
//! | `errors` | errors of the library as exceptions |
//! | `watch` | work without the interpreter's lock, ended by Ctrl-C |
//! | `words` | values of Python as those of a scene, and JSON as Python |
//! | `columns` | columns as numpy sees them, and as Arrow |
//! | `scene` | scenes |
//! | `result`, `simulate` | runs, made or read from logs |
//! | `table` | tables of sweeps |
//! | `study`, `evaluate` | sweeps of study files and of arrays |
//! | `documents` | what commands print as JSON |

mod columns;
mod documents;
mod errors;
mod evaluate;
mod result;
mod scene;
mod simulate;
mod study;
mod table;
mod watch;
mod words;

use pyo3::prelude::*;

/// A planar simulator of high-speed underactuated grippers: stiff contact with exact events. The compiled part of `phalanx`.
#[pymodule]
mod _phalanx {
    #[pymodule_export]
    use super::columns::Column;
    #[pymodule_export]
    use super::documents::{capture, hold, size, statics, validate};
    #[pymodule_export]
    use super::evaluate::evaluate;
    #[pymodule_export]
    use super::result::Result;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::simulate::{read_log, run};
    #[pymodule_export]
    use super::study::{_study_files, study_info, sweep, sweep_merge, sweep_shard};
    #[pymodule_export]
    use super::table::Table;

    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's own name for it")]
    const __version__: &str = phalanx_version();

    /// Of the library; both are released together.
    const fn phalanx_version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
