//! The protobuf wire format, as far as messages of phalanx use it: doubles, booleans, texts; fields by number.

use super::bytes::{Cursor, Malformed};

/// The value of one field.
enum Value<'a> {
    Number(f64),
    Bytes(&'a [u8]),
}

/// The fields 1…N of a flat message of doubles and booleans; what is not there is 0, what is further is skipped.
pub fn numbers<const N: usize>(message: &[u8]) -> Result<[f64; N], Malformed> {
    let mut values = [0.0; N];
    each(message, |number, value| {
        if let (Some(slot), Value::Number(value)) =
            (usize::try_from(number).ok().and_then(|n| values.get_mut(n.checked_sub(1)?)), value)
        {
            *slot = value;
        }
    })?;
    Ok(values)
}

/// The fields 3 (message) and 4 (name) of a `foxglove.Log`.
pub fn log_line(message: &[u8]) -> Result<(String, String), Malformed> {
    let (mut text, mut name) = (String::new(), String::new());
    each(message, |number, value| {
        if let Value::Bytes(bytes) = value {
            match number {
                3 => text = String::from_utf8_lossy(bytes).into_owned(),
                4 => name = String::from_utf8_lossy(bytes).into_owned(),
                _ => {}
            }
        }
    })?;
    Ok((text, name))
}

fn each<'a>(message: &'a [u8], mut field: impl FnMut(u64, Value<'a>)) -> Result<(), Malformed> {
    let mut cursor = Cursor::new(message);
    while !cursor.is_empty() {
        let key = varint(&mut cursor)?;
        let value = match key & 7 {
            0 => Value::Number(varint(&mut cursor)? as f64),
            1 => Value::Number(cursor.f64()?),
            2 => {
                let length = varint(&mut cursor)?;
                Value::Bytes(cursor.take(length)?)
            }
            5 => Value::Number(f64::from(f32::from_bits(cursor.u32()?))),
            _ => return Err(Malformed("a message is not protobuf")),
        };
        field(key >> 3, value);
    }
    Ok(())
}

fn varint(cursor: &mut Cursor<'_>) -> Result<u64, Malformed> {
    let mut value = 0u64;
    for shift in (0..64).step_by(7) {
        let byte = cursor.u8()?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err(Malformed("a number in a message has no end"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_by_number_in_any_order() {
        let mut message = vec![(2 << 3) | 1];
        message.extend(2.5f64.to_le_bytes());
        message.extend([(1 << 3), 1, (9 << 3) | 2, 3, b'a', b'b', b'c']);
        assert_eq!(numbers::<3>(&message), Ok([1.0, 2.5, 0.0]));
        for cut in [1, 5, 8, 12, 13, 15] {
            assert!(numbers::<3>(&message[..cut]).is_err() || cut == 9 || cut == 11, "cut at {cut}");
        }
        assert!(numbers::<3>(&[0xff; 11]).is_err());
        assert!(numbers::<3>(&[3]).is_err());
        // A field number of 0 and one beyond any list.
        assert_eq!(numbers::<1>(&[0, 7, 0xf8, 0xff, 0xff, 0xff, 0xff, 0x01, 7]), Ok([0.0]));
    }
}
