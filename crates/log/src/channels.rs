//! Topics of a log and their contents, derived from the schema of the run.

use super::messages::{EVENT, message_name};
use phalanx_core::trace::Schema;
use phalanx_core::trace::schema::SubjectKind;

/// Content of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelContent {
    /// A subject, by its index among [`Schema::subjects`], and the index of its contact if it is one.
    Subject { index: usize, kind: SubjectKind, contact: Option<usize> },
    /// Events of all contacts.
    Events,
    /// Event lines, or the whole run.
    Lines,
}

impl ChannelContent {
    /// Index of the contact that the topic is about.
    pub fn contact(self) -> Option<usize> {
        match self {
            ChannelContent::Subject { contact, .. } => contact,
            _ => None,
        }
    }

    /// Index of the subject of the topic.
    pub(crate) fn subject(self) -> Option<usize> {
        match self {
            ChannelContent::Subject { index, .. } => Some(index),
            _ => None,
        }
    }

    /// Name of the messages.
    pub(crate) fn message_name(self) -> &'static str {
        match self {
            ChannelContent::Subject { kind, .. } => message_name(kind),
            ChannelContent::Events => EVENT,
            ChannelContent::Lines => "foxglove.Log",
        }
    }
}

/// A topic; views for 3-D are derived from the others and not listed.
#[derive(Clone, Debug)]
pub(crate) struct Topic {
    pub name: String,
    pub content: ChannelContent,
    /// Its channels in a log that is read.
    pub channels: Vec<u16>,
}

/// Topics of events, and of their lines.
pub(crate) const EVENTS: &str = "/event";
pub(crate) const LINES: &str = "/events";

/// Returns the topics of all subjects in the order of their numbers, the events, and their lines.
pub(crate) fn topics(schema: &Schema) -> Vec<Topic> {
    let subjects = schema.subjects();
    let first_contact = subjects.len() - 1 - schema.contacts.len();
    let topic = |name, content| Topic { name, content, channels: Vec::new() };
    let of_subjects = subjects.into_iter().enumerate().map(|(index, subject)| {
        let (kind, name) = (subject.kind, &subject.name);
        let is_contact = matches!(kind, SubjectKind::Contact | SubjectKind::Limit);
        let topic_name = match kind {
            SubjectKind::Energy => "/energy".to_string(),
            SubjectKind::Limit => format!("/contact/{name}"),
            _ => format!("/{}/{name}", kind.name()),
        };
        let contact = is_contact.then(|| index - first_contact);
        topic(topic_name, ChannelContent::Subject { index, kind, contact })
    });
    let others = [(EVENTS, ChannelContent::Events), (LINES, ChannelContent::Lines)];
    of_subjects.chain(others.map(|(name, content)| topic(name.to_string(), content))).collect()
}
