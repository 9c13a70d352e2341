// The points: base64 columns → arrays, and what they say of one volume or of the intersection of all.

const STABLE = 1;
const PALM = 2;
const CLOSED = 4;

function bytesOf(text) {
  return Uint8Array.from(atob(text), (char) => char.charCodeAt(0));
}

// Columns are little-endian, as every machine with a browser is.
const floats = (text) => new Float32Array(bytesOf(text).buffer);
const shorts = (text) => new Uint16Array(bytesOf(text).buffer);

function loaded() {
  const raw = JSON.parse(document.getElementById("data").textContent);
  raw.bases = raw.bases.map((base) => ({
    ...base,
    columns: Object.fromEntries(Object.entries(base.columns).map(([name, text]) => [name, floats(text)])),
    reason: shorts(base.reason),
    frictions: base.frictions.map((friction) => ({
      flags: bytesOf(friction.flags),
      columns: Object.fromEntries(Object.entries(friction.columns).map(([name, text]) => [name, floats(text)])),
    })),
  }));
  raw.size = raw.axes.map((axis) => axis.values.length);
  raw.points = raw.size[0] * raw.size[1] * raw.size[2];
  raw.index = ([i, j, k]) => (i * raw.size[1] + j) * raw.size[2] + k;
  return raw;
}

// A column of a base, whether it depends on friction or not.
function columnOf(base, friction, name) {
  return base.frictions[friction].columns[name] ?? base.columns[name];
}

// One volume as it is looked at: flags and values of every point, undefined where there is no finger. `base` is the number
// of a base, or −1 for the intersection of all.
function volumeOf(data, base, friction, quantity) {
  const bases = base < 0 ? data.bases : [data.bases[base]];
  const flags = new Uint8Array(data.points).fill(STABLE | PALM | CLOSED);
  const finger = new Uint8Array(data.points).fill(1);
  const values = new Float32Array(data.points);
  const worst = quantity.worst === "largest" ? Math.max : Math.min;
  bases.forEach((each, number) => {
    const own = each.frictions[friction].flags;
    const column = quantity.flag ? null : columnOf(each, friction, quantity.column);
    for (let n = 0; n < data.points; n++) {
      flags[n] &= own[n];
      if (each.reason[n]) finger[n] = 0;
      const value = column ? column[n] : own[n] & CLOSED ? 1 : 0;
      values[n] = number === 0 ? value : worst(values[n], value);
    }
  });
  return { flags, finger, values };
}

const REGIONS = {
  stable: (flags) => (flags & STABLE) !== 0,
  palm: (flags) => (flags & STABLE) !== 0 && (flags & PALM) !== 0,
  closed: (flags) => (flags & STABLE) !== 0 && (flags & CLOSED) !== 0,
};

// Percent of all points in a region.
function shareOf(volume, region) {
  let count = 0;
  for (let n = 0; n < volume.flags.length; n++) if (volume.finger[n] && REGIONS[region](volume.flags[n])) count++;
  return (100 * count) / volume.flags.length;
}
