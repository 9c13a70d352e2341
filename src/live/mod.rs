//! A running simulation, watched in the Foxglove app: the messages of its log over Foxglove's WebSocket protocol.
//!
//! The server is a [`Feed`](crate::log::Feed) of the log writer, so clients see the channels, the descriptors and the bytes of
//! a log. Unlike a log it keeps pace with the wall clock: the simulation waits until a message is due. It never waits for a
//! client: each has a queue, from which the oldest messages go when it is full.
//!
//! **Late clients.** Who subscribes to a channel gets its latest message first, whatever its age, so the shapes and the state
//! are there from the beginning, and after the end of the run.
//!
//! **Who may watch.** Programs, the Foxglove app, and web pages that this machine serves itself. Other pages, which a browser
//! names in the header `Origin`, are refused.
//!
//! **Time.** Messages carry the time of the simulation, from 0, and the server announces that time between them.

mod gate;
mod pace;
mod server;

pub use pace::Pace;
pub use server::{DEFAULT_ADDRESS, LiveError, Server};
