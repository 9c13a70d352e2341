//! `phalanx explore`: a page that simulates while its sliders move.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::browser::Browser;
use super::output::print_report;
use super::run_page::{create_temporary_page, open_page};
use super::set::{SetArgs, source_files};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve, save};
use super::{Failure, Status, VERSION};
use crate::files::read_at_most;
use crate::format::Report;
use crate::limits::MAX_MODULE_BYTES;
use crate::page::{InitialScene, explorer_page, is_gzip, standalone_text};
use crate::scene::keywords::SceneKind;

/// Name of the compressed module in the directory of the program.
const MODULE_FILE: &str = "phalanx-explorer.wasm.gz";
/// Environment variable with the path of a module to use instead.
const MODULE_VARIABLE: &str = "PHALANX_EXPLORER";
/// Advice for a missing module.
const BUILD_HINT: &str = "in the source directory of phalanx, run: tools/explorer.sh --install (it builds the module and installs it next to the program; releases include it)";

/// Open the explorer: a page that simulates the scene again whenever a slider moves.
///
/// The page is one file and needs no network. The analytic model runs in the browser and gives the same digits as
/// `phalanx run`. The page shows every field of the scene, the shipped scenes, the results, the grasp at rest, a map
/// over any two variables, and two designs side by side. It exports the scene as TOML, the samples as CSV, images and
/// animations.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx explore\n  phalanx explore my-finger.toml\n  phalanx explore scenes/gripper/design-95.toml --set \
                  object.radius=\"15 mm\" -o page.html\n\nExit status: 0 done; 2 bad input, or the explorer's module is missing; 3 the page could \
                  not be written or opened."
)]
pub(crate) struct ExploreArgs {
    /// Finger or gripper scene file (TOML) to open [default: experiment-95, which is built in]
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Write the page to this file instead of opening it
    #[arg(short, long, value_name = "FILE.html")]
    out: Option<PathBuf>,

    /// Also open the page
    #[arg(long, requires = "out")]
    open: bool,

    /// WebAssembly module of the explorer, compressed with gzip [default: the file named by PHALANX_EXPLORER, else
    /// phalanx-explorer.wasm.gz in the directory of the program]
    #[arg(long, value_name = "FILE.wasm.gz")]
    module: Option<PathBuf>,
}

/// Runs `phalanx explore`.
pub fn run(args: &ExploreArgs) -> Result<Status, Failure> {
    let start = load_initial_scene(args)?;
    let (module_path, module) = read_module(args.module.as_deref())?;
    let opens_page = args.open || args.out.is_none();
    let browser = opens_page
        .then(Browser::find)
        .transpose()
        .map_err(|message| Failure::bad_input(message.replace("--html", "-o")))?;
    let target = match &args.out {
        Some(target) => {
            let scene = args.scene.as_deref().map(source_files).unwrap_or_default();
            let page = ("-o", Some(target.as_path()), TargetKind::File(FileKind::Page));
            reserve(&[("the scene", &scene), ("the module", &[module_path])], &[page], NO_DIRECTORY)?;
            target.clone()
        }
        None => create_temporary_page("-o")?,
    };
    save(&target, &explorer_page(&module, &start, VERSION))?;
    print_report(&Report::from(format!("page: {}\n", target.display())))?;
    browser.map_or(Ok(()), |browser| open_page(&browser, &target))?;
    Ok(Status::Done)
}

/// Returns the scene that the page opens.
fn load_initial_scene(args: &ExploreArgs) -> Result<InitialScene, Failure> {
    let set: Vec<(String, String)> =
        args.set.settings().iter().filter_map(|layer| split_setting(&layer.text)).collect();
    let Some(path) = &args.scene else {
        let start = InitialScene { set, ..InitialScene::first_preset() };
        args.set.parse_any(&start.text, &start.file)?;
        return Ok(start);
    };
    // The scene must be valid with the fields of --set; the page applies these fields itself.
    args.set.load_any(path)?;
    let scene = SetArgs::default().load_any(path)?;
    if scene.kind() == SceneKind::Bodies {
        return Err(Failure::bad_input(format!(
            "{} is a scene of discs (kind = \"bodies\"), which the explorer does not support; give a scene of a finger or a gripper, \
             such as scenes/experiment-95.toml, or show the discs with: phalanx run {} --open",
            path.display(),
            path.display()
        )));
    }
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

/// Returns the path and the bytes of the module.
fn read_module(module_arg: Option<&Path>) -> Result<(PathBuf, Vec<u8>), Failure> {
    let from_environment = env::var_os(MODULE_VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from);
    let program_directory_module = env::current_exe().ok().map(|program| program.with_file_name(MODULE_FILE));
    let path = module_arg
        .map(Path::to_path_buf)
        .or(from_environment)
        .or(program_directory_module)
        .unwrap_or_else(|| MODULE_FILE.into());
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
    Ok((path, bytes))
}
