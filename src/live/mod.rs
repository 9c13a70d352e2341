//! Live view of a running simulation in the Foxglove app: the messages of its log over Foxglove's WebSocket protocol.
//!
//! The server is a [`MessageFeed`](crate::log::MessageFeed) of the log writer, so clients receive the channels,
//! descriptors and bytes of a log. Unlike a log it follows the wall clock: the simulation waits until a message is due.
//! It never waits for a client: each client has a queue that drops the oldest messages when full.
//!
//! **Late clients.** A new subscriber of a channel first gets its latest message, so shapes and state are available at
//! once, also after the end of the run.
//!
//! **Access.** Programs, the Foxglove app and web pages served by this machine may connect. Other pages, identified by
//! the header `Origin` of the browser, are rejected.
//!
//! **Time.** Messages have the simulated time, from 0; the server announces that time between messages.

mod origin_filter;
mod server;

pub use server::{DEFAULT_ADDRESS, LiveError, RealTimePacer, Server};
