//! Which files phalanx has written, by what is in them: only these are replaced, for a slip of the hand must not cost another.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::Failure;
use crate::files::place;
use crate::plot::PICTURE_MARK;
use crate::report::optimize::is_designs;
use crate::report::samples::is_samples;
use crate::report::select::is_ranking;
use crate::{log, table};

/// What a file is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Page,
    Picture,
    Log,
    /// A table of the samples of a log.
    Samples,
    /// A table of selected designs.
    Ranking,
    /// A table of the designs of an optimisation.
    Designs,
}

/// Every page has it in its head.
const PAGE_MARK: &str = "<meta name=\"generator\" content=\"phalanx\">";

/// As much of a file as its mark is in.
const HEAD_BYTES: u64 = 4096;

impl Form {
    /// With its article, for messages.
    fn name(self) -> &'static str {
        match self {
            Form::Page => "a page",
            Form::Picture => "a picture",
            Form::Log => "a log",
            Form::Samples => "a table of samples",
            Form::Ranking => "a ranking",
            Form::Designs => "a table of designs",
        }
    }

    /// Forms that tell by themselves who wrote them, by the ends of their names.
    pub fn of_name(name: &str) -> Option<Form> {
        match name.rsplit_once('.')?.1 {
            "html" => Some(Form::Page),
            "svg" => Some(Form::Picture),
            "mcap" => Some(Form::Log),
            _ => None,
        }
    }

    /// Whether phalanx wrote the file that is there, and it is of this form. An empty file is nobody's loss.
    pub fn is_own(self, path: &Path) -> io::Result<bool> {
        if fs::metadata(path)?.len() == 0 {
            return Ok(true);
        }
        let head = head(path)?;
        Ok(match self {
            Form::Page => head.contains(PAGE_MARK),
            Form::Picture => head.contains(PICTURE_MARK),
            Form::Log => log::refuse_other_files(path, path).is_ok(),
            Form::Samples => is_samples(head.lines().next().unwrap_or_default()),
            Form::Ranking => table::read(path).is_ok_and(|table| is_ranking(&table)),
            Form::Designs => table::read(path).is_ok_and(|table| is_designs(&table.columns)),
        })
    }
}

fn head(path: &Path) -> io::Result<String> {
    let mut bytes = Vec::new();
    File::open(path)?.take(HEAD_BYTES).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Refuses a place for a file where none can be written, or where one stands that is not phalanx's; before anything is computed.
pub fn writable(target: &Path, form: Form) -> Result<(), Failure> {
    let refused = |why: String| Failure::bad_input(format!("cannot write {}: {why}", target.display()));
    place(target).map_err(refused)?;
    // Pipes and devices are written to as they are, and not read.
    let file = fs::metadata(target).is_ok_and(|found| found.is_file());
    let unreadable = |error: io::Error| refused(format!("the file there cannot be read ({error}); give another name"));
    if file && !form.is_own(target).map_err(unreadable)? {
        return Err(refused(format!(
            "the file there is not {} that phalanx wrote, so it is left alone; give another name, or delete it first",
            form.name()
        )));
    }
    Ok(())
}
