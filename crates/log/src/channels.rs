//! Topics of a log and their contents, derived from the schema of the run; and the subjects that a log describes.

use std::collections::BTreeMap;

use super::messages::{EVENT, message_name};
use phalanx_core::trace::Schema;
use phalanx_core::trace::schema::SubjectKind;

/// Kinds of subjects in a log: key, kind, and whether it is a contact of a joint with its limit. The limit of a prismatic
/// joint has the messages of a contact.
const KINDS: [(&str, SubjectKind, bool); 14] = [
    ("joint", SubjectKind::Joint, false),
    ("slider", SubjectKind::Slider, false),
    ("actuator", SubjectKind::Actuator, false),
    ("linear_actuator", SubjectKind::LinearActuator, false),
    ("tendon", SubjectKind::Tendon, false),
    ("cable", SubjectKind::CableElement, false),
    ("shaft", SubjectKind::Shaft, false),
    ("motor", SubjectKind::Motor, false),
    ("distance", SubjectKind::Distance, false),
    ("body", SubjectKind::Body, false),
    ("contact", SubjectKind::Contact, false),
    ("limit", SubjectKind::Limit, true),
    ("linear_limit", SubjectKind::Contact, true),
    ("energy", SubjectKind::Energy, false),
];

/// Key of the kind of a subject in the metadata of its channel.
const KIND_KEY: &str = "kind";

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
    /// Index of the contact to which the topic belongs; `None` for other topics.
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
    /// Kind and name of its subject.
    subject: Option<(&'static str, String)>,
    /// Channels of this topic, for a log that is read.
    pub channels: Vec<u16>,
}

impl Topic {
    /// Metadata of the channel.
    pub(crate) fn metadata(&self) -> BTreeMap<String, String> {
        self.subject.iter().map(|(kind, _)| (KIND_KEY.to_string(), kind.to_string())).collect()
    }
}

/// Whether the messages are those of phalanx.
pub(crate) fn is_own_message(name: &str) -> bool {
    name == EVENT || KINDS.iter().any(|(_, kind, _)| message_name(*kind) == name)
}

/// Topics of events, and of their lines.
pub(crate) const EVENTS: &str = "/event";
pub(crate) const LINES: &str = "/events";

/// Returns the topics of all subjects in the order of their numbers, the events, and their lines.
pub(crate) fn topics(schema: &Schema) -> Vec<Topic> {
    let subjects = schema.subjects();
    let first_contact = subjects.len() - 1 - schema.contacts.len();
    let of_subjects = subjects.into_iter().enumerate().map(|(index, subject)| {
        let (kind, name) = (subject.kind, subject.name);
        let is_contact = matches!(kind, SubjectKind::Contact | SubjectKind::Limit);
        let contact = is_contact.then(|| index - first_contact);
        let is_limit = contact.is_some_and(|contact| contact >= schema.surfaces().end);
        let found = KINDS.iter().find(|(_, known, limit)| (*known, *limit) == (kind, is_limit));
        let key = found.map_or(kind.name(), |(key, ..)| key);
        let content = ChannelContent::Subject { index, kind, contact };
        Topic { name: topic_name(kind, &name), content, subject: Some((key, name)), channels: Vec::new() }
    });
    let others = [(EVENTS, ChannelContent::Events), (LINES, ChannelContent::Lines)];
    let other =
        |(name, content): (&str, _)| Topic { name: name.to_string(), content, subject: None, channels: Vec::new() };
    of_subjects.chain(others.map(other)).collect()
}

/// Name of the topic of a subject.
fn topic_name(kind: SubjectKind, name: &str) -> String {
    match kind {
        SubjectKind::Energy => "/energy".to_string(),
        SubjectKind::Limit => format!("/contact/{name}"),
        _ => format!("/{}/{name}", kind.name()),
    }
}

/// A subject that a log describes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DescribedSubject {
    pub kind: SubjectKind,
    /// Whether the contact is that of a joint with its limit; `None` if the log does not tell.
    pub is_limit: Option<bool>,
    pub name: String,
}

/// Writes the kinds and names of all subjects as one text.
pub(crate) fn write_subjects(topics: &[Topic]) -> String {
    let subjects = topics.iter().filter_map(|topic| topic.subject.as_ref());
    subjects.map(|(kind, name)| format!("{kind} {name}")).collect::<Vec<_>>().join(", ")
}

/// Reads the text of [`write_subjects`]. Invalid entries are ignored.
pub(crate) fn read_subjects(text: &str) -> impl Iterator<Item = DescribedSubject> {
    text.split(", ").filter_map(|entry| {
        let (key, name) = entry.split_once(' ').filter(|(_, name)| is_subject_name(name))?;
        let (_, kind, is_limit) = *KINDS.iter().find(|(known, ..)| *known == key)?;
        Some(DescribedSubject { kind, is_limit: Some(is_limit), name: name.to_string() })
    })
}

/// Returns the subject of a channel, which follows from its topic, the name of its messages and its metadata; `None` for
/// other channels.
pub(crate) fn subject_of_channel(channel: &mcap::Channel) -> Option<DescribedSubject> {
    let message = &channel.schema.as_ref()?.name;
    let (_, kind, _) = *KINDS.iter().find(|(_, kind, _)| message_name(*kind) == message)?;
    let name = channel.topic.rsplit_once('/')?.1;
    // The name of a contact can contain a slash.
    let name = channel.topic.strip_prefix("/contact/").unwrap_or(name);
    let described = channel.metadata.get(KIND_KEY).and_then(|key| KINDS.iter().find(|(known, ..)| known == key));
    let is_limit = match kind {
        SubjectKind::Contact => described.map(|(.., is_limit)| *is_limit),
        _ => Some(kind == SubjectKind::Limit),
    };
    let is_subject = topic_name(kind, name) == channel.topic && is_subject_name(name);
    is_subject.then(|| DescribedSubject { kind, is_limit, name: name.to_string() })
}

/// Whether a text can be the name of a subject of phalanx: it becomes the name of a column.
fn is_subject_name(name: &str) -> bool {
    let is_valid = |letter: char| letter.is_ascii_alphanumeric() || "_-./[]".contains(letter);
    name.starts_with(|first: char| first.is_ascii_alphabetic()) && name.chars().all(is_valid)
}
