//! Decoder of the protobuf wire format for phalanx' own messages: doubles and booleans by field number.

use super::bytes::{Cursor, MalformedData};

/// Decodes fields 1…N of a flat message of doubles and booleans. Missing fields are 0; other fields are skipped.
pub fn decode_doubles<const N: usize>(message: &[u8]) -> Result<[f64; N], MalformedData> {
    let (mut values, mut cursor) = ([0.0; N], Cursor::new(message));
    while !cursor.is_empty() {
        let key = varint(&mut cursor)?;
        let value = match key & 7 {
            0 => varint(&mut cursor)? as f64,
            1 => cursor.f64()?,
            2 => {
                let length = varint(&mut cursor)?;
                cursor.take(length)?;
                continue;
            }
            5 => f64::from(f32::from_bits(cursor.u32()?)),
            _ => return Err(MalformedData("a message is not protobuf")),
        };
        if let Some(slot) = usize::try_from(key >> 3).ok().and_then(|number| values.get_mut(number.checked_sub(1)?)) {
            *slot = value;
        }
    }
    Ok(values)
}

fn varint(cursor: &mut Cursor<'_>) -> Result<u64, MalformedData> {
    let mut value = 0u64;
    for shift in (0..64).step_by(7) {
        let byte = cursor.u8()?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err(MalformedData("a varint in a message is too long"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_fields_by_number_in_any_order() {
        let mut message = vec![(2 << 3) | 1];
        message.extend(2.5f64.to_le_bytes());
        message.extend([(1 << 3), 1, (9 << 3) | 2, 3, b'a', b'b', b'c']);
        assert_eq!(decode_doubles::<3>(&message), Ok([1.0, 2.5, 0.0]));
        for cut in [1, 5, 8, 12, 13, 15] {
            assert!(decode_doubles::<3>(&message[..cut]).is_err() || cut == 9 || cut == 11, "cut at {cut}");
        }
        assert!(decode_doubles::<3>(&[0xff; 11]).is_err());
        assert!(decode_doubles::<3>(&[3]).is_err());
        // Field number 0 and a field number beyond N.
        assert_eq!(decode_doubles::<1>(&[0, 7, 0xf8, 0xff, 0xff, 0xff, 0xff, 0x01, 7]), Ok([0.0]));
    }
}
