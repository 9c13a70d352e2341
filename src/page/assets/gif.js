// Pictures of few colours as a GIF, which plays anywhere: one palette for all frames, and of each frame only what has changed.

// The last index stands for what was there before.
const KEPT = 255;

// Colours closer than this are not told apart when the palette is chosen: five bits of each channel.
const binOf = (r, g, b) => (r >> 3) << 10 | (g >> 3) << 5 | b >> 3;

// The colours that are seen most, and the nearest of them for any other.
class Palette {
  constructor() {
    this.counts = new Map();
  }

  // Takes the colours of a picture.
  see({ data }) {
    for (let k = 0; k < data.length; k += 4) {
      const colour = data[k] << 16 | data[k + 1] << 8 | data[k + 2];
      this.counts.set(colour, (this.counts.get(colour) ?? 0) + 1);
    }
  }

  // Of each bin the colour that is seen most, of all bins the fullest ones.
  choose() {
    const bins = new Map();
    for (const [colour, count] of this.counts) {
      const key = binOf(colour >> 16, colour >> 8 & 255, colour & 255);
      const bin = bins.get(key) ?? { count: 0, most: 0, colour };
      bin.count += count;
      if (count > bin.most) [bin.most, bin.colour] = [count, colour];
      bins.set(key, bin);
    }
    const chosen = [...bins.values()].sort((a, b) => b.count - a.count).slice(0, KEPT);
    this.colours = chosen.map(({ colour }) => [colour >> 16, colour >> 8 & 255, colour & 255]);
    this.nearest = new Int16Array(1 << 15).fill(-1);
    this.counts = null;
  }

  // The indices of a picture.
  indices({ data }) {
    const found = new Uint8Array(data.length / 4);
    for (let i = 0; i < found.length; i++) {
      const [r, g, b] = [data[4 * i], data[4 * i + 1], data[4 * i + 2]];
      const bin = binOf(r, g, b);
      if (this.nearest[bin] < 0) this.nearest[bin] = this.search(r, g, b);
      found[i] = this.nearest[bin];
    }
    return found;
  }

  search(r, g, b) {
    const away = ([x, y, z]) => (x - r) ** 2 + (y - g) ** 2 + (z - b) ** 2;
    let best = 0;
    for (let k = 1; k < this.colours.length; k++) if (away(this.colours[k]) < away(this.colours[best])) best = k;
    return best;
  }

  bytes() {
    const table = new Uint8Array(3 * 256);
    this.colours.forEach((colour, k) => table.set(colour, 3 * k));
    return table;
  }
}

// Indices of eight bits by the compression of GIF (Lempel, Ziv and Welch), in blocks.
function compressed(indices) {
  const [CLEAR, END, MOST] = [256, 257, 4096];
  const blocks = [];
  let block = new Uint8Array(256);
  let [filled, bits, waiting, size, next] = [0, 0, 0, 9, 258];
  const byte = (value) => {
    block[++filled] = value;
    if (filled < 255) return;
    block[0] = filled;
    blocks.push(block);
    [block, filled] = [new Uint8Array(256), 0];
  };
  const emit = (code) => {
    waiting |= code << bits;
    for (bits += size; bits >= 8; bits -= 8) {
      byte(waiting & 255);
      waiting >>>= 8;
    }
  };
  // The code of a known string and an index behind it.
  const codes = new Uint16Array(MOST << 8);
  emit(CLEAR);
  let known = indices[0];
  for (let i = 1; i < indices.length; i++) {
    const place = known << 8 | indices[i];
    if (codes[place] > 0) {
      known = codes[place];
      continue;
    }
    emit(known);
    if (next === MOST) {
      emit(CLEAR);
      codes.fill(0);
      [size, next] = [9, 258];
    } else {
      if (next >= 1 << size) size++;
      codes[place] = next++;
    }
    known = indices[i];
  }
  emit(known);
  emit(END);
  if (bits > 0) byte(waiting & 255);
  block[0] = filled;
  blocks.push(block.subarray(0, filled + 1), new Uint8Array(filled > 0 ? 1 : 0));
  return blocks;
}

const short16 = (value) => [value & 255, value >> 8];

// A GIF as it grows.
class Gif {
  constructor(width, height, palette) {
    [this.width, this.palette, this.before] = [width, palette, null];
    const again = [0x21, 0xff, 11, ..."NETSCAPE2.0"].map((each) => (typeof each === "string" ? each.charCodeAt(0) : each));
    this.parts = [
      Uint8Array.from([..."GIF89a"].map((char) => char.charCodeAt(0))),
      Uint8Array.of(...short16(width), ...short16(height), 0xf7, 0, 0),
      palette.bytes(),
      Uint8Array.of(...again, 3, 1, 0, 0, 0),
    ];
  }

  // A frame that is shown for so many hundredths of a second.
  add(picture, hundredths) {
    const now = this.palette.indices(picture);
    const { left, top, width, height } = this.changed(now);
    const part = new Uint8Array(width * height);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        const at = (top + y) * this.width + left + x;
        part[y * width + x] = this.before && this.before[at] === now[at] ? KEPT : now[at];
      }
    }
    this.parts.push(
      Uint8Array.of(0x21, 0xf9, 4, 1 << 2 | 1, ...short16(hundredths), KEPT, 0),
      Uint8Array.of(0x2c, ...short16(left), ...short16(top), ...short16(width), ...short16(height), 0, 8),
      ...compressed(part),
    );
    this.before = now;
  }

  // The box around what is not as before; of nothing, one pixel.
  changed(now) {
    const [before, wide, high] = [this.before, this.width, now.length / this.width];
    if (!before) return { left: 0, top: 0, width: wide, height: high };
    let [left, right, top, bottom] = [wide, -1, high, -1];
    for (let y = 0, at = 0; y < high; y++) {
      for (let x = 0; x < wide; x++, at++) {
        if (before[at] === now[at]) continue;
        [left, right] = [Math.min(left, x), Math.max(right, x)];
        [top, bottom] = [Math.min(top, y), y];
      }
    }
    return right < 0 ? { left: 0, top: 0, width: 1, height: 1 } : { left, top, width: right - left + 1, height: bottom - top + 1 };
  }

  blob() {
    return new Blob([...this.parts, Uint8Array.of(0x3b)], { type: "image/gif" });
  }
}
