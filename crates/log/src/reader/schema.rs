//! Schema of the samples of a log: from its list of subjects, or from the attached scene, and from its channels.
//!
//! The list is complete; early logs of this version do not have it. A channel describes its subject by its topic, the name of its
//! messages and its metadata, so that a log without list and scene lacks only the subjects without a channel.

use std::collections::HashSet;

use prost::Message;
use prost_types::FileDescriptorSet;

use super::scan::{MAX_RECORD_BYTES, Scan};
use super::summary::{LogSummary, Loss, LossKind};
use crate::channels::{DescribedSubject, read_subjects, subject_of_channel};
use phalanx_core::scene::{locate_problems, parse_any};
use phalanx_core::trace::Schema;
use phalanx_core::trace::schema::SubjectKind;

/// Maximum number of subjects: five times those of the largest scene.
const MAX_SUBJECTS: usize = 30_000;

/// Field of the messages of joints that contain their forces.
const FORCE_FIELD: &str = "force_x_n";

/// Returns the schema of the samples. Adds the loss of a scene that cannot be used to the summary.
pub(super) fn read_schema<'a>(
    summary: &mut LogSummary,
    scan: &Scan,
    channels: impl Iterator<Item = &'a mcap::Channel<'static>> + Clone,
) -> Schema {
    let count = summary.finger_count();
    let of_hand = Schema::for_fingers(count);
    let of_scene = schema_of_scene(summary, scan);
    let mut schema = match (&scan.subjects, of_scene.as_ref().filter(|schema| schema.fingers.len() == count)) {
        (Some(list), _) => {
            let mut schema = Schema { fingers: of_hand.fingers.clone(), ..Schema::default() };
            read_subjects(list).take(MAX_SUBJECTS).for_each(|subject| add(&mut schema, &subject));
            schema
        }
        (None, Some(schema)) => schema.clone(),
        (None, None) => {
            let mut schema = of_hand.clone();
            keep_contacts(&mut schema, channels.clone().map(|channel| channel.topic.as_str()));
            schema
        }
    };
    let described: Vec<DescribedSubject> = channels.clone().filter_map(subject_of_channel).take(MAX_SUBJECTS).collect();
    described.iter().for_each(|subject| add(&mut schema, subject));
    // The joints of fingers come first.
    if !schema.joints.starts_with(&of_hand.joints) {
        schema.fingers.clear();
    }
    let in_metadata = summary.metadata.get("log_joint_forces").is_some_and(|value| value == "true");
    schema.has_joint_forces = channels.clone().find_map(has_joint_forces).unwrap_or(in_metadata);
    let is_of_log = |of_scene: Schema| Schema { has_joint_forces: schema.has_joint_forces, ..of_scene } == schema;
    if of_scene.is_some_and(|of_scene| !is_of_log(of_scene)) {
        let reason = "the attached scene does not have the joints, bodies and contacts of the log";
        summary.losses.push(Loss::of_scene(scan.scene_offset, reason));
    }
    schema
}

/// Returns the schema of the attached scene. Adds its loss to the summary if there is none, or if it cannot be read.
fn schema_of_scene(summary: &mut LogSummary, scan: &Scan) -> Option<Schema> {
    let reason = match summary.scene.as_ref().map(|(name, text)| (name, text, text.len() < MAX_RECORD_BYTES)) {
        Some((name, text, true)) => match parse_any(text, name) {
            Ok(scene) => return Some(Schema::from_scene(&scene)),
            Err(error) => {
                let problem = locate_problems(&error).into_iter().next();
                let problem = problem.map(|problem| {
                    let line = problem.line.map(|line| format!("line {line}: ")).unwrap_or_default();
                    format!(" ({line}{})", problem.message)
                });
                format!("this version of phalanx cannot read the attached scene{}", problem.unwrap_or_default())
            }
        },
        Some((.., false)) => "the attached scene is too large".to_string(),
        None => "the log has no attached scene".to_string(),
    };
    let is_known = summary.losses.iter().any(|loss| loss.kind == LossKind::Scene);
    // A log that ends before its scene has nothing else either.
    if !is_known && (scan.damage.is_none() || summary.chunks > 0) {
        summary.losses.push(Loss::of_scene(scan.scene_offset, &reason));
    }
    None
}

/// Adds a subject to a schema.
fn add(schema: &mut Schema, subject: &DescribedSubject) {
    let DescribedSubject { kind, is_limit, ref name } = *subject;
    // In logs without the kind, the limit of a slider is named after it.
    let is_limit = is_limit.unwrap_or_else(|| {
        let joint = name.strip_suffix("_lower").or(name.strip_suffix("_upper"));
        schema.joints.iter().any(|known| known.is_linear && Some(known.name.as_str()) == joint)
    });
    schema.add_subject(kind, is_limit, name);
}

/// Keeps the contacts of fingers that have topics in a log.
fn keep_contacts<'a>(schema: &mut Schema, topics: impl Iterator<Item = &'a str>) {
    let found: HashSet<&str> = topics.filter_map(|topic| topic.strip_prefix("/contact/")).collect();
    // A finger with an object has contacts of both phalanges, which have the first indices.
    let is_phalanx = |name: &str| ["proximal", "distal"].contains(&name);
    let has_object = found.iter().any(|name| is_phalanx(name));
    schema.contacts.retain(|contact| found.contains(contact.name.as_str()) || has_object && is_phalanx(&contact.name));
    schema.limits = schema.contacts.iter().filter(|contact| contact.is_angular).count();
}

/// Whether the messages of a joint contain its force, according to their descriptor; `None` for other channels.
fn has_joint_forces(channel: &mcap::Channel) -> Option<bool> {
    let kind = subject_of_channel(channel)?.kind;
    let schema = channel.schema.as_ref().filter(|_| matches!(kind, SubjectKind::Joint | SubjectKind::Slider))?;
    let descriptors = FileDescriptorSet::decode(&*schema.data).ok()?;
    let mut fields = descriptors.file.iter().flat_map(|file| &file.message_type).flat_map(|message| &message.field);
    Some(fields.any(|field| field.name() == FORCE_FIELD))
}
