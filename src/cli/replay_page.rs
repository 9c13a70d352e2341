//! `phalanx replay --html`: the page of a log, or of two laid over each other.

use std::path::Path;

use super::interrupt::Interrupt;
use super::own::{Form, writable};
use super::replay::{ReplayArgs, head, losses, refuse_the_log, say};
use super::replay_read::{Listeners, attached, bad_log};
use super::validate_files::save;
use super::{Failure, Status};

use crate::log::{self, LogSink, Names, Reading};
use crate::page::{Film, Page, Reel, page};
use crate::report::{Sheet, replay_text};
use crate::scene::{AnyScene, BodiesScene, Scene};
use crate::trace::bodies::{BodiesEvent, BodiesSample};
use crate::trace::{Event, Sample, Sink, SinkError};

/// A run kept for a page, in bounded memory: one of many samples is thinned out.
pub(super) enum Reels {
    Finger { scene: Box<Scene>, reel: Box<Reel<Sample, Event>> },
    Discs { scene: Box<BodiesScene>, reel: Box<Reel<BodiesSample, BodiesEvent>>, fits: bool },
}

/// Runs the command for one log.
pub(super) fn run(args: &ReplayArgs, target: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let mut reels = Reels::new(path, &head(path)?)?;
    refuse_the_log(path, target, "--html")?;
    writable(target, Form::Page)?;
    let mut listeners = Listeners::new(path, interrupt)?;
    let reading = log::read_any_file(path, &mut Tee(&mut listeners, &mut reels));
    listeners.done();
    let reading = reading.map_err(|error| bad_log(path, &error))?;
    let mut report = listeners.report(path.display().to_string(), &reading);
    let (title, description) = reels.about();
    let film = reels.film(path, report.model.as_deref().unwrap_or("run"), replay_text(&report))?;
    save(target, &page(&Page { title, description, runs: vec![film], ..Page::default() }))?;
    report.page = Some(target.display().to_string());
    say(args, &report)?;
    Ok(losses(path, &reading))
}

impl Reels {
    /// For the scene of a log, without which nothing can be drawn.
    pub fn new(path: &Path, head: &Reading) -> Result<Self, Failure> {
        let refused = |why: String| Failure::bad_input(format!("{}: there is nothing to draw: {why}", path.display()));
        match attached(head) {
            Some(Ok(AnyScene::Finger(scene))) if !head.is_of_discs() => {
                Ok(Reels::Finger { scene, reel: Box::default() })
            }
            Some(Ok(AnyScene::Bodies(scene))) if head.is_of_discs() => {
                Ok(Reels::Discs { scene, reel: Box::default(), fits: true })
            }
            Some(Ok(_)) => Err(refused("the scene in the log is of another kind than its metadata say".to_string())),
            Some(Err(error)) => Err(refused(format!("the scene in the log cannot be read by this phalanx:\n{error}"))),
            None => Err(refused("the part of the log that held its scene is lost".to_string())),
        }
    }

    /// Name and description of the scene.
    pub fn about(&self) -> (String, String) {
        match self {
            Reels::Finger { scene, .. } => (scene.name.clone(), scene.description.clone()),
            Reels::Discs { scene, .. } => (scene.name.clone(), scene.description.clone()),
        }
    }

    pub fn film(self, path: &Path, label: &str, summary: impl Into<Sheet>) -> Result<Film, Failure> {
        match self {
            Reels::Finger { scene, reel } => Ok(reel.film(label, &scene, summary)),
            Reels::Discs { scene, reel, fits: true } => Ok(reel.film(label, &scene, summary)),
            Reels::Discs { .. } => Err(Failure::bad_input(format!(
                "{}: there is nothing to draw: the samples are not of the discs that the scene in the log has",
                path.display()
            ))),
        }
    }
}

impl LogSink for Reels {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        match self {
            Reels::Finger { reel, .. } => reel.sample(sample),
            Reels::Discs { .. } => Ok(()),
        }
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        match self {
            Reels::Finger { reel, .. } => reel.event(event),
            Reels::Discs { .. } => Ok(()),
        }
    }

    fn names(&mut self, names: &Names) -> Result<(), SinkError> {
        if let Reels::Discs { scene, fits, .. } = self {
            let discs = scene.discs.iter().map(|disc| &disc.name).eq(&names.discs);
            let pairs = scene.pairs().into_iter().map(|pair| scene.pair_name(pair)).eq(names.pairs.iter().cloned());
            *fits = discs && pairs;
        }
        Ok(())
    }

    fn discs(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        match self {
            Reels::Discs { reel, fits: true, .. } => reel.sample(sample),
            _ => Ok(()),
        }
    }

    fn discs_event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        match self {
            Reels::Discs { reel, fits: true, .. } => reel.event(event),
            _ => Ok(()),
        }
    }
}

/// Two sinks that take the same log.
pub(super) struct Tee<'a, A, B>(pub &'a mut A, pub &'a mut B);

impl<A: LogSink, B: LogSink> LogSink for Tee<'_, A, B> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.sample(sample)?;
        self.1.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.event(event)?;
        self.1.event(event)
    }

    fn names(&mut self, names: &Names) -> Result<(), SinkError> {
        self.0.names(names)?;
        self.1.names(names)
    }

    fn discs(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.0.discs(sample)?;
        self.1.discs(sample)
    }

    fn discs_event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        self.0.discs_event(event)?;
        self.1.discs_event(event)
    }
}
