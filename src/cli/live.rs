//! `--live`: a run is watched in the Foxglove app while it goes on.

use clap::Args;

use super::Failure;
use super::interrupt::Interrupt;
use super::output::note;
use crate::live::{DEFAULT_ADDRESS, LiveError, Pace, Server};
use crate::log::Feed;
use crate::wording::duration;

/// How long a run takes to watch unless `--live-speed` says otherwise, in s.
const WATCHED_S: f64 = 20.0;

/// The arguments of a run that is watched.
#[derive(Debug, Args)]
pub struct LiveArgs {
    /// Stream the run to the Foxglove app (Open connection, Foxglove WebSocket, ws://ADDRESS:PORT) [default address:
    /// 127.0.0.1:8765]
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = DEFAULT_ADDRESS)]
    live: Option<String>,

    /// Simulated seconds per second [default: the whole run takes 20 s]
    #[arg(long, value_name = "RATIO", requires = "live", value_parser = speed)]
    live_speed: Option<f64>,

    /// Let web pages of this origin watch too, such as http://lab:8080; the Foxglove app and pages of this machine always may
    #[arg(long, value_name = "ORIGIN", requires = "live")]
    live_origin: Vec<String>,

    /// Start when a first client has subscribed
    #[arg(long, requires = "live")]
    live_wait: bool,

    /// Serve the last state until Ctrl-C
    #[arg(long, requires = "live")]
    live_keep: bool,
}

/// Simulated seconds per second, as the command line gives them.
fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(speed) if speed > 0.0 && f64::is_finite(speed) => Ok(speed),
        _ => Err("simulated seconds per second: a positive number, for instance 1e-3".to_string()),
    }
}

/// A server for one run.
pub struct Live {
    server: Server,
    speed: f64,
    wait: bool,
    keep: bool,
    /// Whether the command has been asked to end.
    stop: Box<dyn Fn() -> bool>,
}

impl LiveArgs {
    /// Starts the server, if one is asked for, and says on stderr where it is.
    pub fn start(&self, scene: &str, duration_s: f64, interrupt: &Interrupt) -> Result<Option<Live>, Failure> {
        let Some(address) = &self.live else {
            return Ok(None);
        };
        let server =
            Server::start(address, &format!("phalanx: {scene}"), &self.live_origin).map_err(|error| match error {
                LiveError::Runtime(_) | LiveError::Gate(_) => Failure::incomplete(error),
                _ => Failure::bad_input(error),
            })?;
        let speed = self.live_speed.unwrap_or(duration_s / WATCHED_S);
        let takes = duration(duration_s / speed);
        note(&format!("live: {} shows {} in {takes}", server.url(), duration(duration_s)));
        let (wait, keep, stop) = (self.live_wait, self.live_keep, Box::new(interrupt.watch()));
        Ok(Some(Live { server, speed, wait, keep, stop }))
    }
}

impl Live {
    /// What the log writer hands its messages to.
    pub fn feed(&self, interrupt: &Interrupt) -> Box<dyn Feed> {
        self.server.feed(Pace::new(self.speed), interrupt.watch())
    }

    /// Waits for a first client, if that is asked for. The channels have to be there.
    pub fn begin(&self) {
        if self.wait {
            note("live: waits for a client");
            self.server.wait_for_client(&self.stop);
        }
    }

    /// Ends the server, or keeps it up as long as that is asked for. The log has to be finished.
    pub fn end(self) {
        if self.keep && !(self.stop)() {
            note("live: the run is over; its last state is served until Ctrl-C");
            self.server.keep(&self.stop);
        }
        self.server.finish();
    }
}
