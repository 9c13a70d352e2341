// Ranges and steps of sliders.

const SLIDER_STEPS = 200;
const ANGLE_HALF_RANGES = new Map([["deg", 30], ["rad", Math.PI / 6]]);
// Range of a slider for the value 0, by unit; symmetric for signed quantities.
const ZERO_RANGES = new Map([["mm", 10], ["m", 0.01], ["ms", 10], ["s", 0.01], ["g", 100], ["kg", 0.1], ["kg*m^2", 1e-5], ["N", 10], ["N*m", 0.5], ["N*mm", 100]]);
const SIGNED_UNITS = new Set(["mm", "m", "m/s", "mm/s", "rad/s", "deg/s", "m/s^2"]);

const isNumeric = (field) => ["quantity", "number", "integer"].includes(field.kind) && Number.isFinite(field.value);

// The range of a slider around a value: the limits of the field if they are not much wider than the value, otherwise
// from half to twice the value.
function sliderRange(field, centre = field.value) {
  const low = field.low ?? -Infinity;
  const high = field.high ?? Infinity;
  let [from, to] = [low, high];
  const usesLimits = Number.isFinite(high - low) && (centre === 0 || high - low <= 8 * Math.abs(centre));
  if (!usesLimits) {
    const halfRange = ANGLE_HALF_RANGES.get(field.unit);
    const size = ZERO_RANGES.get(field.unit) ?? (field.kind === "integer" ? 10 : 1);
    if (halfRange) [from, to] = [centre - halfRange, centre + halfRange];
    else if (centre === 0) [from, to] = [SIGNED_UNITS.has(field.unit) ? -size : 0, size];
    else [from, to] = centre > 0 ? [centre / 2, centre * 2] : [centre * 2, centre / 2];
  }
  [from, to] = [Math.max(from, low), Math.min(to, high)];
  if (!(from < to)) [from, to] = [centre, centre + (Math.abs(centre) || 1)];
  let step = niceStep((to - from) / SLIDER_STEPS);
  if (field.kind === "integer") [from, to, step] = [Math.floor(from), Math.ceil(to), Math.max(1, Math.round(step))];
  return { unit: field.unit, from, to, step };
}

// The largest round number that does not exceed `size`.
function niceStep(size) {
  const decade = 10 ** Math.floor(Math.log10(size) + 1e-9);
  return [5, 2, 1].find((multiple) => multiple * decade <= size * (1 + 1e-9)) * decade;
}

// Rounds a slider value to its step.
function roundToStep({ from, to, step }, value) {
  const decimals = Math.max(0, Math.min(15, Math.ceil(-Math.log10(step) - 1e-9)));
  const nearest = Number((Math.round(value / step) * step).toFixed(decimals));
  return Math.min(Math.max(nearest, from), to);
}

// Formats a value as in a scene file.
const formatValue = (value, unit) => (unit ? `${value} ${unit}` : String(value));
