//! Messages of phalanx' own topics: flat protobuf messages, described by the schema embedded in the log.
//!
//! The message of a subject is the field `timestamp` (time since the start of the run, in s, unrounded) and its
//! independent quantities ([`Subject::independent`]), all doubles. Readers use field names.

use foxglove::Schema;
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, WireType, decode_key, double, skip_field, string};
use prost::{DecodeError, Message};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

use phalanx_core::trace::schema::{Subject, SubjectKind};
use phalanx_core::trace::{Event, EventKind};

/// Protobuf package of phalanx' own messages.
const PACKAGE: &str = "phalanx";

/// Fields of an event after the timestamp: texts, then numbers. Approach speed and impulse are in the units of the
/// contact; a touch-down has a speed, a lift-off an impulse.
const EVENT_TEXTS: [&str; 3] = ["subject", "subject_kind", "kind"];
const EVENT_NUMBERS: [&str; 4] = ["approach_speed_m_s", "impulse_n_s", "approach_speed_rad_s", "impulse_n_m_s"];

/// Message name of a kind of subject, with its package.
pub(crate) fn message_name(kind: SubjectKind) -> &'static str {
    match kind {
        SubjectKind::Joint => "phalanx.Joint",
        SubjectKind::Slider => "phalanx.Slider",
        SubjectKind::Actuator => "phalanx.Actuator",
        SubjectKind::LinearActuator => "phalanx.LinearActuator",
        SubjectKind::Tendon => "phalanx.Tendon",
        SubjectKind::CableElement => "phalanx.CableElement",
        SubjectKind::Shaft => "phalanx.Shaft",
        SubjectKind::Motor => "phalanx.Motor",
        SubjectKind::Distance => "phalanx.Distance",
        SubjectKind::Body => "phalanx.Body",
        SubjectKind::Contact => "phalanx.Contact",
        SubjectKind::Limit => "phalanx.Limit",
        SubjectKind::Energy => "phalanx.Energy",
    }
}

/// Message name of events, with its package.
pub(crate) const EVENT: &str = "phalanx.Event";

/// Returns the schema of the messages of a subject.
pub(crate) fn subject_schema(subject: &Subject) -> Schema {
    schema(message_name(subject.kind), subject.independent().map(|(_, quantity)| (quantity.key, Type::Double)))
}

/// Returns the schema of events.
pub(crate) fn event_schema() -> Schema {
    let texts = EVENT_TEXTS.map(|name| (name, Type::String));
    schema(EVENT, texts.into_iter().chain(EVENT_NUMBERS.map(|name| (name, Type::Double))))
}

/// Returns the schema of a message with a timestamp and these fields, with its file descriptor set.
fn schema(full_name: &str, fields: impl Iterator<Item = (&'static str, Type)>) -> Schema {
    let name = full_name.trim_start_matches(PACKAGE).trim_start_matches('.');
    let field = |(number, (name, kind)): (i32, (&str, Type))| FieldDescriptorProto {
        name: Some(name.to_string()),
        number: Some(number),
        label: Some(Label::Optional as i32),
        r#type: Some(kind as i32),
        ..FieldDescriptorProto::default()
    };
    let fields = [("timestamp", Type::Double)].into_iter().chain(fields);
    let message = DescriptorProto {
        name: Some(name.to_string()),
        field: (1..).zip(fields).map(field).collect(),
        ..DescriptorProto::default()
    };
    let file = FileDescriptorProto {
        name: Some(format!("{PACKAGE}/{name}.proto")),
        package: Some(PACKAGE.to_string()),
        message_type: vec![message],
        syntax: Some("proto3".to_string()),
        ..FileDescriptorProto::default()
    };
    Schema::new(full_name, "protobuf", FileDescriptorSet { file: vec![file] }.encode_to_vec())
}

/// Encodes the message of a subject. Fields are never omitted, not even zeros.
pub(crate) fn encode(time_s: f64, numbers: impl Iterator<Item = f64>, out: &mut Vec<u8>) {
    for (field, number) in (1..).zip([time_s].into_iter().chain(numbers)) {
        // The key of a field below 16 is one byte.
        out.push(field << 3 | WireType::SixtyFourBit as u8);
        out.extend_from_slice(&number.to_le_bytes());
    }
}

/// Decodes the message of a subject: returns its time, and sets `numbers` to its quantities. Missing fields are 0; further
/// fields are skipped.
pub(crate) fn decode(mut message: &[u8], numbers: &mut [f64]) -> Result<f64, DecodeError> {
    let mut time_s = 0.0;
    numbers.fill(0.0);
    while message.has_remaining() {
        let (field, wire_type) = decode_key(&mut message)?;
        let slot = match field {
            1 => Some(&mut time_s),
            _ => numbers.get_mut(field as usize - 2),
        };
        match slot {
            Some(slot) if wire_type == WireType::SixtyFourBit => {
                double::merge(wire_type, slot, &mut message, DecodeContext::default())?;
            }
            _ => skip_field(wire_type, field, &mut message, DecodeContext::default())?,
        }
    }
    Ok(time_s)
}

/// Encodes an event of a subject. The numbers that its kind does not have are omitted.
pub(crate) fn encode_event(event: &Event, subject: &str, subject_kind: SubjectKind, out: &mut Vec<u8>) {
    double::encode(1, &event.time_s, out);
    for (tag, text) in (2..).zip([subject, subject_kind.name(), event.kind.key()]) {
        string::encode(tag, &text.to_string(), out);
    }
    let first = 2 + EVENT_TEXTS.len() as u32 + if subject_kind.is_angular() { 2 } else { 0 };
    match event.kind {
        EventKind::TouchDown => double::encode(first, &event.approach_speed, out),
        EventKind::LiftOff => double::encode(first + 1, &event.impulse, out),
        EventKind::Reload | EventKind::Slips | EventKind::Sticks => {}
    }
}

/// Decodes an event: returns it without its contact, and name and kind of its subject. An unknown kind of event is `None`.
pub(crate) fn decode_event(mut message: &[u8]) -> Result<Option<(Event, [String; 2])>, DecodeError> {
    let (mut texts, mut numbers) = ([const { String::new() }; EVENT_TEXTS.len()], [0.0; EVENT_NUMBERS.len()]);
    let mut time_s = 0.0;
    while message.has_remaining() {
        let (field, wire_type) = decode_key(&mut message)?;
        let context = DecodeContext::default();
        let after_time = (field as usize).wrapping_sub(2);
        let number = match field {
            1 => Some(&mut time_s),
            _ => numbers.get_mut(after_time.wrapping_sub(EVENT_TEXTS.len())),
        };
        match (texts.get_mut(after_time), number, wire_type) {
            (Some(text), _, WireType::LengthDelimited) => string::merge(wire_type, text, &mut message, context)?,
            (_, Some(number), WireType::SixtyFourBit) => double::merge(wire_type, number, &mut message, context)?,
            _ => skip_field(wire_type, field, &mut message, context)?,
        }
    }
    let [subject, subject_kind, kind] = texts;
    let [speed, impulse, angular_speed, angular_impulse] = numbers;
    let kind = EventKind::ALL.into_iter().find(|known| known.key() == kind);
    let event = |kind| Event {
        time_s,
        contact: usize::MAX,
        kind,
        approach_speed: speed + angular_speed,
        impulse: impulse + angular_impulse,
    };
    Ok(kind.map(|kind| (event(kind), [subject, subject_kind])))
}

/// Returns the log time of a sample: nanoseconds since the start, rounded to the nearest.
pub fn stamp_ns(time_s: f64) -> u64 {
    // A cast from float saturates, so this cannot wrap.
    (time_s * 1e9).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_fields_by_number_in_any_order() {
        let mut message = vec![(3 << 3) | 1];
        message.extend(2.5f64.to_le_bytes());
        message.extend([(9 << 3) | 2, 3, b'a', b'b', b'c', (1 << 3) | 1]);
        message.extend(0.5f64.to_le_bytes());
        let mut numbers = [7.0; 3];
        assert_eq!((decode(&message, &mut numbers), numbers), (Ok(0.5), [0.0, 2.5, 0.0]));
        for cut in [1, 5, 8, 10, 11, 13, 15, 20] {
            assert!(decode(&message[..cut], &mut numbers).is_err(), "cut at {cut}");
        }
        for invalid in [&[0xff; 11][..], &[3], &[0, 7]] {
            assert!(decode(invalid, &mut numbers).is_err(), "{invalid:?}");
        }
        // A field number beyond all.
        assert_eq!((decode(&[0xf8, 0xff, 0xff, 0xff, 0x0f, 7], &mut numbers), numbers), (Ok(0.0), [0.0; 3]));
    }

    #[test]
    fn encoded_messages_are_decoded_unchanged() {
        let (mut message, mut numbers) = (Vec::new(), [0.0; 2]);
        encode(1.5, [0.0, -2.0].into_iter(), &mut message);
        assert_eq!((decode(&message, &mut numbers), numbers), (Ok(1.5), [0.0, -2.0]));
        for (kind, subject_kind) in
            EventKind::ALL.into_iter().zip([SubjectKind::Contact, SubjectKind::Limit].into_iter().cycle())
        {
            let approach_speed = if kind == EventKind::TouchDown { 2.5 } else { 0.0 };
            let impulse = if kind == EventKind::LiftOff { 0.25 } else { 0.0 };
            let event = Event { time_s: 0.125, contact: usize::MAX, kind, approach_speed, impulse };
            let mut message = Vec::new();
            encode_event(&event, "hammer-anvil", subject_kind, &mut message);
            assert_eq!(
                decode_event(&message),
                Ok(Some((event, ["hammer-anvil", subject_kind.name()].map(String::from))))
            );
            assert!(decode_event(&message[..message.len() - 1]).is_err());
        }
    }
}
