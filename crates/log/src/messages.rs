//! Messages of phalanx' own channels: flat protobuf messages of numbers, described by the schema embedded in the log.
//!
//! A message consists of the field `timestamp` (time since the start of the run, in s, unrounded), flags and doubles, in
//! the order of [`MessageType`]. Readers use field names; append new fields at the end.

use foxglove::Schema;
use prost::bytes::Buf;
use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field};
use prost::{DecodeError, Message};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

use phalanx_core::trace::{BodyState, ContactSample, Energy, Event, EventKind, FingerState};

/// Protobuf package of phalanx' own messages.
const PACKAGE: &str = "phalanx";

/// Name and fields of a message; names are separated by spaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MessageType {
    pub name: &'static str,
    flags: &'static str,
    numbers: &'static str,
}

/// Joint angles and rates, motor torque.
pub(crate) const STATE: MessageType = MessageType {
    name: "State",
    flags: "",
    numbers: "q11_rad q21_rad q12_rad q22_rad q13_rad qd11_rad_s qd21_rad_s qd12_rad_s qd22_rad_s motor_torque_n_m",
};

/// One disc. The angle is counter-clockwise and not wrapped.
pub(crate) const DISC: MessageType =
    MessageType { name: "Disc", flags: "", numbers: "x_m y_m angle_rad vx_m_s vy_m_s spin_rad_s" };

/// One phalanx against the object, or a disc against its partner. Forces act on the phalanx (the disc); the normal is a
/// unit vector from the object (the partner) to it. The impulse is the normal impulse since the start.
pub const CONTACT: MessageType = MessageType {
    name: "Contact",
    flags: "",
    numbers: "gap_m gap_rate_m_s slip_m_s normal_n tangential_n point_x_m point_y_m normal_x normal_y impulse_n_s",
};

/// The joint limit q22 ≥ −φ22.
pub(crate) const LIMIT: MessageType =
    MessageType { name: "Limit", flags: "", numbers: "gap_rad gap_rate_rad_s torque_n_m impulse_n_m_s" };

/// Energies, and works since the start.
pub(crate) const ENERGY: MessageType = MessageType {
    name: "Energy",
    flags: "",
    numbers: "kinetic_j gravity_j spring_j elastic_j dissipated_j motor_work_j balance_j",
};

/// A change of contact. `pressed`: a contact force acts from now on; `touch_down`: the surfaces come into contact.
///
/// | | `pressed` | `touch_down` | |
/// |---|---|---|---|
/// | touch-down | true | true | with its approach speed |
/// | lift-off | false | false | with the impulse since the touch-down |
/// | reload | true | false | the force returns before the surfaces have parted |
pub(crate) const IMPACT: MessageType =
    MessageType { name: "Impact", flags: "pressed touch_down", numbers: "approach_speed_m_s impulse_n_s" };

/// A change of contact at the joint limit, as [`IMPACT`].
pub(crate) const LIMIT_IMPACT: MessageType =
    MessageType { name: "LimitImpact", flags: "pressed touch_down", numbers: "approach_speed_rad_s impulse_n_m_s" };

/// Friction with stiction reaches the friction cone, where the slider of its bristle begins to slip (`slips`), or is
/// inside the cone again.
pub(crate) const SLIP: MessageType = MessageType { name: "Slip", flags: "slips", numbers: "" };

impl MessageType {
    /// Returns the schema, such as `phalanx.State`, with its file descriptor set.
    pub fn schema(&self) -> Schema {
        let fields = |names: &'static str, kind: Type| names.split_whitespace().map(move |name| (name, kind));
        let all = fields("timestamp", Type::Double)
            .chain(fields(self.flags, Type::Bool))
            .chain(fields(self.numbers, Type::Double));
        let field = |(number, (name, kind)): (i32, (&str, Type))| FieldDescriptorProto {
            name: Some(name.to_string()),
            number: Some(number),
            label: Some(Label::Optional as i32),
            r#type: Some(kind as i32),
            ..FieldDescriptorProto::default()
        };
        let message = DescriptorProto {
            name: Some(self.name.to_string()),
            field: (1..).zip(all).map(field).collect(),
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            name: Some(format!("{PACKAGE}/{}.proto", self.name)),
            package: Some(PACKAGE.to_string()),
            message_type: vec![message],
            syntax: Some("proto3".to_string()),
            ..FileDescriptorProto::default()
        };
        let data = FileDescriptorSet { file: vec![file] }.encode_to_vec();
        Schema::new(format!("{PACKAGE}.{}", self.name), "protobuf", data)
    }

    /// Whether a schema name denotes this type. In older logs every message has a package of its own
    /// (`state.State`).
    pub(crate) fn has_name(&self, schema_name: &str) -> bool {
        schema_name
            .split_once('.')
            .is_some_and(|(package, name)| name == self.name && (package == PACKAGE || package == name.to_lowercase()))
    }
}

/// Encodes a message. Fields are never omitted, not even zeros.
pub fn encode(time_s: f64, flags: &[bool], numbers: &[f64], out: &mut Vec<u8>) {
    let mut field = 0;
    let mut key = |wire_type: WireType| {
        field += 1;
        (field << 3) | wire_type as u8
    };
    out.push(key(WireType::SixtyFourBit));
    out.extend(time_s.to_le_bytes());
    for flag in flags {
        out.extend([key(WireType::Varint), u8::from(*flag)]);
    }
    for number in numbers {
        out.push(key(WireType::SixtyFourBit));
        out.extend(number.to_le_bytes());
    }
}

/// Decodes the fields 1…N of a message, flags as 0 or 1. Missing fields are 0; further fields are skipped.
pub fn decode<const N: usize>(mut message: &[u8]) -> Result<[f64; N], DecodeError> {
    let mut values = [0.0; N];
    while message.has_remaining() {
        let (field, wire_type) = decode_key(&mut message)?;
        let value = match wire_type {
            WireType::SixtyFourBit if message.remaining() >= 8 => message.get_f64_le(),
            WireType::Varint => decode_varint(&mut message)? as f64,
            _ => {
                skip_field(wire_type, field, &mut message, DecodeContext::default())?;
                continue;
            }
        };
        if let Some(slot) = values.get_mut(field as usize - 1) {
            *slot = value;
        }
    }
    Ok(values)
}

/// Returns the numbers of a [`STATE`] message.
pub(crate) fn state_numbers(finger: &FingerState) -> [f64; 10] {
    let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, .. } = *finger;
    let FingerState { qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, motor_torque_n_m, .. } = *finger;
    [q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, motor_torque_n_m]
}

/// Returns the state with these numbers.
pub fn state(numbers: [f64; 10]) -> FingerState {
    let [q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, rates @ .., motor_torque_n_m] = numbers;
    let [qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s] = rates;
    let positions = FingerState { q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, ..FingerState::default() };
    FingerState { qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, motor_torque_n_m, ..positions }
}

/// Returns the numbers of a [`DISC`] message.
pub(crate) fn disc_numbers(disc: &BodyState) -> [f64; 6] {
    let BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s } = *disc;
    [x, y, angle_rad, vx, vy, spin_rad_s]
}

/// Returns the disc with these numbers.
pub fn disc([x, y, angle_rad, vx, vy, spin_rad_s]: [f64; 6]) -> BodyState {
    BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
}

/// Returns the numbers of a [`CONTACT`] message.
pub(crate) fn contact_numbers(contact: &ContactSample) -> [f64; 10] {
    let ContactSample { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, .. } = *contact;
    let ContactSample { point_m: [x, y], normal: [normal_x, normal_y], .. } = *contact;
    [gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, x, y, normal_x, normal_y, impulse_n_s]
}

/// Returns the contact with these numbers.
pub fn contact(numbers: [f64; 10]) -> ContactSample {
    let [gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, x, y, normal_x, normal_y, impulse_n_s] = numbers;
    let (point_m, normal) = ([x, y], [normal_x, normal_y]);
    ContactSample { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal }
}

/// Returns the numbers of a [`LIMIT`] message.
pub(crate) fn limit_numbers(limit: &ContactSample) -> [f64; 4] {
    [limit.gap_m, limit.gap_rate_m_s, limit.normal_n, limit.impulse_n_s]
}

/// Returns the joint limit with these numbers.
pub fn limit([gap_m, gap_rate_m_s, normal_n, impulse_n_s]: [f64; 4]) -> ContactSample {
    ContactSample { gap_m, gap_rate_m_s, normal_n, impulse_n_s, ..ContactSample::default() }
}

/// Returns the energies with the numbers of an [`ENERGY`] message, the inverse of [`Energy::values_j`].
pub fn energy(numbers: [f64; 7]) -> Energy {
    let [kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j] = numbers;
    Energy { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j }
}

/// Returns the flags of an [`IMPACT`] or [`SLIP`] message.
pub(crate) fn event_flags(kind: EventKind) -> &'static [bool] {
    match kind {
        EventKind::TouchDown => &[true, true],
        EventKind::LiftOff => &[false, false],
        EventKind::Reload => &[true, false],
        EventKind::Slips => &[true],
        EventKind::Sticks => &[false],
    }
}

/// Decodes an [`IMPACT`] or [`LIMIT_IMPACT`] message of a contact.
pub(crate) fn decode_impact(contact: usize, message: &[u8]) -> Result<Event, DecodeError> {
    let [time_s, pressed, touch_down, approach_speed, impulse] = decode(message)?;
    let kind = match (pressed != 0.0, touch_down != 0.0) {
        (false, _) => EventKind::LiftOff,
        (true, true) => EventKind::TouchDown,
        (true, false) => EventKind::Reload,
    };
    Ok(Event { time_s, contact, kind, approach_speed, impulse })
}

/// Decodes a [`SLIP`] message of a contact.
pub(crate) fn decode_slip(contact: usize, message: &[u8]) -> Result<Event, DecodeError> {
    let [time_s, slips] = decode(message)?;
    let kind = if slips != 0.0 { EventKind::Slips } else { EventKind::Sticks };
    Ok(Event { time_s, contact, kind, approach_speed: 0.0, impulse: 0.0 })
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
        let mut message = vec![(2 << 3) | 1];
        message.extend(2.5f64.to_le_bytes());
        message.extend([(1 << 3), 1, (9 << 3) | 2, 3, b'a', b'b', b'c']);
        assert_eq!(decode::<3>(&message), Ok([1.0, 2.5, 0.0]));
        for cut in [1, 5, 8, 12, 13, 15] {
            assert!(decode::<3>(&message[..cut]).is_err() || cut == 9 || cut == 11, "cut at {cut}");
        }
        for invalid in [&[0xff; 11][..], &[3], &[0, 7]] {
            assert!(decode::<3>(invalid).is_err(), "{invalid:?}");
        }
        // A field number beyond N.
        assert_eq!(decode::<1>(&[0xf8, 0xff, 0xff, 0xff, 0x0f, 7]), Ok([0.0]));
    }

    #[test]
    fn encoded_messages_are_decoded_unchanged() {
        let mut message = Vec::new();
        encode(1.5, &[true, false], &[0.0, -2.0], &mut message);
        assert_eq!(decode::<5>(&message), Ok([1.5, 1.0, 0.0, 0.0, -2.0]));
        let numbers = std::array::from_fn(|k| k as f64);
        assert_eq!(state_numbers(&state(numbers)), numbers);
        assert_eq!(contact_numbers(&contact(numbers)), numbers);
        assert_eq!(disc_numbers(&disc([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(limit_numbers(&limit([1.0, 2.0, 3.0, 4.0])), [1.0, 2.0, 3.0, 4.0]);
        let names = ["phalanx.State", "state.State", "state.Other", "other.State", "State", ""];
        assert_eq!(names.map(|name| STATE.has_name(name)), [true, true, false, false, false, false]);
    }
}
