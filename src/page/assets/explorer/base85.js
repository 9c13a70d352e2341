// Bytes as text: five characters for four bytes, a quarter more than the bytes where base64 takes a third.

// Of ASCII what needs no escape in JSON or HTML, in its order.
const CHARACTERS = Array.from({ length: 94 }, (_, k) => String.fromCharCode(33 + k)).filter((each) => !"\"&'<>\\".includes(each)).slice(0, 85).join("");

// Groups are big-endian; the last is filled up with zeros, which `length` leaves out.
function bytesOf(text, length) {
  const values = new Uint8Array(128);
  for (let k = 0; k < CHARACTERS.length; k++) values[CHARACTERS.charCodeAt(k)] = k;
  const bytes = new Uint8Array(Math.ceil(length / 4) * 4);
  const view = new DataView(bytes.buffer);
  for (let at = 0, from = 0; at < bytes.length; at += 4, from += 5) {
    let group = 0;
    for (let k = 0; k < 5; k++) group = group * 85 + values[text.charCodeAt(from + k)];
    view.setUint32(at, group);
  }
  return bytes.subarray(0, length);
}
