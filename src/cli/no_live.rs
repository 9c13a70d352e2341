//! `--live` in a build without the feature `live`: the flags exist only to report that the server is missing.

use std::ffi::OsString;

use clap::Args;

use super::Failure;
use super::interrupt::Interrupt;
use crate::log::MessageFeed;

/// Flags of a build with the server, hidden from the help.
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

/// Server for one run; never constructed in this build.
pub enum Live {}

impl LiveArgs {
    pub fn start(&self, _: &str, _: f64, _: &Interrupt) -> Result<Option<Live>, Failure> {
        self.reject_flags()?;
        Ok(None)
    }

    fn reject_flags(&self) -> Result<(), Failure> {
        match self.live.is_some()
            || self.live_origin.is_some()
            || self.live_speed.is_some()
            || self.live_wait
            || self.live_keep
        {
            false => Ok(()),
            true => Err(Failure::bad_input(
                "phalanx was built without the live server; build it with the feature (cargo run --release --features \
                 live -- run SCENE --live), or omit --live and view the run afterwards (--log FILE.mcap)",
            )),
        }
    }
}

impl Live {
    pub fn feed(&self, _: &Interrupt) -> Box<dyn MessageFeed> {
        match *self {}
    }

    pub fn wait_for_client(&self) {
        match *self {}
    }

    pub fn finish(self) {
        match self {}
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct TestCli {
        #[command(flatten)]
        live: LiveArgs,
    }

    #[test]
    fn build_without_server_explains_how_to_build_it() {
        let check = |args: &[&str]| {
            TestCli::try_parse_from([&["run"], args].concat()).expect("known flags").live.reject_flags()
        };
        assert!(check(&[]).is_ok());
        for args in [&["--live"][..], &["--live", "0.0.0.0:8765"], &["--live-speed", "1e-3"], &["--live-keep"]] {
            let message = check(args).expect_err("no server").message;
            assert!(message.contains("--features live") && message.contains("--log"), "{message}");
        }
    }
}
