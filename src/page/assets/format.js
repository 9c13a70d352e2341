// Numbers as people read them: SI prefixes, degrees, a minus sign that is one.

const PREFIXES = [["p", 1e-12], ["n", 1e-9], ["µ", 1e-6], ["m", 1e-3], ["", 1], ["k", 1e3], ["M", 1e6], ["G", 1e9]];
const DEGREE = 180 / Math.PI;
// Smaller results are rounding: Dimension::resolution_si.
const RESOLUTION = { N: 1e-9, "N·m": 1e-12, m: 1e-12, rad: 1e-12, "m/s": 1e-12, "rad/s": 1e-12 };

const minus = (text) => text.replace("-", "−");

// The factor from SI to what is shown, and its unit, for values up to `size`.
function shownUnit(unit, size) {
  if (unit === "rad") return { factor: DEGREE, unit: "°" };
  if (unit === "rad/s" && size >= 0.1 || unit === "m/s" && size >= 0.1) return { factor: 1, unit };
  if (!(size > 0) || !Number.isFinite(size)) return { factor: 1, unit };
  let best = PREFIXES[0];
  for (const prefix of PREFIXES) if (size >= prefix[1] * 0.9999995) best = prefix;
  return { factor: 1 / best[1], unit: best[0] + unit };
}

// A value with its unit in about `digits` digits: "98.861 kN".
function withUnit(value, unit, digits = 5) {
  if (value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (Math.abs(value) < RESOLUTION[unit]) value = 0;
  const shown = shownUnit(unit, Math.abs(value));
  const scaled = value * shown.factor;
  const space = shown.unit === "°" ? "" : "\u202f";
  // Long units leave room for a digit less.
  return plain(scaled, shown.unit.length > 5 ? digits - 1 : digits) + space + shown.unit;
}

function plain(value, digits) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e7) return minus(value.toExponential(Math.max(digits - 4, 0)).replace("e+", "e"));
  const whole = Math.floor(Math.log10(size)) + 1;
  return minus(value.toFixed(Math.max(0, Math.min(9, digits - Math.max(whole, 1)))));
}

// The unit in which all times of a page are shown, and the digits behind the point that tell its samples apart, down to
// a nanosecond.
function timeUnit(end, finest) {
  const [unit, factor, most] = end >= 1 ? ["s", 1, 9] : end >= 1e-3 ? ["ms", 1e3, 6] : ["µs", 1e6, 3];
  const decimals = Math.max(0, Math.min(most, Math.ceil(-Math.log10(Math.max(finest, 1e-12) * factor)) + 1));
  return { unit, factor, decimals };
}

const timeText = (time, by, decimals = by.decimals) => minus((time * by.factor).toFixed(decimals)) + "\u202f" + by.unit;

// A length of time in the unit that suits it, in three digits.
function durationText(time) {
  const shown = shownUnit("s", time);
  return String(Number((time * shown.factor).toPrecision(3))) + "\u202f" + shown.unit;
}

// A speed: the time of the run that goes by in a second of the reader's.
const speedText = (speed) => durationText(speed) + " per s";
