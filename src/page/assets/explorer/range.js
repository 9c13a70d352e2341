// Where a slider goes from and to, and what it stands on.

const STEPS = 200;
const ANGLES = new Map([["deg", 30], ["rad", Math.PI / 6]]);
// A slider of what is 0 goes so far, by its unit: to both sides of what has a direction.
const FROM_ZERO = new Map([["mm", 10], ["m", 0.01], ["ms", 10], ["s", 0.01], ["g", 100], ["kg", 0.1], ["kg*m^2", 1e-5], ["N", 10], ["N*m", 0.5], ["N*mm", 100]]);
const DIRECTED = new Set(["mm", "m", "m/s", "mm/s", "rad/s", "deg/s", "m/s^2"]);

const isNumeric = (field) => ["quantity", "number", "integer"].includes(field.kind) && Number.isFinite(field.value);

// The span of a field's slider round a value: all that is allowed where that is not much more than the value, else from half
// of it to twice as much.
function rangeOf(field, about = field.value) {
  const low = field.low ?? -Infinity;
  const high = field.high ?? Infinity;
  let [from, to] = [low, high];
  const natural = Number.isFinite(high - low) && (about === 0 || high - low <= 8 * Math.abs(about));
  if (!natural) {
    const angle = ANGLES.get(field.unit);
    const size = FROM_ZERO.get(field.unit) ?? (field.kind === "integer" ? 10 : 1);
    if (angle) [from, to] = [about - angle, about + angle];
    else if (about === 0) [from, to] = [DIRECTED.has(field.unit) ? -size : 0, size];
    else [from, to] = about > 0 ? [about / 2, about * 2] : [about * 2, about / 2];
  }
  [from, to] = [Math.max(from, low), Math.min(to, high)];
  if (!(from < to)) [from, to] = [about, about + (Math.abs(about) || 1)];
  let step = niceStep((to - from) / STEPS);
  if (field.kind === "integer") [from, to, step] = [Math.floor(from), Math.ceil(to), Math.max(1, Math.round(step))];
  return { unit: field.unit, from, to, step };
}

// The largest round number that is not larger.
function niceStep(size) {
  const power = 10 ** Math.floor(Math.log10(size) + 1e-9);
  return [5, 2, 1].find((each) => each * power <= size * (1 + 1e-9)) * power;
}

// A place of a slider as a number a person would have written.
function rounded({ from, to, step }, value) {
  const decimals = Math.max(0, Math.min(15, Math.ceil(-Math.log10(step) - 1e-9)));
  const near = Number((Math.round(value / step) * step).toFixed(decimals));
  return Math.min(Math.max(near, from), to);
}

// A number of a field as a scene file has it.
const asText = (value, unit) => (unit ? `${value} ${unit}` : String(value));
