//! Channels of a log: their topics and contents, derived from the schema of the run.

use super::messages::message_name;
use phalanx_core::trace::Schema;
use phalanx_core::trace::schema::{Subject, SubjectKind};

/// Content of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelContent {
    /// A subject, by its index among [`Schema::subjects`], and the index of its contact if it is one.
    Subject { index: usize, kind: SubjectKind, contact: Option<usize> },
    /// Events of all contacts.
    Events,
    /// Event lines, or the whole run.
    Lines,
    /// 3-D view, derived from the other channels.
    Picture,
}

impl ChannelContent {
    /// Index of the contact that the channel is about.
    pub fn contact(self) -> Option<usize> {
        match self {
            ChannelContent::Subject { contact, .. } => contact,
            _ => None,
        }
    }

    /// Index of the subject of the channel.
    pub(crate) fn subject(self) -> Option<usize> {
        match self {
            ChannelContent::Subject { index, .. } => Some(index),
            _ => None,
        }
    }

    /// Name of the messages; `None` for messages of Foxglove.
    pub(crate) fn message_name(self) -> Option<&'static str> {
        match self {
            ChannelContent::Subject { kind, .. } => Some(message_name(kind)),
            ChannelContent::Events => Some(super::messages::EVENT),
            ChannelContent::Lines | ChannelContent::Picture => None,
        }
    }
}

/// Topic of events.
pub(crate) const EVENT_TOPIC: &str = "/event";

/// Returns topic and content of the channels of all subjects, in the order of their numbers, with whether the scene has
/// the subject.
pub(crate) fn subject_channels(schema: &Schema) -> Vec<(String, ChannelContent, bool)> {
    let subjects = schema.subjects();
    let first_contact = subjects.len() - 1 - schema.contacts.len();
    let channel = |(index, Subject { kind, name, exists, .. }): (usize, Subject)| {
        let topic = match kind {
            SubjectKind::Energy => "/energy".to_string(),
            SubjectKind::Limit => format!("/contact/{name}"),
            _ => format!("/{}/{name}", kind.name()),
        };
        let is_contact = matches!(kind, SubjectKind::Contact | SubjectKind::Limit);
        let contact = is_contact.then(|| index - first_contact);
        (topic, ChannelContent::Subject { index, kind, contact }, exists)
    };
    subjects.into_iter().enumerate().map(channel).collect()
}
