//! Base85: five characters per four bytes, an overhead of a quarter instead of the third of base64. The WebAssembly
//! module is most of the size of the explorer's page.

const CHARACTERS: usize = 85;

/// Returns the first 85 printable ASCII characters that need no escape in JSON or HTML.
fn alphabet() -> Vec<u8> {
    (b'!'..=b'~').filter(|character| !b"\"&'<>\\".contains(character)).take(CHARACTERS).collect()
}

/// Encodes bytes in big-endian groups of four. The last group is padded with zeros; a decoder needs the number of
/// bytes.
pub(super) fn encode_base85(bytes: &[u8]) -> String {
    let alphabet = alphabet();
    let mut text = String::with_capacity(bytes.len().div_ceil(4) * 5);
    for group in bytes.chunks(4) {
        let mut padded = [0; 4];
        padded[..group.len()].copy_from_slice(group);
        let word = u32::from_be_bytes(padded) as usize;
        for power in [85 * 85 * 85 * 85, 85 * 85 * 85, 85 * 85, 85, 1] {
            text.push(char::from(alphabet[word / power % CHARACTERS]));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decodes `length` bytes with the algorithm of the page.
    fn decode(text: &str, length: usize) -> Vec<u8> {
        let alphabet = alphabet();
        let digit = |character: u8| alphabet.iter().position(|each| *each == character).expect("one of the 85") as u32;
        let decode_group = |group: &[u8]| group.iter().fold(0, |word: u32, &each| word * 85 + digit(each));
        let bytes: Vec<u8> = text.as_bytes().chunks(5).flat_map(|group| decode_group(group).to_be_bytes()).collect();
        bytes[..length].to_vec()
    }

    #[test]
    fn encoding_is_reversible_and_needs_no_escapes() {
        let bytes: Vec<u8> =
            (0..1021_u32).map(|k| (k * k * 31 + k / 7) as u8).chain([0, 0, 255, 255, 255, 255]).collect();
        for length in [0, 1, 2, 3, 4, 5, bytes.len()] {
            let text = encode_base85(&bytes[..length]);
            assert_eq!(text.len(), length.div_ceil(4) * 5);
            assert_eq!(decode(&text, length), bytes[..length]);
            assert_eq!(serde_json::to_string(&text).expect("a text"), format!("\"{text}\""));
            assert!(!text.contains(['<', '>', '&']));
        }
    }
}
