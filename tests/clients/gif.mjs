// GIF89a decoder, written from the specification and independent of the encoder of the page.

import assert from "node:assert/strict";

/** Decompresses the indices of a frame (LZW, codes from nine bits). */
function decompress(bytes) {
  const [CLEAR, END] = [256, 257];
  const out = [];
  let [at, size, strings, before, ended] = [0, 9, [], null, false];
  const clear = () => {
    [strings, size, before] = [Array.from({ length: 258 }, (_, k) => [k]), 9, null];
  };
  clear();
  while (!ended) {
    let code = 0;
    for (let k = 0; k < size; k++, at++) code |= (bytes[at >> 3] >> (at & 7) & 1) << k;
    assert.ok(at <= 8 * bytes.length, "the data ends within a code");
    if (code === CLEAR) {
      clear();
    } else if (code === END) {
      ended = true;
    } else {
      assert.ok(code < strings.length || before && code === strings.length, `code ${code} of ${strings.length}`);
      const string = strings[code] ?? [...before, before[0]];
      out.push(...string);
      if (before && strings.length < 4096) strings.push([...before, string[0]]);
      if (strings.length === 1 << size && size < 12) size++;
      before = string;
    }
  }
  return out;
}

/** Decodes a GIF: size, frames with their delays (s), and the pixels (RGB) after the last frame. */
export function gif(file) {
  assert.equal(file.toString("latin1", 0, 6), "GIF89a");
  const [width, height, packed] = [file.readUInt16LE(6), file.readUInt16LE(8), file[10]];
  assert.equal(packed & 0x80, 0x80, "a global palette");
  const colours = 2 << (packed & 7);
  const palette = file.subarray(13, 13 + 3 * colours);
  const screen = new Uint8Array(width * height);
  const frames = [];
  let [at, control, loops] = [13 + 3 * colours, null, false];
  const blocks = () => {
    const parts = [];
    for (; file[at] > 0; at += file[at] + 1) parts.push(file.subarray(at + 1, at + 1 + file[at]));
    at++;
    return Buffer.concat(parts);
  };
  while (file[at] !== 0x3b) {
    const kind = file[at];
    if (kind === 0x21) {
      const label = file[at + 1];
      at += 2;
      const data = blocks();
      if (label === 0xf9) control = { delay_s: data.readUInt16LE(1) / 100, transparent: data[0] & 1 ? data[3] : -1, disposal: data[0] >> 2 & 7 };
      if (label === 0xff) loops = data.toString("latin1", 0, 11) === "NETSCAPE2.0";
      continue;
    }
    assert.equal(kind, 0x2c, `unknown block at ${at}`);
    const [left, top, wide, high] = [1, 3, 5, 7].map((k) => file.readUInt16LE(at + k));
    assert.ok(left + wide <= width && top + high <= height && file[at + 9] === 0 && file[at + 10] === 8);
    at += 11;
    const indices = decompress(blocks());
    assert.equal(indices.length, wide * high);
    assert.equal(control.disposal, 1);
    indices.forEach((index, k) => {
      if (index !== control.transparent) screen[(top + Math.floor(k / wide)) * width + left + k % wide] = index;
    });
    frames.push({ delay_s: control.delay_s, pixels: wide * high });
  }
  assert.equal(at, file.length - 1);
  return { width, height, frames, loops, pixel: (x, y) => [...palette.subarray(3 * screen[y * width + x], 3 * screen[y * width + x] + 3)] };
}
