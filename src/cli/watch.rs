//! `phalanx run --watch`: repeats the run whenever its scene is saved.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use super::interrupt::Interrupt;
use super::output::{print_diagnostic, print_note};
use super::set::source_files;
use super::{Failure, Status};

/// Polling period, and time for an editor to finish writing.
const PERIOD: Duration = Duration::from_millis(100);

/// Calls `run_once` immediately and after each change of the scene, until a signal arrives. A failure is printed and
/// does not end the loop, because the next change may fix it. The argument of `run_once` is whether the run is the
/// first.
pub(super) fn watch(
    scene: &Path,
    mut run_once: impl FnMut(bool) -> Result<Status, Failure>,
) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    let mut first = true;
    loop {
        let files = source_files(scene);
        let previous = file_stamps(&files);
        let status = run_once(first).unwrap_or_else(|failure| {
            print_diagnostic(&failure.message);
            failure.status
        });
        first = false;
        if interrupt.signal().is_some() {
            return Ok(status);
        }
        print_note(&format!("\nwatching {}: save the file to run again; Ctrl-C to stop", scene.display()));
        // Many editors remove the file and write a new one, so a missing file is not a change.
        while matches!(file_stamps(&files), stamps if stamps == previous || stamps.is_none()) {
            if interrupt.signal().is_some() {
                return Ok(Status::Done);
            }
            sleep(PERIOD);
        }
        sleep(PERIOD);
    }
}

/// Modification times and sizes of the files; `None` if a file is missing.
fn file_stamps(paths: &[PathBuf]) -> Option<Vec<(SystemTime, u64)>> {
    paths.iter().map(|path| file_stamp(path)).collect()
}

fn file_stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let file_metadata = fs::metadata(path).ok()?;
    Some((file_metadata.modified().ok()?, file_metadata.len()))
}
