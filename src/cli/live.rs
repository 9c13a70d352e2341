//! `--live`: streams a run to the Foxglove app.

use clap::Args;

use super::Failure;
use super::output::print_note;
use super::parsers::number;
use super::progress::Interrupt;
use crate::format::format_duration;
use crate::live::{DEFAULT_ADDRESS, LiveError, RealTimePacer, Server};
use crate::log::MessageFeed;

/// Wall time of a streamed run without `--live-speed`, s.
const DEFAULT_WALL_S: f64 = 20.0;

/// Accepted values in messages.
const SPEED: &str = "simulated seconds per second as a positive number, such as 1e-3";

/// Arguments of a streamed run.
#[derive(Debug, Args)]
pub(crate) struct LiveArgs {
    /// Stream the run to the Foxglove app (Open connection, Foxglove WebSocket, ws://ADDRESS:PORT) [default address:
    /// 127.0.0.1:8765]
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = DEFAULT_ADDRESS)]
    live: Option<String>,

    /// Simulated seconds per second of wall time [default: the whole run takes 20 s]
    #[arg(long, value_name = "RATIO", requires = "live", value_parser = number(|speed| (f64::MIN_POSITIVE..=f64::MAX).contains(speed), SPEED))]
    live_speed: Option<f64>,

    /// Also accept connections from web pages of this origin, such as http://lab:8080; the Foxglove app and pages of
    /// this machine are always accepted
    #[arg(long, value_name = "ORIGIN", requires = "live")]
    live_origin: Vec<String>,

    /// Wait for a client to subscribe before the run starts
    #[arg(long, requires = "live")]
    live_wait: bool,

    /// Serve the last state of the run until Ctrl-C
    #[arg(long, requires = "live")]
    live_keep: bool,
}

/// Server for one run.
pub(crate) struct Live<'a> {
    server: Server,
    args: &'a LiveArgs,
    speed: f64,
    interrupt: &'a Interrupt,
}

impl LiveArgs {
    /// Starts the server if requested and prints its address to stderr.
    pub(super) fn start<'a>(
        &'a self,
        scene: &str,
        duration_s: f64,
        interrupt: &'a Interrupt,
    ) -> Result<Option<Live<'a>>, Failure> {
        let Some(address) = &self.live else { return Ok(None) };
        let server =
            Server::start(address, &format!("phalanx: {scene}"), &self.live_origin).map_err(|error| match error {
                LiveError::Start(_) | LiveError::Listen(_) => Failure::incomplete(error),
                _ => Failure::bad_input(error),
            })?;
        let speed = self.live_speed.unwrap_or(duration_s / DEFAULT_WALL_S);
        let wall_time = format_duration(duration_s / speed);
        print_note(&format!("live: {} shows {} in {wall_time}", server.url(), format_duration(duration_s)));
        Ok(Some(Live { server, args: self, speed, interrupt }))
    }
}

impl Live<'_> {
    /// Returns the feed that receives the messages of the log writer.
    pub(super) fn feed(&self) -> Box<dyn MessageFeed> {
        self.server.feed(RealTimePacer::new(self.speed), self.interrupt.stop_flag())
    }

    /// Waits for a first client if requested. The channels must already exist.
    pub(super) fn wait_for_client(&self) {
        if self.args.live_wait {
            print_note("live: waits for a client");
            self.server.wait_for_client(|| !self.interrupt.keep_running());
        }
    }

    /// Stops the server, after serving the last state until an interrupt if requested. The log must be finished.
    pub(super) fn finish(self) {
        if self.args.live_keep && self.interrupt.keep_running() {
            print_note("live: the run is over; its last state is served until Ctrl-C");
            self.server.serve_last_state(|| !self.interrupt.keep_running());
        }
        self.server.finish();
    }
}
