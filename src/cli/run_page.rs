//! `phalanx run --html` and `--open`: the page of a run, straight from the simulation.

use std::path::{Path, PathBuf};

use clap::Args;

use super::browser::Browser;
use super::saved::save;
use super::{Failure, Status};
use crate::page::{Film, Page, page};

/// Flags of the page.
#[derive(Debug, Args)]
pub struct PageArgs {
    /// Write a page that opens in any browser, offline: the bodies in motion, plots, events. A run of more samples than a
    /// page can hold is thinned out, and the page says so
    #[arg(long, value_name = "FILE.html")]
    pub(super) html: Option<PathBuf>,

    /// Open the page in the browser; without --html it is made in the directory for temporary files
    #[arg(long)]
    open: bool,
}

/// A page that is to be made of a run.
pub(super) struct PageOrder {
    target: PathBuf,
    browser: Option<Browser>,
}

impl PageArgs {
    /// Refuses a page that each run of many would put elsewhere.
    pub fn can_be_watched(&self) -> Result<(), Failure> {
        match (self.open, &self.html) {
            (true, None) => Err(Failure::bad_input(
                "--watch --open: every run would have a page of another name; give it one with --html FILE.html, open it once, \
                 and reload it after each run",
            )),
            _ => Ok(()),
        }
    }

    /// Refuses what cannot be done before anything is simulated. Only the `first` of several runs opens its page.
    pub fn start(&self, first: bool) -> Result<Option<PageOrder>, Failure> {
        let found = if self.open && first { Some(Browser::find()) } else { None };
        let browser = found.transpose().map_err(|why| Failure::bad_input(format!("--open: {why}")))?;
        let target = match (&self.html, &browser) {
            (Some(target), _) => target.clone(),
            (None, Some(_)) => temporary("--html")?,
            (None, None) => return Ok(None),
        };
        Ok(Some(PageOrder { target, browser }))
    }
}

impl PageOrder {
    /// Writes the page; gives back its path.
    pub fn write(&self, name: &str, description: &str, film: Film) -> Result<String, Failure> {
        let contents =
            Page { title: name.to_string(), description: description.to_string(), runs: vec![film], ..Page::default() };
        save(&self.target, &page(&contents))?;
        Ok(self.target.display().to_string())
    }

    fn show(&self) -> Result<(), Failure> {
        self.browser.as_ref().map_or(Ok(()), |browser| opened(browser, &self.target))
    }
}

/// Opens a page that has been written.
pub(super) fn opened(browser: &Browser, page: &Path) -> Result<(), Failure> {
    browser.open(page).map_err(|why| {
        let page = page.display();
        Failure::incomplete(format!("the page is in {page}, but could not be opened: {why}; open it yourself"))
    })
}

/// How the command ends: by its run, else by its page, which is opened however the run ended.
pub(super) fn ended(
    order: Option<&PageOrder>,
    page: Option<Result<String, Failure>>,
    run: Result<Status, Failure>,
) -> Result<Status, Failure> {
    let shown = match (order, page) {
        (Some(order), Some(Ok(_))) => order.show(),
        (_, Some(Err(error))) => Err(error),
        _ => Ok(()),
    };
    let status = run?;
    shown.map(|()| status)
}

/// A file that nobody else has: the browser reads it when this process may be gone, so it stays.
pub(super) fn temporary(flag: &str) -> Result<PathBuf, Failure> {
    let made = tempfile::Builder::new().prefix("phalanx-").suffix(".html").tempfile();
    let kept = made.and_then(|file| file.into_temp_path().keep().map_err(|error| error.error));
    kept.map_err(|error| {
        Failure::bad_input(format!(
            "cannot make a temporary file: {error}; give the page a place with {flag} FILE.html"
        ))
    })
}
