//! `phalanx replay --against`: two logs side by side, with differences and pictures.

use std::path::Path;

use super::interrupt::Interrupt;
use super::output::answer;
use super::own::Form;
use super::replay_args::{ReplayArgs, defects};
use super::replay_page::{Reels, undrawable};
use super::replay_pair::{common, notes};
use super::replay_read::head;
use super::replay_side::Side;
use super::saved::{PAGE, save};
use super::targets::{Kind, reserve};
use super::{Failure, Status};
use crate::log::Reading;
use crate::page::{Note, Page, page};
use crate::plot::{self, Differences};
use crate::report::replay::{AgainstReport, ApartReport, ReplayReport, side_by_side};
use crate::scene::Words;
use crate::scene::words::SceneKind;
use crate::validate::{Angle, compare};
use crate::wording::Reported;

/// Everything that is in the directory in the end.
const FILES: [&str; 5] = ["report.txt", "report.json", PAGE, "overlay.svg", "difference.svg"];

/// Runs the command.
pub(super) fn run(args: &ReplayArgs, other: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let paths = [args.log.as_path(), other];
    let heads = [head(paths[0])?, head(paths[1])?];
    let kinds = heads.each_ref().map(Reading::kind);
    if kinds[0] != kinds[1] {
        let kind = |kind: SceneKind| match kind {
            SceneKind::Finger => "a finger",
            SceneKind::Bodies => "discs",
            SceneKind::Gripper => "a gripper",
        };
        return Err(Failure::bad_input(format!(
            "{} is a log of {}, and {} one of {}: these have nothing in common; give two logs of one kind",
            paths[0].display(),
            kind(kinds[0]),
            paths[1].display(),
            kind(kinds[1])
        )));
    }
    let html = ("--html", args.html.as_deref(), Kind::File(Form::Page));
    let logs = paths.map(Path::to_path_buf);
    let folder = reserve(&[("the log", &logs)], &[html], ("--out", args.out.as_deref(), &FILES))?;
    // A page that is asked for must be possible; one among other files is left out where it is not.
    let mut films = match (&args.html, &args.out) {
        (Some(_), _) => Some([Reels::new(paths[0], &heads[0])?, Reels::new(paths[1], &heads[1])?]),
        (None, Some(_)) => match heads.each_ref().map(|head| Reels::new(paths[0], head)) {
            [Ok(first), Ok(second)] => Some([first, second]),
            _ => None,
        },
        (None, None) => None,
    };
    let mut sides = match &mut films {
        Some([first, second]) => [Side::read(paths[0], interrupt, first)?, Side::read(paths[1], interrupt, second)?],
        None => [Side::read(paths[0], interrupt, &mut ())?, Side::read(paths[1], interrupt, &mut ())?],
    };
    let drawable = [0, 1].map(|k| undrawable(paths[k], &sides[k].reading));
    if let Some(missing) = drawable.into_iter().find_map(Result::err) {
        films = match &args.html {
            Some(_) => return Err(missing),
            None => None,
        };
    }
    let logs = [0, 1].map(|k| sides[k].listeners.report(paths[k].display().to_string(), &sides[k].reading));
    let labels = labels(paths, &logs);
    let mut notes = notes(&sides, &labels);
    let compared_to_s = sides.iter().filter_map(|side| side.reading.last_s).fold(f64::INFINITY, f64::min);
    let compared_to_s = if compared_to_s.is_finite() { compared_to_s } else { 0.0 };
    notes.extend(common(&mut sides, &labels));
    let (apart, pictures) = apart(&sides, &labels, &logs, compared_to_s);
    let (figures, words) = side_by_side(&logs);
    let kind = kinds[0].word();
    let mut report = AgainstReport {
        kind,
        labels,
        logs,
        compared_to_s,
        notes,
        figures,
        words,
        apart,
        directory: None,
        files: None,
        page: None,
    };
    let shown = films.map(|films| both(films, paths, &report)).transpose()?;
    if let (Some(out), Some(folder)) = (&args.out, folder) {
        report.directory = Some(out.display().to_string());
        report.files =
            Some(FILES.into_iter().filter(|file| *file != PAGE || shown.is_some()).map(String::from).collect());
        folder.fill(|out| {
            for (file, picture) in ["overlay.svg", "difference.svg"].iter().zip(&pictures) {
                save(&out.join(file), picture)?;
            }
            if let Some(page) = &shown {
                save(&out.join(PAGE), page)?;
            }
            save(&out.join("report.txt"), &report.report().to_string())?;
            save(&out.join("report.json"), &report.json())
        })?;
    }
    if let (Some(target), Some(page)) = (&args.html, &shown) {
        save(target, page)?;
        report.page = Some(target.display().to_string());
    }
    answer(&report, args.json)?;
    let statuses = [0, 1].map(|k| defects(paths[k], &sides[k].reading, &report.logs[k]));
    Ok(if statuses == [Status::Done; 2] { Status::Done } else { Status::CheckFailed })
}

/// The page of both logs.
fn both(films: [Reels; 2], paths: [&Path; 2], report: &AgainstReport) -> Result<String, Failure> {
    let [(first, description), (second, _)] = films.each_ref().map(Reels::about);
    let title = if first == second { first } else { format!("{first} and {second}") };
    let mut runs = Vec::new();
    for (((film, path), label), log) in films.into_iter().zip(paths).zip(&report.labels).zip(&report.logs) {
        runs.push(film.film(path, label, log.report())?);
    }
    let notes = vec![Note { title: "Side by side".to_string(), text: report.report() }];
    Ok(page(&Page { title, description, runs, notes, pictures: Vec::new() }))
}

/// What the logs are called: by their models, or else their files, as far as that tells them apart.
fn labels(paths: [&Path; 2], logs: &[ReplayReport; 2]) -> [String; 2] {
    let models = logs.each_ref().map(|log| log.model.clone());
    let names = paths.map(|path| path.file_name().map(|name| name.to_string_lossy().into_owned()));
    match (models, names) {
        ([Some(a), Some(b)], _) if a != b && a.len().max(b.len()) < 20 => [a, b],
        (_, [Some(a), Some(b)]) if a != b && a.chars().count().max(b.chars().count()) <= 24 => [a, b],
        _ => ["first".to_string(), "second".to_string()],
    }
}

fn title(logs: &[ReplayReport; 2], labels: &[String; 2]) -> String {
    let scene = |log: &ReplayReport| log.scene.clone().unwrap_or_else(|| "unknown scene".to_string());
    let [first, second] = [scene(&logs[0]), scene(&logs[1])];
    let [a, b] = labels;
    if first == second { format!("{first}: {a} and {b}") } else { format!("{first} ({a}) and {second} ({b})") }
}

/// Differences along the way, and the pictures, of what both logs have. The run with more samples is the one that is
/// interpolated in.
fn apart(
    sides: &[Side<'_>; 2],
    labels: &[String; 2],
    logs: &[ReplayReport; 2],
    until_s: f64,
) -> (Vec<ApartReport>, [String; 2]) {
    let layout = &sides[0].layout;
    let [first, second] = sides.each_ref().map(|side| &side.recording);
    let (run, dense) = if first.samples.len() > second.samples.len() { (second, first) } else { (first, second) };
    let angles = layout.fingers.iter().flat_map(|finger| {
        let of = if finger.is_empty() { String::new() } else { format!("{finger}_") };
        Angle::ALL.map(|angle| format!("{of}{}_rad", angle.name()))
    });
    let quantities = angles.chain(layout.bodies.iter().map(|name| format!("{name}_centre_m")));
    let found = compare(run, dense, until_s);
    // Where a topic is missing there is nothing to compare, and the difference is infinite.
    let finite = quantities.zip(&found.path).filter(|(_, off)| off.max.is_finite());
    let apart = finite.map(|(quantity, off)| ApartReport {
        quantity,
        max: off.max,
        max_at_s: off.max_at_s,
        rms: off.rms,
        end: off.end,
    });
    let apart = if run.samples.is_empty() { Vec::new() } else { apart.collect() };
    let words = labels.each_ref().map(String::as_str);
    let end_s = first.outcome.last.time_s.max(second.outcome.last.time_s);
    let overlay = plot::overlay_of(title(logs, labels), words, layout, [first, second], end_s);
    let [what, label] = match (layout.fingers.is_empty(), layout.bodies.is_empty()) {
        (false, true) => ["joint angles", "|difference|, rad"],
        (false, false) => ["joint angles and centre", "|difference|, rad or m"],
        (true, _) => ["centres", "distance, m"],
    };
    let difference = plot::difference_of(&Differences {
        title: format!("{}: {what} apart", title(logs, labels)),
        label,
        curves: plot::paths_apart(layout, run, dense, until_s),
        touches: plot::touches(layout, first, until_s),
        bound: None,
        until_s,
    });
    (apart, [overlay, difference])
}
