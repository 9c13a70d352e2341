//! `phalanx run --watch`: the run again whenever its scene is saved.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use super::interrupt::Interrupt;
use super::output::{complain, note};
use super::set::files;
use super::{Failure, Status};

/// How often the file is looked at, and how long an editor may take to write it.
const PERIOD: Duration = Duration::from_millis(100);

/// Runs `once` now and after each change of the scene, until a signal comes. A run that fails is told and waited out: the
/// next change may mend it. `once` gets whether it is the first.
pub(super) fn watch(scene: &Path, mut once: impl FnMut(bool) -> Result<Status, Failure>) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    let mut first = true;
    loop {
        let files = files(scene);
        let seen = stamps(&files);
        let status = once(first).unwrap_or_else(|failure| {
            complain(&failure.message);
            failure.status
        });
        first = false;
        if interrupt.signal().is_some() {
            return Ok(status);
        }
        note(&format!("\nwatching {}: save it and it runs again; Ctrl-C ends", scene.display()));
        // A file that is gone is about to be replaced, as many editors save.
        while matches!(stamps(&files), found if found == seen || found.is_none()) {
            if interrupt.signal().is_some() {
                return Ok(Status::Done);
            }
            sleep(PERIOD);
        }
        sleep(PERIOD);
    }
}

/// What changes when one of the files is saved; `None` where one is not there.
fn stamps(paths: &[PathBuf]) -> Option<Vec<(SystemTime, u64)>> {
    paths.iter().map(|path| stamp(path)).collect()
}

fn stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let found = fs::metadata(path).ok()?;
    Some((found.modified().ok()?, found.len()))
}
