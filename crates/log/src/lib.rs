//! Logs: one MCAP file a run, every channel in protobuf with its descriptor embedded. [`run_to`] writes one.
//!
//! Schemas of our own messages are called as here under `phalanx.` (`phalanx.State`).
//!
//! | topic | schema | what |
//! |---|---|---|
//! | `/state` | [`State`] | joint angles, rates, motor torque |
//! | `/contact/proximal`, `/contact/distal` | [`Contact`] | gap, slip, forces, contact point; only with an object |
//! | `/limit` | [`Limit`] | the joint limit; only when the scene has one |
//! | `/energy` | [`Energy`] | energies, works and their balance |
//! | `/impact/proximal`, `/impact/distal` | [`Impact`] | touch-downs, lift-offs and reloads as figures |
//! | `/impact/limit` | [`LimitImpact`] | the same for the joint limit |
//! | `/slip/proximal`, `/slip/distal` | [`Slip`] | friction begins to slip, or sticks again; only where it holds, and up to 1000 of them |
//! | `/events` | `foxglove.Log` | the same events as text, when both phalanges hold the object, and how the run ended |
//! | `/tf_static`, `/tf` | `foxglove.FrameTransforms` | where bodies are that stay, once, and those that move |
//! | `/scene` | `foxglove.SceneUpdate` | the shapes of all bodies in their frames, once |
//! | `/forces` | `foxglove.SceneUpdate` | contact points and force arrows; only with an object |
//!
//! The log of a scene of discs has other names, and the same messages where they fit:
//!
//! | topic | schema | what |
//! |---|---|---|
//! | `/disc/NAME` | [`Disc`] | place, angle and rates of a disc |
//! | `/contact/PAIR` | [`Contact`] | gap, slip, forces; PAIR is `hammer-anvil` or `hammer-plane` |
//! | `/energy` | [`Energy`] | energies, works and their balance; the motor's work is that on driven discs |
//! | `/impact/PAIR` | [`Impact`] | touch-downs, lift-offs and reloads as figures |
//! | `/slip/PAIR` | [`Slip`] | friction begins to slip, or sticks again; only where it holds, and up to 1000 of them |
//! | `/events` | `foxglove.Log` | the same events as text, and how the run ended |
//! | `/tf_static`, `/tf`, `/scene`, `/forces` | | pictures, as above |
//!
//! **How much.** Numbers come on an even grid (`numeric_rate`) and, within an impact, at every step of the integrator
//! ([`Thin`](phalanx_core::trace::Thin) says what an impact is); besides, at the deepest point and the largest force of every
//! contact, so that a log has the same extremes as its run. Long runs of grippers in the analytic model have fewer where nothing happens. Pictures come on a grid of their own (`picture_rate`), and
//! within an impact whenever an arrow has changed by a twentieth of the longest one; where nothing has moved there is none.
//!
//! **Clock.** One clock, from 0 at the start of the simulation: log time = publish time = the message's stamp rounded to
//! the nanosecond, and never going back. Steps within an impact can be shorter than a nanosecond; such neighbours share
//! a log time, and the `timestamp` field (s, unrounded) still tells them apart. No wall clock is read, so the same run
//! gives the same bytes.
//!
//! **Beside the channels.** A metadata record `phalanx` (versions, model, settings), one `phalanx-check` (what a check of the run found) and the exact scene text as an
//! attachment come first in the file, so a log cut short anywhere still says what it was a log of.
//!
//! **Crashes.** A log grows as `NAME.mcap.partial` and takes its name when it is finished, so an older log is replaced
//! only by a whole one. Every chunk is written whole and flushed, so a killed run leaves a partial log that reads up to
//! its last chunk. Chunks begin small and grow with the log, to 256 KiB.
//!
//! **Cost.** Files are encoded, compressed and written on a thread of their own ([`Beside`]); `cargo bench --bench log_cost`
//! measures what a log adds to a run.
//!
//! | file | job |
//! |---|---|
//! | `core`, `writer`, `beside`, `file` | the MCAP file: chunks and clock; what goes in; the thread; its place on the disk |
//! | `run`, `listeners` | one call that runs and logs; everything that listens to a run |
//! | `channels`, `messages`, `schema`, `lines` | the channels of a scene, their messages, what those are called; events as text |
//! | `pictures` | frames, shapes and arrows for 3-D views |
//! | `metadata`, `settings` | the settings of a run, written and read back |
//! | `reader` | a log back to samples and events, whatever has happened to it |
//! | `recovered`, `verify` | the good part of a damaged log; two logs message by message |

mod beside;
mod channels;
mod core;
mod file;
mod lines;
mod listeners;
mod messages;
mod metadata;
mod pictures;
mod reader;
mod recovered;
mod run;
mod schema;
mod settings;
mod verify;
mod writer;

pub use beside::Beside;
pub use core::{CHUNK_BYTES, Core, Feed, Severity};
pub use file::{
    FileWriter, LogError, LogFile, behind_link, create, create_with_feed, is_at, partial_name, refuse_other_files,
};
pub use listeners::{Ran, simulate};
pub use messages::{Contact, Disc, Energy, Impact, Limit, LimitImpact, Slip, State, stamp_ns};
pub use metadata::RECOVERED_NAME;
pub use metadata::{
    ATTACHMENT_MEDIA_TYPE, CHECK_NAME, METADATA_NAME, RunInfo, check_entries, construction_name, law_name, metadata,
    method_name, preset_name, scene_text, stepping_name,
};
pub use reader::{
    AttachmentRecord, Behind, ChannelRecord, Concerns, Ended, LARGEST_RECORD, LogSink, Loss, MessageRecord, Missing,
    ReadError, Reading, Record, SchemaRecord, open_log, read, read_any, read_any_file, read_file, read_head,
    read_pieces,
};
pub use recovered::{Gap, Recovery, gaps, recover};
pub use run::{LoggedRun, LoggedRunError, run_into, run_to};
pub use settings::{Settings, SettingsError, Solver, settings};
pub use verify::{Difference, Expected, FieldTally, Leaf, Lockstep, Verification};
pub use writer::Writer;
