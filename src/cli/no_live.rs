//! `--live` in a build without the feature `live`: the flag exists only to report that the server is missing.

use clap::Args;

use super::Failure;
use super::progress::Interrupt;
use crate::log::MessageFeed;

/// Flag of a build with the server, hidden from the help.
#[derive(Debug, Args)]
pub(crate) struct LiveArgs {
    #[arg(long, hide = true, num_args = 0..=1, default_missing_value = "", value_parser = reject)]
    live: Option<String>,
}

fn reject(_: &str) -> Result<String, String> {
    Err("phalanx was built without the live server; build it with the feature (cargo run --release --features live -- \
         run SCENE --live), or omit --live and view the run afterwards (--log FILE.mcap)"
        .to_string())
}

/// Server for one run; never constructed in this build.
pub(crate) enum Live {}

impl LiveArgs {
    pub(super) fn start(&self, _: &str, _: f64, _: &Interrupt) -> Result<Option<Live>, Failure> {
        Ok(None)
    }
}

impl Live {
    pub(super) fn feed(&self) -> Box<dyn MessageFeed> {
        match *self {}
    }

    pub(super) fn wait_for_client(&self) {
        match *self {}
    }

    pub(super) fn finish(self) {
        match self {}
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct TestCli {
        #[command(flatten)]
        live: LiveArgs,
    }

    #[test]
    fn build_without_server_explains_how_to_build_it() {
        assert!(TestCli::try_parse_from(["run"]).is_ok_and(|cli| cli.live.live.is_none()));
        for args in [&["run", "--live"][..], &["run", "--live", "0.0.0.0:8765"]] {
            let message = TestCli::try_parse_from(args).expect_err("no server").to_string();
            assert!(message.contains("--features live") && message.contains("--log"), "{message}");
        }
    }
}
