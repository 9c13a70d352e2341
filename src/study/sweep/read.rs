//! From a study file to a study.

use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;

use super::axis::{Axis, Points};
use super::document::{Document, document, refused};
use super::error::StudyError;
use super::raw::{RawFilter, RawSample, RawStudy, schema_json};
use super::read_axis;
use super::sequence::{MOST_HALTON, Method, Sequence};
use super::template::Template;
use super::{Filter, MOST_RUNS, MOST_SHARDED_RUNS, Study};
use crate::files::read_at_most;
use crate::limits::LARGEST_SCENE_BYTES;
use crate::scene::check::Checker;
use crate::scene::entry::Section;
use crate::scene::error::line_column;
use crate::scene::file::too_large;
use crate::scene::words::SceneKind;
use crate::trace::Model;

/// Reads and checks a study file and the base scene it names.
///
/// # Errors
/// What is wrong with either, with file, line and column.
pub fn load(path: impl AsRef<Path>) -> Result<Study, StudyError> {
    let (text, file) = text_of(path.as_ref())?;
    parse(&text, &file)
}

/// The text of a study file, and its name for messages.
pub(in crate::study) fn text_of(path: &Path) -> Result<(String, String), StudyError> {
    let file = path.display().to_string();
    let unreadable = |reason: String| StudyError::Read { file: file.clone(), reason };
    if path.is_dir() {
        return Err(unreadable("it is a directory; name a study file (.toml) in it".to_string()));
    }
    let bytes = read_at_most(path, LARGEST_SCENE_BYTES).map_err(|error| match error.kind() {
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

/// Checks the text of a study; `file_name` appears in messages, gives the default name, and the directory from which a
/// base scene is looked for.
///
/// # Errors
/// What is wrong with the study or its base scene.
pub fn parse(text: &str, file_name: &str) -> Result<Study, StudyError> {
    let Document { raw, kind, problems, scene } =
        document(text, file_name, &schema_json(), |raw: &RawStudy| &raw.scene)?;
    let refuse = |problems| refused(text, file_name, problems);
    let mut c = Checker::new(text, problems);
    scene.check(&mut c, &raw.scene);
    let axes = read_axis::axes(&mut c, &raw.axes, kind);
    let range = raw.axes.iter().find(|axis| axis.from.is_given() && axis.to.is_given() && !axis.count.is_given());
    let sequence = sample(&mut c, &raw.sample, &axes, raw.axes.len(), range.map(|axis| axis.from.span()));
    let filter = filter_of(&mut c, &raw.filter, kind);
    let name = c.get("name", &raw.name).unwrap_or_else(|| stem(file_name));
    let description = c.get("description", &raw.description).unwrap_or_default();
    let model = c.or("model", &raw.model, Model::Analytic);
    if c.is_clean() && total(&axes, sequence.as_ref()).is_none() {
        c.push(
            None,
            format!("the study has more than {MOST_SHARDED_RUNS} runs"),
            "",
            "leave out values, or sample the axes: [sample]",
        );
    }
    if !c.is_clean() {
        return Err(refuse(c.into_problems()));
    }

    let (table, base) = scene.put_together(text, file_name)?;
    let fields: Vec<&str> = axes.iter().flat_map(|axis| &axis.fields).map(|field| field.path.as_str()).collect();
    let broken = |reason: String| StudyError::Read { file: file_name.to_string(), reason };
    let template = Template::new(table, &fields).map_err(broken)?;
    let runs = total(&axes, sequence.as_ref()).unwrap_or(0);
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

/// Which designs are simulated; notes where that cannot be said.
pub(in crate::study) fn filter_of(c: &mut Checker<'_>, raw: &Section<RawFilter>, kind: SceneKind) -> Filter {
    if kind == SceneKind::Gripper && raw.is_given() {
        c.push(
            raw.span.clone(),
            "[filter] is about the statics of one finger, but the base scene is a gripper",
            "has no effect",
            "remove it: the results say of every run what became of the grasp and whether it is form-closed",
        );
    }
    Filter {
        force_positive: c.get("filter.force_positive", &raw.force_positive),
        palm_force_positive: c.get("filter.palm_force_positive", &raw.palm_force_positive),
        form_closed: c.get("filter.form_closed", &raw.form_closed),
    }
}

/// The sample of all ranges; notes what is wrong with it, or lacking.
fn sample(
    c: &mut Checker<'_>,
    raw: &Section<RawSample>,
    axes: &[Axis],
    given: usize,
    first_range: Option<Option<Range<usize>>>,
) -> Option<Sequence> {
    let ranges = axes.iter().filter(|axis| axis.len().is_none()).count();
    if !raw.is_given() {
        if let Some(range) = first_range {
            let help = "say how many values: count = 10, or spread points over all ranges: [sample] with count = 1000";
            c.push(range, "a range has no `count`, and there is no [sample]", "how many values?", help);
        }
        return None;
    }
    let method = c.or("sample.method", &raw.method, Method::Halton);
    let seed = c.or("sample.seed", &raw.seed, 1);
    if !raw.count.is_given() {
        c.missing("count", raw, "say how many points: count = 1000");
    }
    let count = c.get("sample.count", &raw.count)?;
    if count > MOST_SHARDED_RUNS {
        let help = format!("take at most {MOST_SHARDED_RUNS} points");
        c.push(raw.count.span(), format!("`sample.count` is {count}, too many to be run"), "too many", help);
        return None;
    }
    // Its slices are shuffled in memory before the first run, and every part of a study would do that again.
    if method == Method::LatinHypercube && count > MOST_RUNS {
        let message = format!("`sample.count` is {count}, but a latin-hypercube has at most {MOST_RUNS} points");
        let help =
            "take fewer, or use method = \"halton\" or \"random\": their points are found from their numbers alone";
        c.push(raw.count.span(), message, "too many for this method", help);
        return None;
    }
    if ranges == 0 && axes.len() == given {
        let help = "give axes with `from` and `to` and without `count`, or remove [sample]";
        c.push(raw.span.clone(), "[sample] has no range to take its points from", "nothing to sample", help);
    }
    if method == Method::Halton && ranges > MOST_HALTON {
        let message = format!("a halton sample has at most {MOST_HALTON} axes, and these are {ranges}");
        c.push(raw.method.span(), message, "too many axes", "use method = \"latin-hypercube\"");
    }
    Some(Sequence::new(method, count, seed, ranges))
}

/// How many runs there are; `None` if more than anybody can run.
fn total(axes: &[Axis], sequence: Option<&Sequence>) -> Option<u64> {
    let given = axes.iter().filter_map(Axis::len).map(|len| len as u64);
    let sampled = axes.iter().any(|axis| matches!(axis.points, Points::Range(_)));
    let points = sequence.filter(|_| sampled).map_or(1, Sequence::count);
    let product = given.chain([points]).try_fold(1u64, u64::checked_mul);
    product.filter(|total| *total <= MOST_SHARDED_RUNS)
}

/// The file's name without its extension.
pub(in crate::study) fn stem(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy();
    if stem.trim().is_empty() { "study".into() } else { stem.into_owned() }
}
