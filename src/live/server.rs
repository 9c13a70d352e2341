//! The server: channels, who watches them, and their latest messages.

use std::collections::HashMap;
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

use super::gate::Gate;
use super::pace::Pace;
use crate::log::Feed;

/// Where the Foxglove app looks first; this machine only.
pub const DEFAULT_ADDRESS: &str = "127.0.0.1:8765";

/// Messages that wait for a client at most: several closings' worth, for an impact comes in one burst.
const BACKLOG_MESSAGES: usize = 1 << 16;

/// The app subscribes panel by panel: it has them all when nothing has been asked for this long.
const SETTLE: Duration = Duration::from_millis(300);

/// How long clients may take to read what is on its way to them when the run is over.
const DRAIN: Duration = Duration::from_secs(2);

/// How long saying goodbye may take.
const FAREWELL: Duration = Duration::from_millis(500);

/// Longest sleep between two looks at whether to stop.
const SLICE: Duration = Duration::from_millis(25);

/// Why a server could not be started.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    #[error(
        "cannot serve on `{0}`: that is not ADDRESS:PORT; {DEFAULT_ADDRESS} serves this machine, 0.0.0.0:8765 whoever can reach \
         it, and port 0 takes a free one"
    )]
    Address(String),
    #[error(
        "cannot serve on {address}: another program listens there; end it, or give another port, for instance --live {other}"
    )]
    InUse { address: String, other: String },
    #[error(
        "cannot serve on {address}: ports below 1024 belong to the system; give a higher one, such as {DEFAULT_ADDRESS}"
    )]
    Forbidden { address: String },
    #[error(
        "cannot serve on {address}: {reason}; this machine must have that address: {DEFAULT_ADDRESS} serves this machine, \
         0.0.0.0:8765 whoever can reach it"
    )]
    Bind { address: String, reason: String },
    #[error("the server did not start: {0}")]
    Runtime(FoxgloveError),
    #[error("the server did not start: {0}")]
    Gate(io::Error),
}

/// A server that has started, and serves until [`Server::finish`] or the end of the process.
pub struct Server {
    /// Shared with the feed, which announces the time.
    handle: Arc<WebSocketServerHandle>,
    watched: Arc<Watched>,
    context: Arc<Context>,
    address: String,
    _gate: Gate,
}

/// What the simulation and the server's own threads share.
#[derive(Default)]
struct Watched(Mutex<Board>);

/// The channels and who watches them.
#[derive(Default)]
struct Board {
    channels: Vec<Watch>,
    index: HashMap<ChannelId, usize>,
    /// When a channel was last subscribed to.
    asked: Option<Instant>,
    /// Log time of the latest message on any channel.
    latest_ns: u64,
}

struct Watch {
    channel: Arc<RawChannel>,
    clients: Vec<SinkId>,
    /// Log time and bytes of the latest message.
    latest: Option<(u64, Vec<u8>)>,
}

impl Watched {
    /// A thread that panicked with the board in its hands has left whole messages on it.
    fn board(&self) -> MutexGuard<'_, Board> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// All of this happens under the lock that messages are sent under, so a client gets every message from the latest one on,
/// each once.
impl ServerListener for Watched {
    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        let mut board = self.board();
        board.asked = Some(Instant::now());
        let Some(watch) = board.index.get(&channel.id()).copied().and_then(|at| board.channels.get_mut(at)) else {
            return;
        };
        let Some(client) = client.sink_id() else {
            return;
        };
        watch.clients.push(client);
        if let Some((log_time_ns, message)) = &watch.latest {
            watch.channel.log_with_meta_to_sink(message, at(*log_time_ns), Some(client));
        }
    }

    fn on_unsubscribe(&self, client: Client, channel: ChannelView) {
        let mut board = self.board();
        if let Some(watch) = board.index.get(&channel.id()).copied().and_then(|at| board.channels.get_mut(at)) {
            watch.clients.retain(|other| Some(*other) != client.sink_id());
        }
    }
}

fn at(log_time_ns: u64) -> PartialMetadata {
    PartialMetadata { log_time: Some(log_time_ns) }
}

impl Server {
    /// Listens on `ADDRESS:PORT`; clients see `name`. Web pages of `origins` may watch besides those that always may.
    ///
    /// # Errors
    /// [`LiveError`] with the address, the reason and the way out.
    pub fn start(address: &str, name: &str, origins: &[String]) -> Result<Self, LiveError> {
        let (host, port) = address.rsplit_once(':').ok_or_else(|| LiveError::Address(address.to_string()))?;
        let port: u16 = port.parse().map_err(|_| LiveError::Address(address.to_string()))?;
        if host.is_empty() {
            return Err(LiveError::Address(address.to_string()));
        }
        let listener = TcpListener::bind(address).map_err(|error| refused(address, host, port, &error))?;
        let (context, watched) = (Context::new(), Arc::new(Watched::default()));
        let hidden = hidden_address();
        let handle = WebSocketServer::new()
            .name(name)
            .context(&context)
            .bind(hidden.to_string(), 0)
            .capabilities([Capability::Time])
            .message_backlog_size(BACKLOG_MESSAGES)
            .listener(Arc::clone(&watched) as Arc<dyn ServerListener>)
            .start_blocking()
            .map_err(LiveError::Runtime)?;
        let port = listener.local_addr().map_err(LiveError::Gate)?.port();
        let inner = SocketAddr::from((hidden, handle.port()));
        let gate = Gate::open(listener, inner, origins.to_vec()).map_err(LiveError::Gate)?;
        Ok(Server { handle: Arc::new(handle), watched, context, address: format!("{host}:{port}"), _gate: gate })
    }

    /// Where clients find it: `ws://ADDRESS:PORT`.
    pub fn url(&self) -> String {
        format!("ws://{}", self.address)
    }

    /// What to hand to the log writer: everything that is logged goes to the clients, when it is due. `stop` ends waiting.
    pub fn feed(&self, pace: Pace, stop: impl Fn() -> bool + Send + 'static) -> Box<dyn Feed> {
        Box::new(ServerFeed {
            handle: Arc::clone(&self.handle),
            context: Arc::clone(&self.context),
            watched: Arc::clone(&self.watched),
            pace,
            stop: Box::new(stop),
        })
    }

    /// Waits until a client has subscribed to what it wants to see.
    pub fn wait_for_client(&self, stop: impl Fn() -> bool) {
        self.serve(|| stop() || self.watched.board().asked.is_some_and(|asked| asked.elapsed() >= SETTLE));
    }

    /// Serves the last state until `stop`.
    pub fn keep(&self, stop: impl Fn() -> bool) {
        self.serve(stop);
    }

    /// Holds the simulated time where it is.
    fn serve(&self, stop: impl Fn() -> bool) {
        while !stop() {
            self.announce();
            thread::sleep(SLICE);
        }
    }

    fn announce(&self) {
        let latest_ns = self.watched.board().latest_ns;
        self.handle.broadcast_time(latest_ns);
    }

    /// Tells clients that the run is over, gives them time to read what is on its way, and ends. The log has to be finished
    /// before.
    pub fn finish(self) {
        self.announce();
        self.handle.publish_status(Status::info("the run is over"));
        let start = Instant::now();
        while self.handle.client_count() > 0 && start.elapsed() < DRAIN {
            thread::sleep(SLICE);
        }
        let Some(handle) = Arc::into_inner(self.handle) else {
            return;
        };
        // A client that does not read holds up even the farewell: others get a moment for theirs.
        let (ended, end) = mpsc::channel();
        let farewell = handle.stop();
        thread::spawn(move || {
            farewell.wait_blocking();
            let _ = ended.send(());
        });
        let _ = end.recv_timeout(FAREWELL);
    }
}

/// Why an address is of no use, in words that help.
fn refused(address: &str, host: &str, port: u16, error: &io::Error) -> LiveError {
    let address = address.to_string();
    match error.kind() {
        io::ErrorKind::AddrInUse => {
            LiveError::InUse { address, other: format!("{host}:{}", port.checked_add(1).unwrap_or(0)) }
        }
        io::ErrorKind::PermissionDenied => LiveError::Forbidden { address },
        _ => LiveError::Bind { address, reason: error.to_string() },
    }
}

/// An address of this machine alone that no web page can guess: any that begins with 127, where the system has them all.
fn hidden_address() -> Ipv4Addr {
    use std::hash::{BuildHasher, RandomState};
    let [a, b, c, ..] = RandomState::new().hash_one(std::process::id()).to_ne_bytes();
    let address = Ipv4Addr::new(127, a, b, c.clamp(1, 254));
    match TcpListener::bind((address, 0)) {
        Ok(_) => address,
        Err(_) => Ipv4Addr::LOCALHOST,
    }
}

/// The server's end in the log writer.
struct ServerFeed {
    handle: Arc<WebSocketServerHandle>,
    context: Arc<Context>,
    watched: Arc<Watched>,
    pace: Pace,
    stop: Box<dyn Fn() -> bool + Send>,
}

impl Feed for ServerFeed {
    fn channel(&mut self, topic: &str, encoding: &str, schema: Option<Schema>) {
        // The board first: a client may subscribe as soon as the channel is announced.
        let mut board = self.watched.board();
        let channel = ChannelBuilder::new(topic)
            .context(&self.context)
            .message_encoding(encoding)
            .schema(schema)
            .build_raw()
            .expect("an encoding has been given");
        let number = board.channels.len();
        board.index.insert(channel.id(), number);
        board.channels.push(Watch { channel, clients: Vec::new(), latest: None });
    }

    fn put(&mut self, channel: usize, log_time_ns: u64, message: &[u8]) {
        self.pace.wait(log_time_ns, |now_ns| self.handle.broadcast_time(now_ns), &self.stop);
        let mut board = self.watched.board();
        board.latest_ns = log_time_ns;
        let Some(watch) = board.channels.get_mut(channel) else {
            return;
        };
        for client in &watch.clients {
            watch.channel.log_with_meta_to_sink(message, at(log_time_ns), Some(*client));
        }
        let (time_ns, bytes) = watch.latest.get_or_insert_default();
        *time_ns = log_time_ns;
        bytes.clear();
        bytes.extend_from_slice(message);
    }
}
