//! Log writer: a sink that writes samples and events as messages of an MCAP file.

use std::collections::BTreeMap;
use std::io::Write;

use foxglove::Encode;
use foxglove::messages::{Log, log::Level};

use super::channels::{EVENTS, LINES, topics, write_subjects};
use super::lines::{GraspState, describe_event};
use super::mcap_file::{ChannelId, McapFile};
use super::messages::{encode, encode_event, event_schema, subject_schema};
use super::metadata::{RunInfo, SUBJECTS_RECORD};
use super::pictures::Pictures;
use phalanx_core::drawing::Drawing;
use phalanx_core::scene::{HandContact, LogSettings, Scene, Side};
use phalanx_core::trace::{Event, FingerContact, RequiredData, Sample, Schema, Sink, SinkError};

/// Streams one run to an MCAP file. It needs memory for one chunk, plus about 400 bytes of index per written chunk. The
/// writer never seeks, so `W` can be a pipe.
///
/// The caller must also write how the run ended, with [`Writer::note`] and the source `run`. Otherwise the log counts
/// as that of a killed run. [`run_to`](super::run_to) does this.
///
/// Dropping a writer also finishes the log but discards errors; [`Writer::finish`] returns them.
pub struct Writer<W: Write> {
    file: McapFile<W>,
    /// Channels of the subjects that the scene has, each with the indices of its numbers in a sample.
    channels: Vec<(ChannelId, Vec<usize>)>,
    events: ChannelId,
    schema: Schema,
    pictures: Option<Pictures>,
    /// Grasp state; `None` unless the scene is a single finger with an object.
    grasp: Option<GraspState>,
    /// Channel of the event lines.
    lines: ChannelId,
    drawing: Drawing,
    scene: Scene,
}

impl<W: Write> Writer<W> {
    /// Starts a log: writes header, metadata, scene text and channels. `name` identifies the log in errors.
    pub fn new(out: W, name: &str, run: &RunInfo<'_>) -> Result<Self, SinkError> {
        let mut file = McapFile::start(out, name, run)?;
        let scene = run.scene.clone();
        let schema = Schema { has_joint_forces: scene.log.joint_forces, ..Schema::from_scene(&scene) };
        let (subjects, topics, mut channels) = (schema.subjects(), topics(&schema), Vec::new());
        let (record, key) = SUBJECTS_RECORD;
        file.record(record, BTreeMap::from([(key.to_string(), write_subjects(&topics))]))?;
        for topic in &topics {
            if let Some(subject) = topic.content.subject().map(|index| &subjects[index]) {
                let indices = subject.independent().map(|(index, _)| index).collect();
                let message_schema = Some(subject_schema(subject));
                let channel = file.register_with_metadata(&topic.name, message_schema, &topic.metadata())?;
                channels.push((channel, indices));
            }
        }
        let events = file.register(EVENTS, Some(event_schema()))?;
        let drawing = Drawing::from_scene(&scene);
        let pictures = Pictures::register(&mut file, &drawing, &drawing.poses_at_start(), scene.log.picture_hz)?;
        let lines = file.register(LINES, Log::get_schema())?;
        let has_grasp = scene.finger_count() == 1 && scene.object().is_some();
        let phalanges = [FingerContact::Proximal, FingerContact::Distal];
        let grasp = has_grasp.then(|| {
            let contact = |phalanx| scene.hand.contact_index(HandContact::Finger(Side::Right, phalanx));
            GraspState::new(phalanges.map(contact))
        });
        Ok(Writer { file, channels, events, schema, pictures, grasp, lines, drawing, scene })
    }

    /// Writes a line to `/events`, for example how the run ended; `source` names its subject.
    pub fn note(&mut self, time_s: f64, severity: Level, source: &str, text: &str) -> Result<(), SinkError> {
        self.file.write_line(self.lines, time_s, severity, source, text)
    }

    /// Writes a metadata record about the whole run.
    pub fn record(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), SinkError> {
        self.file.record(name, metadata)
    }

    /// Finishes the log (last chunk, index, footer), flushes it and returns the underlying output.
    pub fn finish(self) -> Result<W, SinkError> {
        self.file.finish()
    }
}

/// Data of the samples in the log of a run.
pub(crate) fn required_data(log: &LogSettings) -> RequiredData {
    RequiredData { joint_forces: log.joint_forces, ..RequiredData::ALL }
}

impl<W: Write> Sink for Writer<W> {
    fn required_data(&self) -> RequiredData {
        required_data(&self.scene.log)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let (time_s, values) = (sample.time_s, sample.values());
        for (channel, indices) in &self.channels {
            let numbers = indices.iter().map(|&index| values[index]);
            self.file.write(*channel, time_s, |out| encode(time_s, numbers, out))?;
        }
        if let Some(pictures) = &mut self.pictures {
            let poses = || self.drawing.poses(sample);
            let drawn = self.schema.surfaces().map(|contact| sample.contact(contact));
            pictures.sample(&mut self.file, time_s, poses, drawn)?;
        }
        self.file.close_full_chunk()
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    /// Writes an event as a message and as text.
    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let file = &mut self.file;
        let contact = &self.schema.contacts[event.contact];
        let (name, kind) = (&contact.name, contact.kind());
        file.write(self.events, event.time_s, |out| encode_event(event, name, kind, out))?;
        let of_hand = self.scene.hand.contacts().nth(event.contact);
        let display_name = of_hand.map_or_else(|| name.clone(), |of_hand| display_name(of_hand, name));
        let text = describe_event(event, &display_name, contact.is_angular);
        file.write_line(self.lines, event.time_s, Level::Info, name, &text)?;
        if let Some(text) = self.grasp.as_mut().and_then(|grasp| grasp.update(event)) {
            file.write_line(self.lines, event.time_s, Level::Info, "grasp", &text)?;
        }
        file.close_full_chunk()
    }
}

/// Name of a contact of a finger, the palm or the table in the text of event lines.
fn display_name(contact: HandContact, name: &str) -> String {
    match contact {
        HandContact::Finger(_, FingerContact::Limit) => name.replace('_', " ").replace("limit", "joint limit"),
        HandContact::Finger(..) => format!("{} phalanx", name.replace('_', " ")),
        HandContact::Palm | HandContact::Table => format!("object on the {}", contact.name()),
    }
}
