//! Metadata of a part.

use std::path::Path;

use serde::Serialize;

use super::error::PartError;
use crate::study::sweep::{MAX_SHARDED_RUNS, Shard, Study, columns, shard_range};
use crate::table::{RowGroupReader, TableError};

/// Metadata of a part. Each key is the field name with the prefix `phalanx.`; `shard` is stored as `3/7`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PartInfo {
    /// Version of the program that wrote the part.
    pub version: String,
    /// Name of the study.
    pub study: String,
    pub model: String,
    /// Whether every run was checked.
    pub checked: bool,
    /// Fingerprint of study, base scene, model, checks and version.
    pub fingerprint: String,
    #[serde(flatten)]
    pub shard: Shard,
    /// Number of runs of the study.
    pub runs: u64,
}

impl PartInfo {
    /// Metadata of a new part of a study.
    pub fn new(study: &Study, shard: Shard) -> Self {
        PartInfo {
            version: env!("CARGO_PKG_VERSION").to_string(),
            study: study.name.clone(),
            model: study.model.name().to_string(),
            checked: study.checked,
            fingerprint: study.fingerprint(),
            shard,
            runs: study.runs(),
        }
    }

    /// Key-value metadata of the table.
    pub(super) fn to_metadata(&self) -> Vec<(String, String)> {
        let Shard { number, count, first, last } = self.shard;
        let notes = [
            ("version", self.version.clone()),
            ("study", self.study.clone()),
            ("model", self.model.clone()),
            ("checked", self.checked.to_string()),
            ("fingerprint", self.fingerprint.clone()),
            ("shard", format!("{number}/{count}")),
            ("first_run", first.to_string()),
            ("last_run", last.to_string()),
            ("runs", self.runs.to_string()),
        ];
        notes.map(|(name, text)| (format!("phalanx.{name}"), text)).to_vec()
    }

    /// Returns why the part does not belong to the study; `None` if it does.
    pub(super) fn mismatch(&self, study: &Study) -> Option<String> {
        if self.fingerprint == study.fingerprint() {
            return None;
        }
        let checks = |checked: bool| if checked { "with --check" } else { "without --check" };
        let expected = PartInfo::new(study, self.shard);
        Some(if self.version != expected.version {
            format!(
                "it was written by phalanx {}, but this is {}, whose results may differ in their last digits; run and \
                 merge all shards with one version",
                self.version, expected.version
            )
        } else if self.model != expected.model {
            format!(
                "it was simulated with the {} model, but the study has {}; use the same model (--model {}) for shards and merge",
                self.model, expected.model, self.model
            )
        } else if self.checked != expected.checked {
            format!("it was simulated {}; use the same option for shards and merge", checks(self.checked))
        } else if self.study != expected.study {
            format!("it is a shard of the study `{}`, but this is `{}`", self.study, expected.study)
        } else {
            format!(
                "its study `{}` or the base scene has been changed since (fingerprint {}, now {})",
                self.study, self.fingerprint, expected.fingerprint
            )
        })
    }
}

/// Opens a part and reads its metadata.
///
/// # Errors
/// Returns an error if the file cannot be read, or is not a part.
pub(super) fn open(path: &Path) -> Result<(PartInfo, RowGroupReader), PartError> {
    let not_a_shard_file = |reason: String| PartError::NotAPart { file: path.display().to_string(), reason };
    let groups = RowGroupReader::open(path).map_err(|error| match error {
        TableError::Read { reason, .. } => PartError::Read { file: path.display().to_string(), reason },
        TableError::Parquet { reason, .. } => not_a_shard_file(reason),
        error => not_a_shard_file(error.to_string()),
    })?;
    let note = |name: &str| groups.metadata_value(&format!("phalanx.{name}")).map(String::from);
    let number = |name: &str| note(name)?.parse::<u64>().ok();
    let read = || {
        let shard = note("shard")?;
        let (shard_number, shard_count) = shard.split_once('/')?;
        Some(PartInfo {
            version: note("version")?,
            study: note("study")?,
            model: note("model")?,
            checked: note("checked")?.parse().ok()?,
            fingerprint: note("fingerprint")?,
            shard: Shard {
                number: shard_number.parse().ok()?,
                count: shard_count.parse().ok()?,
                first: number("first_run")?,
                last: number("last_run")?,
            },
            runs: number("runs")?,
        })
    };
    let Some(info) = read() else {
        return Err(not_a_shard_file("it has no metadata about its study, which --shard writes".to_string()));
    };
    let is_within_limit = info.runs <= MAX_SHARDED_RUNS;
    let is_consistent =
        is_within_limit && shard_range(info.runs, info.shard.number, info.shard.count) == Some(info.shard);
    if !is_consistent || groups.row_count() != info.shard.runs() {
        return Err(PartError::Damaged {
            file: path.display().to_string(),
            reason: format!("its rows do not match shard {}/{}", info.shard.number, info.shard.count),
        });
    }
    Ok((info, groups))
}

/// Verifies columns, number of runs and checksum of an opened part.
///
/// # Errors
/// Returns an error if the part is damaged or cannot be read.
pub(super) fn verify_rows(
    path: &Path,
    study: &Study,
    (info, groups): (&PartInfo, &RowGroupReader),
) -> Result<(), PartError> {
    let file = || path.display().to_string();
    if groups.columns() != columns(study) {
        return Err(PartError::Damaged { file: file(), reason: "it has other columns than the study".to_string() });
    }
    if info.runs != study.runs() {
        let reason =
            format!("according to its metadata the study has {} runs, but the study has {}", info.runs, study.runs());
        return Err(PartError::Damaged { file: file(), reason });
    }
    match groups.is_intact() {
        Ok(true) => Ok(()),
        Ok(false) => Err(PartError::Damaged { file: file(), reason: "its checksum does not match".to_string() }),
        Err(error) => Err(PartError::Read { file: file(), reason: error.to_string() }),
    }
}
