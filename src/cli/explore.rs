//! `phalanx explore`: a page that simulates while its sliders move.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::browser::Browser;
use super::output::show;
use super::own::Form;
use super::run_page::{opened, temporary};
use super::saved::save;
use super::set::{SetArgs, files};
use super::targets::{Kind, NONE, reserve};
use super::{Failure, Status, VERSION};
use crate::files::read_at_most;
use crate::limits::LARGEST_MODULE_BYTES;
use crate::page::{Start, explorer_page, is_packed, whole};
use crate::scene::words::SceneKind;
use crate::wording::Report;

/// What a packed module is called beside the program.
const MODULE: &str = "phalanx-explorer.wasm.gz";
/// Names another.
const VARIABLE: &str = "PHALANX_EXPLORER";
const HOW: &str = "in the sources of phalanx, run: tools/explorer.sh --install (it builds the module and puts it beside the installed program; a release has it there)";

/// Open the explorer: a page that simulates the scene anew while its sliders move.
///
/// One file that needs no network: the analytic model runs in the browser, with the digits of `phalanx run`. It has every field of the
/// scene, the shipped scenes, the figures and the grasp at rest, a map over any two variables, two designs side by side; and it gives
/// the scene as TOML, the samples as CSV, pictures and moving pictures.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx explore\n  phalanx explore my-finger.toml\n  phalanx explore scenes/gripper/design-95.toml --set \
                  object.radius=\"15 mm\" -o page.html\n\nExit status: 0 done; 2 bad input, or the explorer is not there; 3 the page could \
                  not be written or opened."
)]
pub struct ExploreArgs {
    /// Scene of a finger or a gripper (TOML) that it opens with [default: experiment-95, which comes with it]
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Write the page there instead of opening it
    #[arg(short, long, value_name = "FILE.html")]
    out: Option<PathBuf>,

    /// Open it too
    #[arg(long, requires = "out")]
    open: bool,

    /// The explorer's module, packed by gzip [default: phalanx-explorer.wasm.gz beside the program, or what PHALANX_EXPLORER names]
    #[arg(long, value_name = "FILE.wasm.gz")]
    module: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ExploreArgs) -> Result<Status, Failure> {
    let start = start(args)?;
    let (file, module) = module(args.module.as_deref())?;
    let wanted = args.open || args.out.is_none();
    let browser =
        wanted.then(Browser::find).transpose().map_err(|why| Failure::bad_input(why.replace("--html", "-o")))?;
    let target = match &args.out {
        Some(target) => {
            let scene = args.scene.as_deref().map(files).unwrap_or_default();
            let page = ("-o", Some(target.as_path()), Kind::File(Form::Page));
            reserve(&[("the scene", &scene), ("the module", &[file])], &[page], NONE)?;
            target.clone()
        }
        None => temporary("-o")?,
    };
    save(&target, &explorer_page(&module, &start, VERSION))?;
    show(&Report::from(format!("page: {}\n", target.display())))?;
    browser.map_or(Ok(()), |browser| opened(&browser, &target))?;
    Ok(Status::Done)
}

/// The scene that the page opens with.
fn start(args: &ExploreArgs) -> Result<Start, Failure> {
    let set: Vec<(String, String)> = args.set.settings().iter().filter_map(|layer| field(&layer.text)).collect();
    let Some(path) = &args.scene else {
        let start = Start { set, ..Start::shipped() };
        args.set.parse_any(&start.text, &start.file)?;
        return Ok(start);
    };
    // With what is set, it must be a scene; the page sets that itself.
    args.set.load_any(path)?;
    let scene = SetArgs::default().load_any(path)?;
    if scene.kind() == SceneKind::Bodies {
        return Err(Failure::bad_input(format!(
            "{} is a scene of discs (kind = \"bodies\"), which the explorer leaves to the program: phalanx run {} --open shows it; \
             give a scene of a finger or a gripper, like scenes/experiment-95.toml",
            path.display(),
            path.display()
        )));
    }
    let own = fs::read_to_string(path).unwrap_or_default();
    let file = path.file_name().map_or_else(|| "scene.toml".to_string(), |name| name.to_string_lossy().into_owned());
    Ok(Start { file, text: whole(&scene, &own), set })
}

/// `path = value`, the value as `--set` takes it.
fn field(line: &str) -> Option<(String, String)> {
    let (path, value) = line.split_once(" = ")?;
    let plain: toml::Table = format!("value = {value}").parse().ok()?;
    let value = plain.get("value").and_then(toml::Value::as_str).unwrap_or(value);
    Some((path.to_string(), value.to_string()))
}

/// The module's bytes.
fn module(given: Option<&Path>) -> Result<(PathBuf, Vec<u8>), Failure> {
    let named = env::var_os(VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from);
    let beside = env::current_exe().ok().map(|program| program.with_file_name(MODULE));
    let path = given.map(Path::to_path_buf).or(named).or(beside).unwrap_or_else(|| MODULE.into());
    let refused = |why: String| {
        Failure::bad_input(format!(
            "the explorer needs its module {}, which cannot be read: {why}\n  = help: {HOW}; or name one with --module FILE, or in {VARIABLE}",
            path.display()
        ))
    };
    if fs::metadata(&path).is_ok_and(|found| !found.is_file()) {
        return Err(refused("that is not a regular file".to_string()));
    }
    let too_large = || refused(format!("it is larger than {} MiB, and no module is", LARGEST_MODULE_BYTES >> 20));
    let bytes =
        read_at_most(&path, LARGEST_MODULE_BYTES).map_err(|error| refused(error.to_string()))?.ok_or_else(too_large)?;
    if !is_packed(&bytes) {
        return Err(Failure::bad_input(format!(
            "{} is no packed module of the explorer: it does not begin as what gzip writes\n  = help: {HOW}",
            path.display()
        )));
    }
    Ok((path, bytes))
}
