//! `--live` in a build without the feature of that name: no server; the flags are known only to say what is missing.

use std::ffi::OsString;

use clap::Args;

use super::Failure;
use super::interrupt::Interrupt;
use crate::log::Feed;

/// The flags of a build that has the server, not shown in the help.
#[derive(Debug, Args)]
pub struct LiveArgs {
    #[arg(long, hide = true, num_args = 0..=1)]
    live: Option<Option<OsString>>,

    #[arg(long, hide = true)]
    live_speed: Option<OsString>,

    #[arg(long, hide = true)]
    live_origin: Option<OsString>,

    #[arg(long, hide = true)]
    live_wait: bool,

    #[arg(long, hide = true)]
    live_keep: bool,
}

/// There is none.
pub enum Live {}

impl LiveArgs {
    pub fn start(&self, _: &str, _: f64, _: &Interrupt) -> Result<Option<Live>, Failure> {
        self.refuse()?;
        Ok(None)
    }

    fn refuse(&self) -> Result<(), Failure> {
        match self.live.is_some()
            || self.live_origin.is_some()
            || self.live_speed.is_some()
            || self.live_wait
            || self.live_keep
        {
            false => Ok(()),
            true => Err(Failure::bad_input(
                "this phalanx was built without the live server; build it with the feature (cargo run --release --features \
                 live -- run SCENE --live), or leave --live out and look at the run afterwards (--log FILE.mcap)",
            )),
        }
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

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Alone {
        #[command(flatten)]
        live: LiveArgs,
    }

    #[test]
    fn a_build_without_the_server_says_how_to_get_one() {
        let refusal = |args: &[&str]| Alone::try_parse_from([&["run"], args].concat()).expect("known").live.refuse();
        assert!(refusal(&[]).is_ok());
        for args in [&["--live"][..], &["--live", "0.0.0.0:8765"], &["--live-speed", "1e-3"], &["--live-keep"]] {
            let message = refusal(args).expect_err("there is no server").message;
            assert!(message.contains("--features live") && message.contains("--log"), "{message}");
        }
    }
}
