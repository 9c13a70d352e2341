// Base85: five characters per four bytes, an overhead of a quarter instead of the third of base64.

// The first 85 printable ASCII characters that need no escape in JSON or HTML.
const ALPHABET = Array.from({ length: 94 }, (_, k) => String.fromCharCode(33 + k)).filter((character) => !"\"&'<>\\".includes(character)).slice(0, 85).join("");

// Decodes big-endian groups of four bytes. The last group is padded with zeros; `length` is the number of bytes.
function decodeBase85(text, length) {
  const digitValues = new Uint8Array(128);
  for (let k = 0; k < ALPHABET.length; k++) digitValues[ALPHABET.charCodeAt(k)] = k;
  const bytes = new Uint8Array(Math.ceil(length / 4) * 4);
  const view = new DataView(bytes.buffer);
  for (let byteOffset = 0, textOffset = 0; byteOffset < bytes.length; byteOffset += 4, textOffset += 5) {
    let word = 0;
    for (let k = 0; k < 5; k++) word = word * 85 + digitValues[text.charCodeAt(textOffset + k)];
    view.setUint32(byteOffset, word);
  }
  return bytes.subarray(0, length);
}
