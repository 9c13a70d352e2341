//! Opens a page in the user's browser.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time in which a program must report that it cannot open a page. A program that still runs afterwards counts as
/// successful.
const FAILURE_TIMEOUT: Duration = Duration::from_millis(1500);

/// A program that shows a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Browser {
    program: PathBuf,
    /// Argument before the path of the page.
    argument: Option<&'static str>,
}

/// Hint for a system without a browser.
const ALTERNATIVE: &str = "write the page with --html FILE.html and open that file on a computer with a browser";

impl Browser {
    /// Returns the program named by `BROWSER`, or the program that the system opens pages with.
    ///
    /// # Errors
    /// Returns an error if no such program is found; the message says why and what to do instead.
    pub fn find() -> Result<Self, String> {
        if let Some(named) = env::var_os("BROWSER").filter(|named| !named.is_empty()) {
            // BROWSER may be a list of programs; xdg-open reads it in the same way.
            let browser = env::split_paths(&named).find_map(|name| find_program(&name));
            return browser.map(|program| Browser { program, argument: None }).ok_or_else(|| {
                format!(
                    "no browser was found to open the page: BROWSER is {:?}, which names no program; set it to one, or {ALTERNATIVE}",
                    named.display().to_string()
                )
            });
        }
        if cfg!(target_os = "macos") {
            return Ok(Browser { program: "open".into(), argument: None });
        }
        if cfg!(windows) {
            return Ok(Browser { program: "explorer".into(), argument: None });
        }
        let displays = ["DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME"];
        if displays.iter().all(|name| env::var_os(name).is_none_or(|value| value.is_empty())) {
            return Err(format!(
                "no browser was found to open the page: this session has no screen (DISPLAY and WAYLAND_DISPLAY are not set); \
                 {ALTERNATIVE}"
            ));
        }
        let openers = [("wslview", None), ("xdg-open", None), ("gio", Some("open")), ("sensible-browser", None)];
        let browser = openers.into_iter().find_map(|(name, argument)| Some((find_program(Path::new(name))?, argument)));
        let (program, argument) = browser.ok_or_else(|| {
            format!(
                "no browser was found to open the page: no xdg-open is installed; install xdg-utils, set BROWSER to a program, \
                 or {ALTERNATIVE}"
            )
        })?;
        Ok(Browser { program, argument })
    }

    /// Opens a page. Does not wait until it is closed.
    ///
    /// # Errors
    /// Returns an error if the program does not start, or ends unsuccessfully within [`FAILURE_TIMEOUT`].
    pub fn open(&self, page: &Path) -> Result<(), String> {
        let mut child = Command::new(&self.program)
            .args(self.argument)
            .arg(page.canonicalize().unwrap_or_else(|_| page.to_path_buf()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("{}: {error}", self.program.display()))?;
        early_failure(&mut child).map_or(Ok(()), |reason| Err(format!("{}: {reason}", self.program.display())))
    }
}

/// Reason why a program ended unsuccessfully within [`FAILURE_TIMEOUT`]; `None` if it did not.
fn early_failure(child: &mut Child) -> Option<String> {
    let start = Instant::now();
    while start.elapsed() < FAILURE_TIMEOUT {
        match child.try_wait() {
            // The Windows explorer exits with status 1 although it shows the page.
            Ok(Some(status)) if status.success() || cfg!(windows) => return None,
            Ok(Some(status)) => return Some(status.to_string()),
            Ok(None) => sleep(Duration::from_millis(10)),
            Err(error) => return Some(error.to_string()),
        }
    }
    None
}

/// Returns the executable of a program, which is given as a path or as a name to be found in `PATH`.
fn find_program(name: &Path) -> Option<PathBuf> {
    if name.components().count() > 1 {
        return name.is_file().then(|| name.to_path_buf());
    }
    let path = env::var_os("PATH")?;
    env::split_paths(&path).map(|directory| directory.join(name)).find(|file| file.is_file())
}
