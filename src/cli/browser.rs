//! Opening a page in the browser of whoever asked for it.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How long a program may take to say that it cannot open a page. One that is still there then shows it.
const PATIENCE: Duration = Duration::from_millis(1500);

/// A program that shows a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Browser {
    program: PathBuf,
    /// What goes before the name of the page.
    arguments: Vec<OsString>,
}

/// The way out where there is no browser.
const INSTEAD: &str = "write the page with --html FILE.html, and open that file where there is one";

impl Browser {
    /// The program named by `BROWSER`, or whatever the system opens pages with.
    ///
    /// # Errors
    /// Why there is none, and what to do instead.
    pub fn find() -> Result<Self, String> {
        if let Some(named) = env::var_os("BROWSER").filter(|named| !named.is_empty()) {
            // A list of programs, as xdg-open and others read it.
            let found = env::split_paths(&named).find_map(|name| program(&name));
            return found.map(|program| Browser { program, arguments: Vec::new() }).ok_or_else(|| {
                format!(
                    "there is no browser to open a page in: BROWSER is {:?}, which names no program; set it to one, or {INSTEAD}",
                    named.display().to_string()
                )
            });
        }
        if cfg!(target_os = "macos") {
            return Ok(Browser { program: "open".into(), arguments: Vec::new() });
        }
        if cfg!(windows) {
            return Ok(Browser { program: "explorer".into(), arguments: Vec::new() });
        }
        let shown = ["DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME"];
        if shown.iter().all(|name| env::var_os(name).is_none_or(|value| value.is_empty())) {
            return Err(format!(
                "there is no browser to open a page in: this session has no screen (DISPLAY and WAYLAND_DISPLAY are not set); \
                 {INSTEAD}"
            ));
        }
        let openers = [("wslview", None), ("xdg-open", None), ("gio", Some("open")), ("sensible-browser", None)];
        let found = openers.into_iter().find_map(|(name, argument)| Some((program(Path::new(name))?, argument)));
        let (program, argument) = found.ok_or_else(|| {
            format!(
                "there is no browser to open a page in: no xdg-open here; install xdg-utils, set BROWSER to a program, or {INSTEAD}"
            )
        })?;
        Ok(Browser { program, arguments: argument.map(OsString::from).into_iter().collect() })
    }

    /// Opens a page, and does not wait until it is closed.
    ///
    /// # Errors
    /// Why it could not be opened.
    pub fn open(&self, page: &Path) -> Result<(), String> {
        let mut child = Command::new(&self.program)
            .args(&self.arguments)
            .arg(page.canonicalize().unwrap_or_else(|_| page.to_path_buf()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("{}: {error}", self.program.display()))?;
        failure(&mut child).map_or(Ok(()), |why| Err(format!("{}: {why}", self.program.display())))
    }
}

/// Why a program ended without success within our patience.
fn failure(child: &mut Child) -> Option<String> {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        match child.try_wait() {
            // Windows' explorer shows the page and ends with 1.
            Ok(Some(status)) if status.success() || cfg!(windows) => return None,
            Ok(Some(status)) => return Some(status.to_string()),
            Ok(None) => sleep(Duration::from_millis(10)),
            Err(error) => return Some(error.to_string()),
        }
    }
    None
}

/// The file of a program: a path as it is, or a name along `PATH`.
fn program(name: &Path) -> Option<PathBuf> {
    if name.components().count() > 1 {
        return name.is_file().then(|| name.to_path_buf());
    }
    let path = env::var_os("PATH")?;
    env::split_paths(&path).map(|directory| directory.join(name)).find(|file| file.is_file())
}
