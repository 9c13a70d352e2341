// Decodes the points: base64 columns → arrays; evaluates a volume, or the intersection of all volumes.

const STABLE = 1;
const PALM = 2;
const CLOSED = 4;

function decodeBase64(text) {
  return Uint8Array.from(atob(text), (char) => char.charCodeAt(0));
}

// Columns are little-endian, like every platform with a browser.
const decodeF32 = (text) => new Float32Array(decodeBase64(text).buffer);
const decodeU16 = (text) => new Uint16Array(decodeBase64(text).buffer);

function loadVolumes() {
  const raw = JSON.parse(document.getElementById("data").textContent);
  raw.bases = raw.bases.map((base) => ({
    ...base,
    columns: Object.fromEntries(Object.entries(base.columns).map(([name, text]) => [name, decodeF32(text)])),
    reason: decodeU16(base.reason),
    frictions: base.frictions.map((friction) => ({
      flags: decodeBase64(friction.flags),
      columns: Object.fromEntries(Object.entries(friction.columns).map(([name, text]) => [name, decodeF32(text)])),
    })),
  }));
  raw.size = raw.axes.map((axis) => axis.values.length);
  raw.points = raw.size[0] * raw.size[1] * raw.size[2];
  raw.index = ([i, j, k]) => (i * raw.size[1] + j) * raw.size[2] + k;
  return raw;
}

// A column of a base, which may or may not depend on friction.
function getColumn(base, friction, name) {
  return base.frictions[friction].columns[name] ?? base.columns[name];
}

// Flags and values of all points of a volume, undefined where there is no finger. `base` is the index of a base, or −1
// for the intersection of all bases.
function evaluateVolume(data, base, friction, quantity) {
  const bases = base < 0 ? data.bases : [data.bases[base]];
  const flags = new Uint8Array(data.points).fill(STABLE | PALM | CLOSED);
  const hasFinger = new Uint8Array(data.points).fill(1);
  const values = new Float32Array(data.points);
  const worst = quantity.worst === "largest" ? Math.max : Math.min;
  bases.forEach((baseData, baseIndex) => {
    const baseFlags = baseData.frictions[friction].flags;
    const column = quantity.flag ? null : getColumn(baseData, friction, quantity.column);
    for (let point = 0; point < data.points; point++) {
      flags[point] &= baseFlags[point];
      if (baseData.reason[point]) hasFinger[point] = 0;
      const value = column ? column[point] : baseFlags[point] & CLOSED ? 1 : 0;
      values[point] = baseIndex === 0 ? value : worst(values[point], value);
    }
  });
  return { flags, hasFinger, values };
}

const REGIONS = {
  stable: (flags) => (flags & STABLE) !== 0,
  palm: (flags) => (flags & STABLE) !== 0 && (flags & PALM) !== 0,
  closed: (flags) => (flags & STABLE) !== 0 && (flags & CLOSED) !== 0,
};

// Percentage of all points that are in a region.
function regionShare(volume, region) {
  let count = 0;
  for (let point = 0; point < volume.flags.length; point++) if (volume.hasFinger[point] && REGIONS[region](volume.flags[point])) count++;
  return (100 * count) / volume.flags.length;
}
