//! Writes playbacks as JSON. In a document, columns are base64 of little-endian `f64`; outside of one they are
//! consecutive numbers in an array.

use std::collections::BTreeMap;

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;

use super::build::Playback;

/// A run with columns of type `C`.
#[derive(Serialize)]
pub struct Run<'a, C> {
    #[serde(flatten)]
    playback: &'a Playback,
    columns: Vec<C>,
}

/// Returns the self-contained JSON document of all runs.
pub fn to_json(playbacks: &[Playback]) -> String {
    let base64 = |values: &Vec<f64>| {
        BASE64_STANDARD.encode(values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
    };
    let run = |playback| Run { playback, columns: playback.columns.iter().map(base64).collect::<Vec<_>>() };
    let document = BTreeMap::from([("runs", playbacks.iter().map(run).collect::<Vec<_>>())]);
    // Serialisation cannot fail: every key is a string, and every number that may be infinite is in a column.
    serde_json::to_string(&document).expect("a playback is plain data with string keys")
}

/// Appends the columns of a run to `data` and returns the run, which refers to each column by its offset and length.
pub(crate) fn append_run<'a>(playback: &'a Playback, data: &mut Vec<f64>) -> Run<'a, [usize; 2]> {
    let append = |column: &Vec<f64>| {
        data.extend(column);
        [data.len() - column.len(), column.len()]
    };
    Run { playback, columns: playback.columns.iter().map(append).collect() }
}
