//! Pages of commands, and their display in the user's browser: `phalanx explore`, and `--plot` and `--open` of
//! `phalanx run`.

use std::borrow::Cow;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use clap::Args;

use super::output::{FileKind, NO_DIRECTORY, print_report, reserve, save};
use super::parsers::picture;
use super::set::{SetArgs, source_files};
use super::{Failure, Status, VERSION};
use crate::files::read_at_most;
use crate::format::Report;
use crate::limits::MAX_MODULE_BYTES;
use crate::page::{InitialScene, Page, Playback, explorer_page, is_gzip, render_page, standalone_text};

/// Time in which a program must report that it cannot open a page. A program that still runs afterwards counts as
/// successful.
const FAILURE_TIMEOUT: Duration = Duration::from_millis(1500);

/// Hint for a system without a browser.
const ALTERNATIVE: &str = "write the page with --plot FILE.html and open that file on a computer with a browser";

/// A program that shows a page, and its argument before the path of the page.
struct Browser(PathBuf, Option<&'static str>);

impl Browser {
    /// Returns the program named by `BROWSER`, or the program that the system opens pages with.
    ///
    /// # Errors
    /// Returns an error if no such program is found; the message says why and what to do instead.
    fn find() -> Result<Self, String> {
        let is_set = |name: &str| env::var_os(name).filter(|value| !value.is_empty());
        let not_found = |reason: String| Err(format!("no browser was found to open the page: {reason}"));
        if let Some(named) = is_set("BROWSER") {
            // BROWSER may be a list of programs; xdg-open reads it in the same way.
            let program = env::split_paths(&named).find_map(|name| find_program(&name));
            return program.map_or_else(
                || {
                    let named = named.display().to_string();
                    not_found(format!("BROWSER is {named:?}, which names no program; set it to one, or {ALTERNATIVE}"))
                },
                |program| Ok(Browser(program, None)),
            );
        }
        if cfg!(target_os = "macos") || cfg!(windows) {
            return Ok(Browser(if cfg!(windows) { "explorer" } else { "open" }.into(), None));
        }
        if !["DISPLAY", "WAYLAND_DISPLAY", "WSL_DISTRO_NAME"].iter().any(|name| is_set(name).is_some()) {
            let reason = "this session has no screen (DISPLAY and WAYLAND_DISPLAY are not set)";
            return not_found(format!("{reason}; {ALTERNATIVE}"));
        }
        let openers = [("wslview", None), ("xdg-open", None), ("gio", Some("open")), ("sensible-browser", None)];
        let opener = openers.into_iter().find_map(|(name, arg)| Some(Browser(find_program(Path::new(name))?, arg)));
        let advice = "install xdg-utils, set BROWSER to a program, or";
        opener.map_or_else(|| not_found(format!("no xdg-open is installed; {advice} {ALTERNATIVE}")), Ok)
    }

    /// Opens a written page. Does not wait until it is closed.
    fn open(&self, page: &Path) -> Result<(), Failure> {
        self.start(&page.canonicalize().unwrap_or_else(|_| page.to_path_buf())).map_err(|reason| {
            let (page, program) = (page.display(), self.0.display());
            Failure::incomplete(format!(
                "the page {page} was written, but could not be opened: {program}: {reason}; open it manually"
            ))
        })
    }

    /// Starts the program; returns why it did not start, or ended unsuccessfully within [`FAILURE_TIMEOUT`].
    fn start(&self, page: &Path) -> Result<(), String> {
        let mut command = Command::new(&self.0);
        command.args(self.1).arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().map_err(|error| error.to_string())?;
        let start = Instant::now();
        while start.elapsed() < FAILURE_TIMEOUT {
            match child.try_wait().map_err(|error| error.to_string())? {
                // The Windows explorer exits with status 1 although it shows the page.
                Some(status) if status.success() || cfg!(windows) => return Ok(()),
                Some(status) => return Err(status.to_string()),
                None => sleep(Duration::from_millis(10)),
            }
        }
        Ok(())
    }
}

/// Returns the executable of a program, which is given as a path or as a name to be found in `PATH`.
fn find_program(name: &Path) -> Option<PathBuf> {
    if name.components().count() > 1 {
        return name.is_file().then(|| name.to_path_buf());
    }
    env::split_paths(&env::var_os("PATH")?).map(|directory| directory.join(name)).find(|file| file.is_file())
}

/// Creates a temporary file for a page. The file is not deleted, because the browser may read it after this process has
/// ended.
fn create_temporary_page(flag: &str) -> Result<PathBuf, Failure> {
    let file = tempfile::Builder::new().prefix("phalanx-").suffix(".html").tempfile();
    let path = file.and_then(|file| file.into_temp_path().keep().map_err(|error| error.error));
    path.map_err(|error| {
        Failure::bad_input(format!(
            "cannot create a temporary file: {error}; name a file for the page with {flag} FILE.html"
        ))
    })
}

/// Flags of the page of a run.
#[derive(Debug, Args)]
pub(crate) struct PageArgs {
    /// Write a page for any browser, also offline: an animation, plots and events. If the run has too many samples for a
    /// page, some are omitted and the page states this
    #[arg(long, value_name = "FILE.html", value_parser = picture(&["html"]))]
    pub(super) plot: Option<PathBuf>,

    /// Open the page in the browser; without --plot it is written to the directory for temporary files
    #[arg(long)]
    open: bool,
}

/// Page to write for a run.
pub(super) struct PageOutput {
    target: PathBuf,
    browser: Option<Browser>,
}

impl PageArgs {
    /// Returns an error for `--watch --open` without `--plot`, because each run would write another temporary page.
    pub(super) fn ensure_watchable(&self) -> Result<(), Failure> {
        match (self.open, &self.plot) {
            (true, None) => Err(Failure::bad_input(
                "--watch --open: every run would write a page of another name; name the page with --plot FILE.html, open it once, \
                 and reload it after each run",
            )),
            _ => Ok(()),
        }
    }

    /// Finds the browser and the target before the simulation. Only the `first` of several runs opens its page.
    pub(super) fn prepare(&self, first: bool) -> Result<Option<PageOutput>, Failure> {
        let browser = (self.open && first).then(Browser::find).transpose();
        let browser = browser.map_err(|reason| Failure::bad_input(format!("--open: {reason}")))?;
        let target = match (&self.plot, &browser) {
            (Some(target), _) => target.clone(),
            (None, Some(_)) => create_temporary_page("--plot")?,
            (None, None) => return Ok(None),
        };
        Ok(Some(PageOutput { target, browser }))
    }
}

impl PageOutput {
    /// Writes the page and returns its path.
    pub(super) fn write(&self, name: &str, description: &str, playback: Playback) -> Result<String, Failure> {
        let (title, description) = (name.to_string(), description.to_string());
        save(&self.target, &render_page(&Page { title, description, runs: vec![playback], ..Page::default() }))?;
        Ok(self.target.display().to_string())
    }

    /// Opens the page in the browser if requested.
    pub(super) fn show(&self) -> Result<(), Failure> {
        self.browser.as_ref().map_or(Ok(()), |browser| browser.open(&self.target))
    }
}

/// Name of the compressed module in the directory of the program.
const MODULE_FILE: &str = "phalanx-explorer.wasm.gz";
/// Environment variable with the path of a module to use instead.
const MODULE_VARIABLE: &str = "PHALANX_EXPLORER";
/// Advice for a missing module.
const BUILD_HINT: &str = "run `rustup target add wasm32-unknown-unknown` and install phalanx again: the program then contains the module, as it does in releases. Or, in the source directory, run: tools/explorer.sh --install (it builds the module and installs it next to the program)";
/// The module in the program; see `build.rs`.
#[cfg(has_explorer_module)]
const BUILT_IN_MODULE: Option<&[u8]> = Some(include_bytes!(concat!(env!("OUT_DIR"), "/explorer.wasm.gz")));
#[cfg(not(has_explorer_module))]
const BUILT_IN_MODULE: Option<&[u8]> = None;

/// Open the explorer: a page that simulates the scene again whenever a slider moves.
///
/// The page is one file and needs no network. The analytic model runs in the browser and gives the same digits as
/// `phalanx run`. The page shows every field of the scene, 34 shipped scenes, the results, the
/// grasp at rest, a map over any two variables, and two designs side by side. It exports the scene as TOML, the samples
/// as CSV, images and animations.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx explore\n  phalanx explore my-finger.toml\n  phalanx explore scenes/gripper/design-95.toml --set \
                  object.radius=\"15 mm\" -o page.html\n\nExit status: 0 done; 2 bad input, or the explorer's module is missing; 3 the page could \
                  not be written or opened."
)]
pub(crate) struct ExploreArgs {
    /// Scene file (TOML) to open [default: experiment-95, which is built in]
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Write the page to this file instead of opening it
    #[arg(short, long, value_name = "FILE.html")]
    out: Option<PathBuf>,

    /// Also open the page
    #[arg(long, requires = "out")]
    open: bool,

    /// WebAssembly module of the explorer, compressed with gzip [default: the file named by PHALANX_EXPLORER, else the module
    /// in the program, else phalanx-explorer.wasm.gz in the directory of the program]
    #[arg(long, value_name = "FILE.wasm.gz")]
    module: Option<PathBuf>,
}

pub(super) fn explore(args: &ExploreArgs) -> Result<Status, Failure> {
    let start = load_initial_scene(args)?;
    let (module_files, module) = read_module(args.module.as_deref())?;
    let browser = (args.open || args.out.is_none()).then(Browser::find).transpose();
    let browser = browser.map_err(|message| Failure::bad_input(message.replace("--plot", "-o")))?;
    let target = match &args.out {
        Some(target) => {
            let scene = args.scene.as_deref().map(source_files).unwrap_or_default();
            let page = ("-o", Some(target.as_path()), FileKind::Page);
            reserve(&[("the scene", &scene), ("the module", &module_files)], &[page], NO_DIRECTORY)?;
            target.clone()
        }
        None => create_temporary_page("-o")?,
    };
    save(&target, &explorer_page(&module, &start, VERSION))?;
    print_report(&Report::from(format!("page: {}\n", target.display())))?;
    browser.map_or(Ok(()), |browser| browser.open(&target))?;
    Ok(Status::Done)
}

/// Returns the scene that the page opens.
fn load_initial_scene(args: &ExploreArgs) -> Result<InitialScene, Failure> {
    let set: Vec<_> = args.set.set.iter().filter_map(|layer| split_setting(&layer.text)).collect();
    let Some(path) = &args.scene else {
        let start = InitialScene { set, ..InitialScene::first_preset() };
        args.set.parse_any(&start.text, &start.file)?;
        return Ok(start);
    };
    // The scene must be valid with the fields of --set; the page applies these fields itself.
    args.set.load_any(path)?;
    let scene = SetArgs::default().load_any(path)?;
    let text = fs::read_to_string(path).unwrap_or_default();
    let file = path.file_name().map_or_else(|| "scene.toml".to_string(), |name| name.to_string_lossy().into_owned());
    Ok(InitialScene { file, text: standalone_text(&scene, &text), set })
}

/// Splits a line `path = value`; the value is in the form that `--set` accepts.
fn split_setting(line: &str) -> Option<(String, String)> {
    let (path, value) = line.split_once(" = ")?;
    let parsed: toml::Table = format!("value = {value}").parse().ok()?;
    let value = parsed.get("value").and_then(toml::Value::as_str).unwrap_or(value);
    Some((path.to_string(), value.to_string()))
}

/// Returns the module, and the files that it was read from.
fn read_module(module_arg: Option<&Path>) -> Result<(Vec<PathBuf>, Cow<'static, [u8]>), Failure> {
    let from_environment = || env::var_os(MODULE_VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from);
    let named = module_arg.map(Path::to_path_buf).or_else(from_environment);
    if let (None, Some(module)) = (&named, BUILT_IN_MODULE) {
        return Ok((Vec::new(), module.into()));
    }
    let beside_program = || env::current_exe().ok().map(|program| program.with_file_name(MODULE_FILE));
    let path = named.or_else(beside_program).unwrap_or_else(|| MODULE_FILE.into());
    let unreadable = |reason: String| {
        Failure::bad_input(format!(
            "cannot read {}, the module of the explorer: {reason}\n  = help: {BUILD_HINT}; or name the module with --module FILE or in {MODULE_VARIABLE}",
            path.display()
        ))
    };
    if fs::metadata(&path).is_ok_and(|metadata| !metadata.is_file()) {
        return Err(unreadable("it is not a regular file".to_string()));
    }
    let too_large = || unreadable(format!("it is larger than {} MiB, so it is not the module", MAX_MODULE_BYTES >> 20));
    let bytes =
        read_at_most(&path, MAX_MODULE_BYTES).map_err(|error| unreadable(error.to_string()))?.ok_or_else(too_large)?;
    if !is_gzip(&bytes) {
        return Err(Failure::bad_input(format!(
            "{} is not a module of the explorer: it is not compressed by gzip\n  = help: {BUILD_HINT}",
            path.display()
        )));
    }
    Ok((vec![path], bytes.into()))
}
