//! Bytes as text: five characters for four bytes, a quarter more than the bytes where base64 takes a third. The module is most of
//! what the explorer's page weighs.

const CHARACTERS: usize = 85;

/// Of ASCII what needs no escape in JSON or HTML, in its order.
fn characters() -> Vec<u8> {
    (b'!'..=b'~').filter(|character| !b"\"&'<>\\".contains(character)).take(CHARACTERS).collect()
}

/// Groups are big-endian; the last is filled up with zeros, which whoever knows the number of bytes leaves out.
pub(super) fn base85(bytes: &[u8]) -> String {
    let characters = characters();
    let mut text = String::with_capacity(bytes.len().div_ceil(4) * 5);
    for group in bytes.chunks(4) {
        let mut whole = [0; 4];
        whole[..group.len()].copy_from_slice(group);
        let number = u32::from_be_bytes(whole) as usize;
        for power in [85 * 85 * 85 * 85, 85 * 85 * 85, 85 * 85, 85, 1] {
            text.push(char::from(characters[number / power % CHARACTERS]));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes again, as the page reads them.
    fn back(text: &str, length: usize) -> Vec<u8> {
        let characters = characters();
        let value = |character: u8| characters.iter().position(|each| *each == character).expect("one of the 85") as u32;
        let number = |group: &[u8]| group.iter().fold(0, |sum: u32, &each| sum * 85 + value(each));
        let bytes: Vec<u8> = text.as_bytes().chunks(5).flat_map(|group| number(group).to_be_bytes()).collect();
        bytes[..length].to_vec()
    }

    #[test]
    fn bytes_come_back_and_nothing_needs_an_escape() {
        let bytes: Vec<u8> = (0..1021_u32).map(|k| (k * k * 31 + k / 7) as u8).chain([0, 0, 255, 255, 255, 255]).collect();
        for length in [0, 1, 2, 3, 4, 5, bytes.len()] {
            let text = base85(&bytes[..length]);
            assert_eq!(text.len(), length.div_ceil(4) * 5);
            assert_eq!(back(&text, length), bytes[..length]);
            assert_eq!(serde_json::to_string(&text).expect("a text"), format!("\"{text}\""));
            assert!(!text.contains(['<', '>', '&']));
        }
    }
}
