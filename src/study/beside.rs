//! `OUT.study.json` beside the results of a sweep: which study they are of, with its exact text, and the checksum of their
//! bytes. By it a sweep that is started again knows its own, and leaves what somebody has changed alone.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::sweep::Study;
use crate::files::checksum;

/// What stands there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beside {
    /// Version of the program.
    pub phalanx: String,
    /// Name of the study.
    pub study: String,
    pub model: String,
    /// Of study, base scene, model and version.
    pub fingerprint: String,
    /// CRC-32 of the bytes of the results, 8 hexadecimal digits.
    pub results: String,
    pub rows: u64,
    pub study_toml: String,
    pub scene_toml: String,
}

impl Beside {
    /// What is to be said of results of a study, with so many rows and of this checksum.
    pub fn new(study: &Study, rows: u64, crc: u32) -> Self {
        Beside {
            phalanx: env!("CARGO_PKG_VERSION").to_string(),
            study: study.name.clone(),
            model: study.model.name().to_string(),
            fingerprint: study.fingerprint(),
            results: digits(crc),
            rows,
            study_toml: study.source.clone(),
            scene_toml: study.base.clone(),
        }
    }

    /// As a file.
    ///
    /// # Errors
    /// None that are known: it is texts and a number.
    pub fn text(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| format!("{text}\n"))
    }

    /// Whether a file has the bytes of these results.
    pub fn is_of(&self, out: &Path) -> bool {
        checksum(out, u64::MAX).is_ok_and(|(crc, _)| digits(crc) == self.results)
    }
}

/// What stands beside OUT: nothing, something that says what it should, or something else.
pub fn beside(out: &Path) -> Option<Result<Beside, serde_json::Error>> {
    fs::read(beside_name(out)).ok().map(|bytes| serde_json::from_slice(&bytes))
}

/// Its name.
pub fn beside_name(out: &Path) -> PathBuf {
    let mut name = OsString::from(out);
    name.push(".study.json");
    PathBuf::from(name)
}

fn digits(crc: u32) -> String {
    format!("{crc:08x}")
}
