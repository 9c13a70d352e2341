//! `phalanx run --html` and `--open`: the page of a run, written directly from the simulation.

use std::path::{Path, PathBuf};

use clap::Args;

use super::browser::Browser;
use super::targets::save;
use super::{Failure, Status};
use crate::page::{Page, Playback, render_page};

/// Flags of the page.
#[derive(Debug, Args)]
pub(crate) struct PageArgs {
    /// Write a page for any browser, also offline: an animation, plots and events. If the run has too many samples for a
    /// page, some are omitted and the page states this
    #[arg(long, value_name = "FILE.html")]
    pub(super) html: Option<PathBuf>,

    /// Open the page in the browser; without --html it is written to the directory for temporary files
    #[arg(long)]
    open: bool,
}

/// Page to write for a run.
pub(super) struct PageOutput {
    target: PathBuf,
    browser: Option<Browser>,
}

impl PageArgs {
    /// Returns an error for `--watch --open` without `--html`, because each run would write another temporary page.
    pub(crate) fn ensure_watchable(&self) -> Result<(), Failure> {
        match (self.open, &self.html) {
            (true, None) => Err(Failure::bad_input(
                "--watch --open: every run would write a page of another name; name the page with --html FILE.html, open it once, \
                 and reload it after each run",
            )),
            _ => Ok(()),
        }
    }

    /// Finds the browser and the target before the simulation. Only the `first` of several runs opens its page.
    pub(crate) fn prepare(&self, first: bool) -> Result<Option<PageOutput>, Failure> {
        let browser = if self.open && first { Some(Browser::find()) } else { None };
        let browser = browser.transpose().map_err(|reason| Failure::bad_input(format!("--open: {reason}")))?;
        let target = match (&self.html, &browser) {
            (Some(target), _) => target.clone(),
            (None, Some(_)) => create_temporary_page("--html")?,
            (None, None) => return Ok(None),
        };
        Ok(Some(PageOutput { target, browser }))
    }
}

impl PageOutput {
    /// Writes the page and returns its path.
    pub fn write(&self, name: &str, description: &str, playback: Playback) -> Result<String, Failure> {
        let contents = Page {
            title: name.to_string(),
            description: description.to_string(),
            runs: vec![playback],
            ..Page::default()
        };
        save(&self.target, &render_page(&contents))?;
        Ok(self.target.display().to_string())
    }

    fn show(&self) -> Result<(), Failure> {
        self.browser.as_ref().map_or(Ok(()), |browser| open_page(browser, &self.target))
    }
}

/// Opens a written page.
pub(super) fn open_page(browser: &Browser, page: &Path) -> Result<(), Failure> {
    browser.open(page).map_err(|reason| {
        let page = page.display();
        Failure::incomplete(format!("the page {page} was written, but could not be opened: {reason}; open it manually"))
    })
}

/// Opens the page, even after a failed run. Returns the failure of the run, else the failure of the page.
pub(super) fn finish(
    output: Option<&PageOutput>,
    page: Option<Result<String, Failure>>,
    run: Result<Status, Failure>,
) -> Result<Status, Failure> {
    let page_result = match (output, page) {
        (Some(output), Some(Ok(_))) => output.show(),
        (_, Some(Err(error))) => Err(error),
        _ => Ok(()),
    };
    let status = run?;
    page_result.map(|()| status)
}

/// Creates a temporary file for a page. The file is not deleted, because the browser may read it after this process has
/// ended.
pub(super) fn create_temporary_page(flag: &str) -> Result<PathBuf, Failure> {
    let file = tempfile::Builder::new().prefix("phalanx-").suffix(".html").tempfile();
    let path = file.and_then(|file| file.into_temp_path().keep().map_err(|error| error.error));
    path.map_err(|error| {
        Failure::bad_input(format!(
            "cannot create a temporary file: {error}; name a file for the page with {flag} FILE.html"
        ))
    })
}
