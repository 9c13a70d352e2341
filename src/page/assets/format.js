// Formats numbers: SI prefixes, degrees, typographic minus sign.

const PREFIXES = [["p", 1e-12], ["n", 1e-9], ["µ", 1e-6], ["m", 1e-3], ["", 1], ["k", 1e3], ["M", 1e6], ["G", 1e9]];
const DEGREE = 180 / Math.PI;
// Smaller values are rounding errors: Dimension::resolution_si.
const RESOLUTION = { N: 1e-9, "N·m": 1e-12, m: 1e-12, rad: 1e-12, "m/s": 1e-12, "rad/s": 1e-12 };

const withMinusSign = (text) => text.replace("-", "−");

// The unit in which values up to `magnitude` are shown, and the factor from SI to it.
function displayUnit(unit, magnitude) {
  if (unit === "rad") return { factor: DEGREE, unit: "°" };
  if (unit === "rad/s" && magnitude >= 0.1 || unit === "m/s" && magnitude >= 0.1) return { factor: 1, unit };
  if (!(magnitude > 0) || !Number.isFinite(magnitude)) return { factor: 1, unit };
  let best = PREFIXES[0];
  for (const prefix of PREFIXES) if (magnitude >= prefix[1] * 0.9999995) best = prefix;
  return { factor: 1 / best[1], unit: best[0] + unit };
}

// A value with its unit in about `digits` digits: "98.861 kN".
function formatQuantity(value, unit, digits = 5) {
  if (value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (Math.abs(value) < RESOLUTION[unit]) value = 0;
  const unitShown = displayUnit(unit, Math.abs(value));
  const scaled = value * unitShown.factor;
  const space = unitShown.unit === "°" ? "" : "\u202f";
  // A long unit leaves space for one digit fewer.
  return formatNumber(scaled, unitShown.unit.length > 5 ? digits - 1 : digits) + space + unitShown.unit;
}

function formatNumber(value, digits) {
  if (value === 0) return "0";
  const magnitude = Math.abs(value);
  if (magnitude < 1e-4 || magnitude >= 1e7) return withMinusSign(value.toExponential(Math.max(digits - 4, 0)).replace("e+", "e"));
  const integerDigits = Math.floor(Math.log10(magnitude)) + 1;
  return withMinusSign(value.toFixed(Math.max(0, Math.min(9, digits - Math.max(integerDigits, 1)))));
}

// The unit of all times on a page, and the number of decimals that distinguishes its samples, down to a nanosecond.
function chooseTimeFormat(end, finest) {
  const [unit, factor, maxDecimals] = end >= 1 ? ["s", 1, 9] : end >= 1e-3 ? ["ms", 1e3, 6] : ["µs", 1e6, 3];
  const decimals = Math.max(0, Math.min(maxDecimals, Math.ceil(-Math.log10(Math.max(finest, 1e-12) * factor)) + 1));
  return { unit, factor, decimals };
}

const formatTime = (time, format, decimals = format.decimals) => withMinusSign((time * format.factor).toFixed(decimals)) + "\u202f" + format.unit;

// A duration with three digits in a suitable unit.
function formatDuration(time) {
  const unitShown = displayUnit("s", time);
  return String(Number((time * unitShown.factor).toPrecision(3))) + "\u202f" + unitShown.unit;
}

// A playback speed: simulation time per second of wall-clock time.
const formatSpeed = (speed) => formatDuration(speed) + " per s";
