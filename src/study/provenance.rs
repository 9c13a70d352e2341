//! `OUT.study.json`, the provenance file of sweep results: the study with its exact text, and the checksum of the
//! results. A restarted sweep uses it to recognise its own results and does not replace a file that was changed since.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::sweep::Study;
use crate::files::checksum;

/// Content of the provenance file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of the program.
    pub phalanx: String,
    /// Name of the study.
    pub study: String,
    pub model: String,
    /// Fingerprint of study, base scene, model and version.
    pub fingerprint: String,
    /// CRC-32 of the result file, 8 hexadecimal digits.
    pub results: String,
    pub rows: u64,
    pub study_toml: String,
    pub scene_toml: String,
}

impl Provenance {
    /// Provenance of results with this number of rows and this checksum.
    pub fn new(study: &Study, rows: u64, crc: u32) -> Self {
        Provenance {
            phalanx: env!("CARGO_PKG_VERSION").to_string(),
            study: study.name.clone(),
            model: study.model.name().to_string(),
            fingerprint: study.fingerprint(),
            results: crc_hex(crc),
            rows,
            study_toml: study.source.clone(),
            scene_toml: study.base.clone(),
        }
    }

    /// JSON text of the file.
    ///
    /// # Errors
    /// Returns an error if the serialisation fails; not expected for these fields.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| format!("{text}\n"))
    }

    /// Whether the checksum of the file is that of these results.
    pub fn matches_file(&self, out: &Path) -> bool {
        checksum(out, u64::MAX).is_ok_and(|(crc, _)| crc_hex(crc) == self.results)
    }
}

/// Reads the provenance file of `out`. `None`: there is no such file; an error: it is not a provenance file.
pub fn read_provenance(out: &Path) -> Option<Result<Provenance, serde_json::Error>> {
    fs::read(provenance_path(out)).ok().map(|bytes| serde_json::from_slice(&bytes))
}

/// Path of the provenance file of `out`.
pub fn provenance_path(out: &Path) -> PathBuf {
    let mut name = OsString::from(out);
    name.push(".study.json");
    PathBuf::from(name)
}

fn crc_hex(crc: u32) -> String {
    format!("{crc:08x}")
}
