//! `--live` in a build without the feature of that name: no flags, no server.

use clap::Args;

use super::Failure;
use super::interrupt::Interrupt;
use crate::log::Feed;

/// No arguments.
#[derive(Debug, Args)]
pub struct LiveArgs {}

/// There is none.
pub enum Live {}

impl LiveArgs {
    pub fn start(&self, _: &str, _: f64, _: &Interrupt) -> Result<Option<Live>, Failure> {
        Ok(None)
    }
}

impl Live {
    pub fn feed(&self, _: &Interrupt) -> Box<dyn Feed> {
        match *self {}
    }

    pub fn begin(&self) {
        match *self {}
    }

    pub fn end(self) {
        match self {}
    }
}
