//! Reads study files.

use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;

use super::axis::{Axis, AxisValues};
use super::document::{StudyDocument, invalid_study, parse_document};
use super::error::StudyError;
use super::raw::{RawFilter, RawSample, RawStudy, schema_json};
use super::read_axis;
use super::sequence::{MAX_HALTON_AXES, Method, Sequence};
use super::template::Template;
use super::{Filter, MAX_RUNS, MAX_SHARDED_RUNS, Study};
use crate::files::read_at_most;
use crate::limits::MAX_SCENE_BYTES;
use crate::scene::check::Checker;
use crate::scene::entry::Section;
use crate::scene::error::line_column;
use crate::scene::file::too_large;
use crate::scene::keywords::SceneKind;
use crate::trace::Model;

/// Reads and checks a study file and the base scene it names.
///
/// # Errors
/// Returns an error if the study or its base scene is invalid; the message contains file, line and column.
pub fn load(path: impl AsRef<Path>) -> Result<Study, StudyError> {
    let (text, file) = read_study_file(path.as_ref())?;
    parse(&text, &file)
}

/// Returns the text of a study file, and its name for messages.
pub(in crate::study) fn read_study_file(path: &Path) -> Result<(String, String), StudyError> {
    let file = path.display().to_string();
    let unreadable = |reason: String| StudyError::Read { file: file.clone(), reason };
    if path.is_dir() {
        return Err(unreadable("it is a directory; name a study file (.toml) in it".to_string()));
    }
    let bytes = read_at_most(path, MAX_SCENE_BYTES).map_err(|error| match error.kind() {
        ErrorKind::NotFound => unreadable("there is no such file; check the path".to_string()),
        _ => unreadable(error.to_string()),
    })?;
    let bytes = bytes.ok_or_else(|| unreadable(too_large()))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let before = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]).into_owned();
        let (line, column) = line_column(&before, before.len());
        unreadable(format!("it is not UTF-8 text at {line}:{column}; save it as UTF-8, a study is a TOML file"))
    })?;
    Ok((text, file))
}

/// Parses the text of a study. `file_name` appears in messages and determines the default name and the directory of the
/// base scene.
///
/// # Errors
/// Returns an error if the study or its base scene is invalid.
pub fn parse(text: &str, file_name: &str) -> Result<Study, StudyError> {
    let StudyDocument { raw, kind, problems, scene } =
        parse_document(text, file_name, &schema_json(), |raw: &RawStudy| &raw.scene)?;
    let refuse = |problems| invalid_study(text, file_name, problems);
    let mut checker = Checker::new(text, problems);
    scene.check(&mut checker, &raw.scene);
    let axes = read_axis::read_axes(&mut checker, &raw.axes, kind);
    let sampled =
        raw.axes.iter().find(|axis| axis.from.is_present() && axis.to.is_present() && !axis.count.is_present());
    let sequence = read_sample(&mut checker, &raw.sample, &axes, raw.axes.len(), sampled.map(|axis| axis.from.span()));
    let filter = read_filter(&mut checker, &raw.filter, kind);
    let name = checker.get("name", &raw.name).unwrap_or_else(|| file_stem(file_name));
    let description = checker.get("description", &raw.description).unwrap_or_default();
    let model = checker.get_or("model", &raw.model, Model::Analytic);
    if checker.is_clean() && total_runs(&axes, sequence.as_ref()).is_none() {
        checker.push(
            None,
            format!("the study has more than {MAX_SHARDED_RUNS} runs"),
            "",
            "remove values, or sample the axes: [sample]",
        );
    }
    if !checker.is_clean() {
        return Err(refuse(checker.into_problems()));
    }

    let (table, base) = scene.assemble(text, file_name)?;
    let fields: Vec<&str> = axes.iter().flat_map(|axis| &axis.fields).map(|field| field.path.as_str()).collect();
    let invalid = |reason: String| StudyError::Read { file: file_name.to_string(), reason };
    let template = Template::new(table, &fields).map_err(invalid)?;
    let runs = total_runs(&axes, sequence.as_ref()).unwrap_or(0);
    Ok(Study {
        kind,
        name,
        description,
        model,
        checked: false,
        filter,
        axes,
        sequence,
        template,
        runs,
        source: text.to_string(),
        base,
    })
}

/// Reads the filter of a study; reports a filter that does not apply to this kind of scene.
pub(in crate::study) fn read_filter(checker: &mut Checker<'_>, raw: &Section<RawFilter>, kind: SceneKind) -> Filter {
    if kind == SceneKind::Gripper && raw.is_present() {
        checker.push(
            raw.span.clone(),
            "[filter] concerns the statics of one finger, but the base scene is a gripper",
            "has no effect",
            "remove it: the results contain the fate and the form closure of every grasp",
        );
    }
    Filter {
        force_positive: checker.get("filter.force_positive", &raw.force_positive),
        palm_force_positive: checker.get("filter.palm_force_positive", &raw.palm_force_positive),
        form_closed: checker.get("filter.form_closed", &raw.form_closed),
    }
}

/// Reads the sample of all ranges; reports a missing or invalid sample.
fn read_sample(
    checker: &mut Checker<'_>,
    raw: &Section<RawSample>,
    axes: &[Axis],
    axes_in_file: usize,
    first_range: Option<Option<Range<usize>>>,
) -> Option<Sequence> {
    let ranges = axes.iter().filter(|axis| axis.len().is_none()).count();
    if !raw.is_present() {
        if let Some(range) = first_range {
            let help = "give the number of values: count = 10, or sample all ranges: [sample] with count = 1000";
            checker.push(range, "a range has no `count`, and there is no [sample]", "count required", help);
        }
        return None;
    }
    let method = checker.get_or("sample.method", &raw.method, Method::Halton);
    let seed = checker.get_or("sample.seed", &raw.seed, 1);
    if !raw.count.is_present() {
        checker.report_missing("count", raw, "give the number of points: count = 1000");
    }
    let count = checker.get("sample.count", &raw.count)?;
    if count > MAX_SHARDED_RUNS {
        let help = format!("take at most {MAX_SHARDED_RUNS} points");
        checker.push(raw.count.span(), format!("`sample.count` is {count}, which is too large"), "too many", help);
        return None;
    }
    // Every part of a study shuffles the slices of all points in memory before its first run.
    if method == Method::LatinHypercube && count > MAX_RUNS {
        let message = format!("`sample.count` is {count}, but a latin-hypercube has at most {MAX_RUNS} points");
        let help = "take fewer, or use method = \"halton\" or \"random\", whose points need no memory";
        checker.push(raw.count.span(), message, "too many for this method", help);
        return None;
    }
    if ranges == 0 && axes.len() == axes_in_file {
        let help = "give an axis with `from` and `to` but without `count`, or remove [sample]";
        checker.push(raw.span.clone(), "[sample] has no range to sample", "nothing to sample", help);
    }
    if method == Method::Halton && ranges > MAX_HALTON_AXES {
        let message = format!("a halton sample has at most {MAX_HALTON_AXES} axes, but the study has {ranges}");
        checker.push(raw.method.span(), message, "too many axes", "use method = \"latin-hypercube\"");
    }
    Some(Sequence::new(method, count, seed, ranges))
}

/// Number of runs; `None` if it exceeds [`MAX_SHARDED_RUNS`].
fn total_runs(axes: &[Axis], sequence: Option<&Sequence>) -> Option<u64> {
    let lengths = axes.iter().filter_map(Axis::len).map(|len| len as u64);
    let sampled = axes.iter().any(|axis| matches!(axis.values, AxisValues::Range(_)));
    let points = sequence.filter(|_| sampled).map_or(1, Sequence::count);
    let product = lengths.chain([points]).try_fold(1u64, u64::checked_mul);
    product.filter(|total| *total <= MAX_SHARDED_RUNS)
}

/// File name without its extension; `study` if it is empty.
pub(in crate::study) fn file_stem(file_name: &str) -> String {
    let file_stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy();
    if file_stem.trim().is_empty() { "study".into() } else { file_stem.into_owned() }
}
