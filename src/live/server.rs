//! Server: channels, their clients and latest messages, and the clock of the run.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use foxglove::websocket::{Capability, ChannelView, Client, ServerListener, Status};
use foxglove::{
    ChannelBuilder, ChannelId, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, SinkId, WebSocketServer,
    WebSocketServerHandle,
};

use super::origin_filter::OriginFilter;
use crate::log::MessageFeed;

/// Default address of the Foxglove app, local only.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:8765";

/// Maximum queued messages per client: enough for several grasps, because an impact produces a burst of messages.
const BACKLOG_MESSAGES: usize = 1 << 16;

/// The app subscribes panel by panel: it is considered ready after this time without a new subscription.
const SUBSCRIPTION_QUIET_TIME: Duration = Duration::from_millis(300);

/// Time for clients to read queued messages after the run.
const DRAIN_TIMEOUT: Duration = Duration::from_secs(2);

/// Time for closing all connections.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(500);

/// Interval between checks for a stop request.
const POLL_INTERVAL: Duration = Duration::from_millis(25);

/// Error while starting a server.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    #[error(
        "cannot serve on `{0}`: that is not ADDRESS:PORT; {DEFAULT_ADDRESS} serves only this machine, 0.0.0.0:8765 all networks, and \
         port 0 selects a free port"
    )]
    Address(String),
    #[error(
        "cannot serve on {address}: another program listens there; stop it or give another port, for example --live {other}"
    )]
    InUse { address: String, other: String },
    #[error("cannot serve on {address}: ports below 1024 are reserved; give a higher one, such as {DEFAULT_ADDRESS}")]
    Forbidden { address: String },
    #[error(
        "cannot serve on {address}: {reason}; give an address of this machine: {DEFAULT_ADDRESS} serves only this machine, \
         0.0.0.0:8765 all networks"
    )]
    Bind { address: String, reason: String },
    #[error("the server did not start: {0}")]
    Start(FoxgloveError),
    #[error("the server did not start: {0}")]
    Listen(io::Error),
}

/// A running server; it serves until [`Server::finish`] or the end of the process.
pub struct Server {
    /// Shared with the feed, which announces the time.
    handle: Arc<WebSocketServerHandle>,
    shared: Arc<SharedState>,
    context: Arc<Context>,
    address: String,
    _origin_filter: OriginFilter,
}

/// State shared by the simulation and the server's threads.
#[derive(Default)]
struct SharedState(Mutex<ServerState>);

/// Channels and their clients.
#[derive(Default)]
struct ServerState {
    channels: Vec<ChannelState>,
    /// When a channel was last subscribed to.
    last_subscribed: Option<Instant>,
    /// Log time of the latest message on any channel.
    latest_ns: u64,
}

struct ChannelState {
    channel: Arc<RawChannel>,
    clients: Vec<SinkId>,
    /// Log time and bytes of the latest message.
    latest: Option<(u64, Vec<u8>)>,
}

impl ServerState {
    fn channel(&mut self, id: ChannelId) -> Option<&mut ChannelState> {
        self.channels.iter_mut().find(|state| state.channel.id() == id)
    }
}

impl SharedState {
    /// Locks the state. A poisoned lock is usable: messages in the state are always complete.
    fn state(&self) -> MutexGuard<'_, ServerState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Subscriptions use the same lock as sending, so a client gets every message from the latest one on exactly once.
impl ServerListener for SharedState {
    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        let mut state = self.state();
        state.last_subscribed = Some(Instant::now());
        let (Some(channel_state), Some(client)) = (state.channel(channel.id()), client.sink_id()) else { return };
        channel_state.clients.push(client);
        if let Some((log_time_ns, message)) = &channel_state.latest {
            channel_state.channel.log_with_meta_to_sink(message, with_log_time(*log_time_ns), Some(client));
        }
    }

    fn on_unsubscribe(&self, client: Client, channel: ChannelView) {
        if let Some(channel_state) = self.state().channel(channel.id()) {
            channel_state.clients.retain(|other| Some(*other) != client.sink_id());
        }
    }
}

fn with_log_time(log_time_ns: u64) -> PartialMetadata {
    PartialMetadata { log_time: Some(log_time_ns) }
}

impl Server {
    /// Listens on `ADDRESS:PORT`; clients see `name`. Web pages of `origins` are allowed in addition to the default
    /// ones.
    ///
    /// # Errors
    /// Returns [`LiveError`] with the address, the reason and a remedy.
    pub fn start(address: &str, name: &str, origins: &[String]) -> Result<Self, LiveError> {
        let parts = address.rsplit_once(':').filter(|(host, _)| !host.is_empty());
        let parts = parts.and_then(|(host, port)| Some((host, port.parse::<u16>().ok()?)));
        let (host, port) = parts.ok_or_else(|| LiveError::Address(address.to_string()))?;
        let listener = TcpListener::bind(address).map_err(|error| bind_error(address, host, port, &error))?;
        let (context, shared) = (Context::new(), Arc::new(SharedState::default()));
        let loopback = random_loopback_address();
        let handle = WebSocketServer::new()
            .name(name)
            .context(&context)
            .bind(loopback.to_string(), 0)
            .capabilities([Capability::Time])
            .message_backlog_size(BACKLOG_MESSAGES)
            .listener(Arc::clone(&shared) as Arc<dyn ServerListener>)
            .start_blocking()
            .map_err(LiveError::Start)?;
        let port = listener.local_addr().map_err(LiveError::Listen)?.port();
        let server_address = SocketAddr::from((loopback, handle.port()));
        let origin_filter =
            OriginFilter::open(listener, server_address, origins.to_vec()).map_err(LiveError::Listen)?;
        Ok(Server {
            handle: Arc::new(handle),
            shared,
            context,
            address: format!("{host}:{port}"),
            _origin_filter: origin_filter,
        })
    }

    /// URL for clients: `ws://ADDRESS:PORT`.
    pub fn url(&self) -> String {
        format!("ws://{}", self.address)
    }

    /// Returns a feed for the log writer that sends every message to the clients when it is due. `stop` ends waiting.
    pub fn feed(&self, pace: RealTimePacer, stop: impl Fn() -> bool + Send + 'static) -> Box<dyn MessageFeed> {
        Box::new(ServerFeed {
            handle: Arc::clone(&self.handle),
            context: Arc::clone(&self.context),
            shared: Arc::clone(&self.shared),
            pace,
            stop: Box::new(stop),
        })
    }

    /// Waits until a client has subscribed to its channels.
    pub fn wait_for_client(&self, stop: impl Fn() -> bool) {
        let is_ready = |subscribed: Instant| subscribed.elapsed() >= SUBSCRIPTION_QUIET_TIME;
        self.serve_last_state(|| stop() || self.shared.state().last_subscribed.is_some_and(is_ready));
    }

    /// Serves the last state and announces its simulated time until `stop` returns true.
    pub fn serve_last_state(&self, stop: impl Fn() -> bool) {
        while !stop() {
            self.announce();
            thread::sleep(POLL_INTERVAL);
        }
    }

    fn announce(&self) {
        let latest_ns = self.shared.state().latest_ns;
        self.handle.broadcast_time(latest_ns);
    }

    /// Notifies clients of the end of the run, waits for them to read queued messages, and stops the server. The log
    /// must be finished first.
    pub fn finish(self) {
        self.announce();
        self.handle.publish_status(Status::info("the run is over"));
        let start = Instant::now();
        while self.handle.client_count() > 0 && start.elapsed() < DRAIN_TIMEOUT {
            thread::sleep(POLL_INTERVAL);
        }
        let Some(handle) = Arc::into_inner(self.handle) else { return };
        // A client that does not read blocks the shutdown; other clients get a limited time to close.
        let (done_sender, done_receiver) = mpsc::channel();
        let shutdown = handle.stop();
        thread::spawn(move || {
            shutdown.wait_blocking();
            let _ = done_sender.send(());
        });
        let _ = done_receiver.recv_timeout(CLOSE_TIMEOUT);
    }
}

fn bind_error(address: &str, host: &str, port: u16, error: &io::Error) -> LiveError {
    let address = address.to_string();
    match error.kind() {
        io::ErrorKind::AddrInUse => {
            LiveError::InUse { address, other: format!("{host}:{}", port.checked_add(1).unwrap_or(0)) }
        }
        io::ErrorKind::PermissionDenied => LiveError::Forbidden { address },
        _ => LiveError::Bind { address, reason: error.to_string() },
    }
}

/// Returns a loopback address that web pages cannot guess: a random one in 127.0.0.0/8 if the system supports these.
fn random_loopback_address() -> Ipv4Addr {
    use std::hash::{BuildHasher, RandomState};
    let [a, b, c, ..] = RandomState::new().hash_one(std::process::id()).to_ne_bytes();
    let address = Ipv4Addr::new(127, a, b, c.clamp(1, 254));
    match TcpListener::bind((address, 0)) {
        Ok(_) => address,
        Err(_) => Ipv4Addr::LOCALHOST,
    }
}

/// Longest sleep, which limits the delay of an interrupt, and the interval of time announcements.
const MAX_SLEEP: Duration = Duration::from_millis(25);

/// Delays a simulation so that it advances at a given multiple of real time.
#[derive(Clone, Copy, Debug)]
pub struct RealTimePacer {
    /// Simulated time per wall-clock time.
    speed: f64,
    /// Wall clock at simulated time 0.
    start: Option<Instant>,
    /// Wall clock at the last announcement.
    announced: Option<Instant>,
}

impl RealTimePacer {
    /// Creates a pacer; its clock starts at the first [`wait`](Self::wait) for a simulated time above 0.
    pub fn new(speed: f64) -> Self {
        RealTimePacer { speed, start: None, announced: None }
    }

    /// Waits until the simulated time is due. Passes the current simulated time, ns, to `announce` every 25 ms of
    /// wall-clock time, also if the simulation is late; returns early if `stop` returns true.
    pub fn wait(&mut self, time_ns: u64, mut announce: impl FnMut(u64), stop: impl Fn() -> bool) {
        if time_ns == 0 {
            return;
        }
        let start = *self.start.get_or_insert_with(Instant::now);
        let due_s = time_ns as f64 * 1e-9 / self.speed;
        loop {
            let elapsed_s = start.elapsed().as_secs_f64();
            if self.announced.is_none_or(|announced| announced.elapsed() >= MAX_SLEEP) {
                announce(time_ns.min((elapsed_s * self.speed * 1e9) as u64));
                self.announced = Some(Instant::now());
            }
            if elapsed_s >= due_s || stop() {
                return;
            }
            thread::sleep(MAX_SLEEP.min(Duration::from_secs_f64(due_s - elapsed_s)));
        }
    }
}

/// Feed of the log writer that sends messages to clients.
struct ServerFeed {
    handle: Arc<WebSocketServerHandle>,
    context: Arc<Context>,
    shared: Arc<SharedState>,
    pace: RealTimePacer,
    stop: Box<dyn Fn() -> bool + Send>,
}

impl MessageFeed for ServerFeed {
    fn add_channel(&mut self, topic: &str, encoding: &str, schema: Option<Schema>) {
        // Lock first: a client may subscribe as soon as the channel is announced.
        let mut state = self.shared.state();
        let channel = ChannelBuilder::new(topic)
            .context(&self.context)
            .message_encoding(encoding)
            .schema(schema)
            .build_raw()
            .expect("an encoding is set");
        state.channels.push(ChannelState { channel, clients: Vec::new(), latest: None });
    }

    fn write_message(&mut self, channel: usize, log_time_ns: u64, message: &[u8]) {
        self.pace.wait(log_time_ns, |now_ns| self.handle.broadcast_time(now_ns), &self.stop);
        let mut state = self.shared.state();
        state.latest_ns = log_time_ns;
        let Some(channel_state) = state.channels.get_mut(channel) else { return };
        for client in &channel_state.clients {
            channel_state.channel.log_with_meta_to_sink(message, with_log_time(log_time_ns), Some(*client));
        }
        let (time_ns, bytes) = channel_state.latest.get_or_insert_default();
        *time_ns = log_time_ns;
        bytes.clear();
        bytes.extend_from_slice(message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paces_simulated_time_at_the_requested_speed() {
        let mut pacer = RealTimePacer::new(0.1);
        let mut reported_times = Vec::new();
        let start = Instant::now();
        pacer.wait(0, |_| panic!("nothing to wait for"), || false);
        pacer.wait(10_000_000, |now_ns| reported_times.push(now_ns), || false);
        assert!(start.elapsed() >= Duration::from_millis(100));
        assert!(
            !reported_times.is_empty()
                && reported_times.is_sorted()
                && reported_times.iter().all(|now_ns| *now_ns <= 10_000_000),
            "{reported_times:?}"
        );
        // A time in the past causes no wait, but is announced if the last announcement is old.
        let mut late_times = Vec::new();
        pacer.wait(1_000_000, |now_ns| late_times.push(now_ns), || false);
        thread::sleep(MAX_SLEEP);
        pacer.wait(2_000_000, |now_ns| late_times.push(now_ns), || false);
        assert!(late_times.ends_with(&[2_000_000]), "{late_times:?}");
        assert!(late_times.len() <= 2, "{late_times:?}");
    }

    #[test]
    fn waiting_stops_on_request() {
        let mut pacer = RealTimePacer::new(1e-6);
        let start = Instant::now();
        pacer.wait(1_000_000_000, |_| {}, || start.elapsed() > Duration::from_millis(50));
        assert!(start.elapsed() < Duration::from_secs(60));
    }
}
