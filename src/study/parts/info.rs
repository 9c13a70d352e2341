//! What a part says of itself.

use std::path::Path;

use serde::Serialize;

use super::error::PartError;
use crate::study::sweep::{MOST_SHARDED_RUNS, Shard, Study, columns, range};
use crate::table::{Groups, TableError};

/// What is in the metadata of a part, each under the name of its field with `phalanx.` before it; `shard` as `3/7`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PartInfo {
    /// Version of the program that made it.
    pub version: String,
    /// Name of the study.
    pub study: String,
    pub model: String,
    /// Whether every run was checked.
    pub checked: bool,
    /// Of study, base scene, model, checks and version.
    pub fingerprint: String,
    #[serde(flatten)]
    pub shard: Shard,
    /// Runs of the whole study.
    pub runs: u64,
}

impl PartInfo {
    /// Of a part of a study that is made now.
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

    /// As notes of a table.
    pub(super) fn notes(&self) -> Vec<(String, String)> {
        let Shard { number, of, first, last } = self.shard;
        let notes = [
            ("version", self.version.clone()),
            ("study", self.study.clone()),
            ("model", self.model.clone()),
            ("checked", self.checked.to_string()),
            ("fingerprint", self.fingerprint.clone()),
            ("shard", format!("{number}/{of}")),
            ("first_run", first.to_string()),
            ("last_run", last.to_string()),
            ("runs", self.runs.to_string()),
        ];
        notes.map(|(name, text)| (format!("phalanx.{name}"), text)).to_vec()
    }

    /// Why it is no part of the study, though it is one of another; `None` if it is.
    pub(super) fn foreign(&self, study: &Study) -> Option<String> {
        if self.fingerprint == study.fingerprint() {
            return None;
        }
        let checks = |checked: bool| if checked { "with --check" } else { "without --check" };
        let wanted = PartInfo::new(study, self.shard);
        Some(if self.version != wanted.version {
            format!(
                "it was made by phalanx {}, and this is {}, whose numbers may differ in their last digits; make all parts \
                 and their merge with one version",
                self.version, wanted.version
            )
        } else if self.model != wanted.model {
            format!(
                "it has the {} model and the study {}; say the same model (--model {}) of parts and merge",
                self.model, wanted.model, self.model
            )
        } else if self.checked != wanted.checked {
            format!("it was made {}, which is not asked for now; say the same of parts and merge", checks(self.checked))
        } else if self.study != wanted.study {
            format!("it is a part of the study `{}`, and this is `{}`", self.study, wanted.study)
        } else {
            format!(
                "its study `{}`, or the base scene of that, has been changed since (fingerprint {}, now {})",
                self.study, self.fingerprint, wanted.fingerprint
            )
        })
    }
}

/// Opens a part and reads what it says of itself.
///
/// # Errors
/// It cannot be read, or is no part.
pub(super) fn open(path: &Path) -> Result<(PartInfo, Groups), PartError> {
    let not = |reason: String| PartError::NotAPart { file: path.display().to_string(), reason };
    let groups = Groups::open(path).map_err(|error| match error {
        TableError::Read { reason, .. } => PartError::Read { file: path.display().to_string(), reason },
        TableError::Parquet { reason, .. } => not(reason),
        error => not(error.to_string()),
    })?;
    let note = |name: &str| groups.note(&format!("phalanx.{name}")).map(String::from);
    let number = |name: &str| note(name)?.parse::<u64>().ok();
    let read = || {
        let shard = note("shard")?;
        let (number_of_it, of) = shard.split_once('/')?;
        Some(PartInfo {
            version: note("version")?,
            study: note("study")?,
            model: note("model")?,
            checked: note("checked")?.parse().ok()?,
            fingerprint: note("fingerprint")?,
            shard: Shard {
                number: number_of_it.parse().ok()?,
                of: of.parse().ok()?,
                first: number("first_run")?,
                last: number("last_run")?,
            },
            runs: number("runs")?,
        })
    };
    let Some(info) = read() else {
        return Err(not("it does not say of which study it is a part, as what --shard writes does".to_string()));
    };
    let known = info.runs <= MOST_SHARDED_RUNS;
    let agrees = known && range(info.runs, info.shard.number, info.shard.of) == Some(info.shard);
    if !agrees || groups.rows() != info.shard.runs() {
        return Err(PartError::Damaged {
            file: path.display().to_string(),
            reason: format!("its rows are not those of shard {}/{}", info.shard.number, info.shard.of),
        });
    }
    Ok((info, groups))
}

/// Whether the rows of an opened part are those that were written.
///
/// # Errors
/// They are not, or cannot be read.
pub(super) fn sound(path: &Path, study: &Study, (info, groups): (&PartInfo, &Groups)) -> Result<(), PartError> {
    let file = || path.display().to_string();
    if groups.columns() != columns(study) {
        return Err(PartError::Damaged { file: file(), reason: "it has other columns than the study".to_string() });
    }
    if info.runs != study.runs() {
        let reason = format!("it says that the study has {} runs, and it has {}", info.runs, study.runs());
        return Err(PartError::Damaged { file: file(), reason });
    }
    match groups.sound() {
        Ok(true) => Ok(()),
        Ok(false) => {
            Err(PartError::Damaged { file: file(), reason: "its bytes are not those that were written".to_string() })
        }
        Err(error) => Err(PartError::Read { file: file(), reason: error.to_string() }),
    }
}
