//! `phalanx run` of a scene of discs.

use super::interrupt::Interrupt;
use super::output::{print, show};
use super::run::{RunArgs, ended, started};
use super::simulate::{self, Broken, Limits, Simulated};
use super::{Failure, Status, run_page};
use crate::log::LogFile;
use crate::page::Reel;
use crate::report::{self, BodiesReport, RunCheckReport};
use crate::scene::BodiesScene;

/// Runs the command.
pub fn run(args: &RunArgs, mut scene: BodiesScene, first: bool) -> Result<Status, Failure> {
    args.overrides.apply_bodies(args.model(), &mut scene)?;
    let page = args.page.start(&args.scene, args.log.as_deref(), first)?;
    let mut reel = page.as_ref().map(|_| Reel::default());
    let interrupt = Interrupt::listen()?;
    let live = args.live.start(&scene.name, scene.duration_s, &interrupt)?;
    let log = started(args, &scene, live.as_ref(), &interrupt)?;
    let limits = Limits { interrupt: &interrupt, until_s: f64::INFINITY, checking: args.checking() };
    let Simulated { result, found, wall_s, check, log } =
        simulate::bodies(args.model(), &scene, log, &limits, &mut reel);
    let (outcome, error) = match result {
        Ok(outcome) => (Some(outcome), None),
        Err(Broken { error, so_far }) => (so_far, Some(error)),
    };
    let mut report = BodiesReport::new(&scene, args.model(), wall_s, outcome.as_ref(), &found, error);
    report.check = check.map(|check| RunCheckReport::new(&check, false));
    let made = page.as_ref().zip(reel).map(|(page, reel)| {
        let film = reel.film(args.model().name(), &scene, report::bodies_text(&report));
        page.write(&scene.name, &scene.description, film)
    });
    report.page = made.as_ref().and_then(|made| made.as_ref().ok().cloned());
    report.log = args.log.as_ref().map(|path| path.display().to_string());
    let kept = log.and_then(|log| log.map_or(Ok(()), LogFile::keep));
    match args.json {
        true => print(&report::bodies_json(&report)),
        false => show(&report::bodies_text(&report)),
    }?;
    if let Some(live) = live {
        live.end();
    }
    run_page::ended(page.as_ref(), made, ended(args, scene.duration_s, report.error.as_ref(), kept))
}
