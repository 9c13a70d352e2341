// GIF encoder: one palette for all frames; each frame contains only the box that has changed.

// The last index is transparent: the pixel of the previous frame remains.
const TRANSPARENT = 255;

// Colours are binned by five bits per channel to choose the palette.
const colourBin = (r, g, b) => (r >> 3) << 10 | (g >> 3) << 5 | b >> 3;

// The most frequent colours; other colours are mapped to the nearest of them.
class Palette {
  constructor() {
    this.counts = new Map();
  }

  // Counts the colours of a picture.
  addPicture({ data }) {
    for (let k = 0; k < data.length; k += 4) {
      const colour = data[k] << 16 | data[k + 1] << 8 | data[k + 2];
      this.counts.set(colour, (this.counts.get(colour) ?? 0) + 1);
    }
  }

  // Chooses the most frequent colour of each of the largest bins.
  build() {
    const bins = new Map();
    for (const [colour, count] of this.counts) {
      const key = colourBin(colour >> 16, colour >> 8 & 255, colour & 255);
      const bin = bins.get(key) ?? { count: 0, maxCount: 0, colour };
      bin.count += count;
      if (count > bin.maxCount) [bin.maxCount, bin.colour] = [count, colour];
      bins.set(key, bin);
    }
    const largestBins = [...bins.values()].sort((a, b) => b.count - a.count).slice(0, TRANSPARENT);
    this.colours = largestBins.map(({ colour }) => [colour >> 16, colour >> 8 & 255, colour & 255]);
    this.nearest = new Int16Array(1 << 15).fill(-1);
    this.counts = null;
  }

  // The palette indices of a picture.
  indices({ data }) {
    const indices = new Uint8Array(data.length / 4);
    for (let i = 0; i < indices.length; i++) {
      const [r, g, b] = [data[4 * i], data[4 * i + 1], data[4 * i + 2]];
      const bin = colourBin(r, g, b);
      if (this.nearest[bin] < 0) this.nearest[bin] = this.search(r, g, b);
      indices[i] = this.nearest[bin];
    }
    return indices;
  }

  search(r, g, b) {
    const squaredDistance = ([x, y, z]) => (x - r) ** 2 + (y - g) ** 2 + (z - b) ** 2;
    let best = 0;
    for (let k = 1; k < this.colours.length; k++) if (squaredDistance(this.colours[k]) < squaredDistance(this.colours[best])) best = k;
    return best;
  }

  bytes() {
    const table = new Uint8Array(3 * 256);
    this.colours.forEach((colour, k) => table.set(colour, 3 * k));
    return table;
  }
}

// Compresses 8-bit indices with GIF's LZW (Lempel, Ziv and Welch) into blocks.
function compressLzw(indices) {
  const [CLEAR, END, MAX_CODES] = [256, 257, 4096];
  const blocks = [];
  let block = new Uint8Array(256);
  let [filled, bitCount, pendingBits, codeSize, nextCode] = [0, 0, 0, 9, 258];
  const writeByte = (value) => {
    block[++filled] = value;
    if (filled < 255) return;
    block[0] = filled;
    blocks.push(block);
    [block, filled] = [new Uint8Array(256), 0];
  };
  const writeCode = (code) => {
    pendingBits |= code << bitCount;
    for (bitCount += codeSize; bitCount >= 8; bitCount -= 8) {
      writeByte(pendingBits & 255);
      pendingBits >>>= 8;
    }
  };
  // Code of each string, addressed by the code of its prefix and its last index.
  const codes = new Uint16Array(MAX_CODES << 8);
  writeCode(CLEAR);
  let prefixCode = indices[0];
  for (let i = 1; i < indices.length; i++) {
    const slot = prefixCode << 8 | indices[i];
    if (codes[slot] > 0) {
      prefixCode = codes[slot];
      continue;
    }
    writeCode(prefixCode);
    if (nextCode === MAX_CODES) {
      writeCode(CLEAR);
      codes.fill(0);
      [codeSize, nextCode] = [9, 258];
    } else {
      if (nextCode >= 1 << codeSize) codeSize++;
      codes[slot] = nextCode++;
    }
    prefixCode = indices[i];
  }
  writeCode(prefixCode);
  writeCode(END);
  if (bitCount > 0) writeByte(pendingBits & 255);
  block[0] = filled;
  blocks.push(block.subarray(0, filled + 1), new Uint8Array(filled > 0 ? 1 : 0));
  return blocks;
}

const uint16Bytes = (value) => [value & 255, value >> 8];

// A GIF to which frames are appended.
class Gif {
  constructor(width, height, palette) {
    [this.width, this.palette, this.previous] = [width, palette, null];
    const loopExtension = [0x21, 0xff, 11, ..."NETSCAPE2.0"].map((each) => (typeof each === "string" ? each.charCodeAt(0) : each));
    this.parts = [
      Uint8Array.from([..."GIF89a"].map((char) => char.charCodeAt(0))),
      Uint8Array.of(...uint16Bytes(width), ...uint16Bytes(height), 0xf7, 0, 0),
      palette.bytes(),
      Uint8Array.of(...loopExtension, 3, 1, 0, 0, 0),
    ];
  }

  // Appends a frame with its duration in hundredths of a second.
  add(picture, hundredths) {
    const frameIndices = this.palette.indices(picture);
    const { left, top, width, height } = this.changedBox(frameIndices);
    const changedIndices = new Uint8Array(width * height);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        const index = (top + y) * this.width + left + x;
        changedIndices[y * width + x] = this.previous && this.previous[index] === frameIndices[index] ? TRANSPARENT : frameIndices[index];
      }
    }
    this.parts.push(
      Uint8Array.of(0x21, 0xf9, 4, 1 << 2 | 1, ...uint16Bytes(hundredths), TRANSPARENT, 0),
      Uint8Array.of(0x2c, ...uint16Bytes(left), ...uint16Bytes(top), ...uint16Bytes(width), ...uint16Bytes(height), 0, 8),
      ...compressLzw(changedIndices),
    );
    this.previous = frameIndices;
  }

  // The box around the changed pixels; one pixel if nothing has changed.
  changedBox(frameIndices) {
    const [previous, frameWidth, frameHeight] = [this.previous, this.width, frameIndices.length / this.width];
    if (!previous) return { left: 0, top: 0, width: frameWidth, height: frameHeight };
    let [left, right, top, bottom] = [frameWidth, -1, frameHeight, -1];
    for (let y = 0, index = 0; y < frameHeight; y++) {
      for (let x = 0; x < frameWidth; x++, index++) {
        if (previous[index] === frameIndices[index]) continue;
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
