//! Logs: one MCAP file per run, with protobuf channels and embedded descriptors. [`run_to`] writes one.
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.
//!
//! Topics and fields of phalanx' own messages are the subjects and quantities of [`Schema`](phalanx_core::trace::Schema).
//! Quantities that follow from others, such as the sliding power of a contact, are computed on reading.
//!
//! | topic | schema | content |
//! |---|---|---|
//! | `/joint/NAME` | `phalanx.Joint` | angle and rate of a joint, and its force if the scene requests it (`[log] joint_forces`): `q11`, for grippers `right_q11`; in mechanisms the name of the joint |
//! | `/actuator/NAME` | `phalanx.Actuator` | torque: `motor`, `right_motor` |
//! | `/tendon/NAME` | `phalanx.Tendon` | length, rate and tension of a tendon |
//! | `/shaft/NAME` | `phalanx.Shaft` | torque of the motor of an actuator, work lost in its gear |
//! | `/motor/NAME` | `phalanx.Motor` | voltage and current of an electric motor |
//! | `/distance/NAME` | `phalanx.Distance` | distance that an actuator controls, and its rate |
//! | `/body/NAME` | `phalanx.Body` | position, angle and rates of the object, a disc, or a body of a mechanism |
//! | `/contact/NAME` | `phalanx.Contact` | gap, slip, forces, contact point; `hammer-anvil` for discs |
//! | `/contact/limit`, `/contact/right_limit` | `phalanx.Limit` | the joint limit; only when the scene has one; in mechanisms `/contact/JOINT_lower`, `/contact/JOINT_upper` |
//! | `/energy` | `phalanx.Energy` | energies, works and their balance; motor work includes the work on driven discs |
//! | `/event` | `phalanx.Event` | touch-downs, lift-offs, reloads; friction that slips or sticks, at most 1000 per contact |
//! | `/events` | `foxglove.Log` | the same events as text, when both phalanges hold the object, and how the run ended |
//! | `/tf_static`, `/tf` | `foxglove.FrameTransforms` | poses of fixed bodies, once, and of moving bodies |
//! | `/scene` | `foxglove.SceneUpdate` | the shapes of all bodies in their frames, once |
//! | `/forces` | `foxglove.SceneUpdate` | contact points and force arrows; only with contacts |
//!
//! **Sampling.** Numeric samples are written on a uniform time grid (`numeric_rate`), within an impact at every
//! integrator step (defined by [`Decimated`](phalanx_core::trace::Decimated)), otherwise at the end of one step per
//! grid interval, and at the maximum penetration and maximum force of every contact, so that a log has the same extremes
//! as its run. Criteria use only the samples off the grid. Long runs of grippers in the
//! analytic model have fewer samples while nothing happens. Pictures have a separate grid (`picture_rate`); within an
//! impact they are also written whenever an arrow has changed by a twentieth of the longest one. If nothing has moved,
//! none is written.
//!
//! **Clock.** All channels share one clock that starts at 0 with the simulation: log time = publish time = time of the
//! message rounded to the nanosecond, never decreasing. Steps within an impact can be shorter than a nanosecond; such
//! messages share a log time but differ in the field `timestamp` (s, unrounded). No wall clock is read, so the same run
//! gives the same bytes.
//!
//! **Metadata.** A metadata record `phalanx` (versions, model, settings) and the exact scene text as an attachment are
//! at the start of the file, so a truncated log still identifies its run. A record `phalanx-check` contains the result
//! of an accuracy check.
//!
//! **Subjects.** A record `phalanx-subjects` lists kind and name of every subject in the order of the samples, and the
//! metadata of a channel contain the kind of its subject (`kind`). Samples and events are therefore read without the
//! scene, and a missing topic is noticed without it. A log without a scene that can be read has lost it
//! ([`LossKind::Scene`]).
//!
//! **Crashes.** A log grows as `NAME.mcap.partial` and is renamed when finished, so an older log is replaced only by a
//! complete one. Every chunk is written at once and flushed, so a killed run leaves a partial log that is readable up
//! to its last chunk. Chunks start small and grow with the log up to 256 KiB.
//!
//! **Cost.** Files are encoded, compressed and written on a separate thread ([`ThreadedWriter`]); `cargo bench --bench
//! log_cost` measures the run time that a log adds.
//!
//! | file | job |
//! |---|---|
//! | `mcap_file`, `writer`, `threaded`, `file` | MCAP file: chunks and clock; contents; writer thread; path on disk |
//! | `simulate` | simulation with all its sinks; run and log in one call |
//! | `channels`, `messages`, `lines` | channels of a scene, their messages, events as text |
//! | `pictures` | frames, shapes and arrows for 3-D views |
//! | `metadata`, `settings` | settings of a run, written and read back |
//! | `reader` | reads intact, truncated and damaged logs into samples and events |
//! | `verify` | comparison of a log with a new simulation |

mod channels;
mod file;
mod lines;
mod mcap_file;
mod messages;
mod metadata;
mod pictures;
mod reader;
mod settings;
mod simulate;
mod threaded;
mod verify;
mod writer;

pub use channels::ChannelContent;
pub use file::{
    CopyError, FileWriter, LogError, LogFile, copy_log, create, ensure_replaceable, is_same_file, partial_name,
    resolve_link,
};
pub use foxglove::messages::log::Level as Severity;
pub use mcap_file::CHUNK_BYTES;
pub use messages::stamp_ns;
pub(crate) use metadata::METADATA_NAME;
pub use metadata::{RunInfo, metadata, scene_text};
pub use reader::{
    LogSink, LogSummary, Loss, LossKind, MAX_RECORD_BYTES, MissingData, ReadError, RunEnd, open_log, read, read_file,
    read_head,
};
pub use settings::{Settings, SettingsError, Solver, settings};
pub use simulate::{
    CheckPolicy, FinishedRun, LoggedRun, LoggedRunError, SimulationOptions, run_into, run_to, simulate,
};
pub use threaded::ThreadedWriter;
pub use verify::{ComparisonOptions, Difference, EntryDifference, LogComparison, QuantityTally, Verification};
pub use writer::Writer;
