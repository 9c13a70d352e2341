// Scales and ticks of the plots.

// Signed logarithmic scale: linear below about `threshold`, logarithmic above.
function logarithmicScale(threshold) {
  return {
    forward: (value) => Math.sign(value) * Math.log10(1 + Math.abs(value) / threshold),
    inverse: (coordinate) => Math.sign(coordinate) * threshold * (10 ** Math.abs(coordinate) - 1),
  };
}

const LINEAR = { forward: (value) => value, inverse: (coordinate) => coordinate };

// The limit of the linear part of the axis: about six decades below the largest value, rounded to a power of ten.
function linearThreshold(size) {
  return 10 ** (Math.ceil(Math.log10(size > 0 && Number.isFinite(size) ? size : 1)) - 6);
}

// About `count` round numbers between two values.
function roundTickValues(from, to, count) {
  const raw = (to - from) / Math.max(count, 1);
  if (!(raw > 0)) return { step: 1, ticks: [] };
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((multiple) => multiple * decade >= raw * 0.999999) * decade;
  const ticks = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + step * 1e-9 && ticks.length < 50; k++) ticks.push(k * step);
  return { step, ticks };
}

// Ticks of a linear axis with their texts. If the values differ only in their last digits, the texts are offsets from
// `base`, which is shown once.
function linearTicks(from, to, count, unit) {
  const unitShown = displayUnit(unit, Math.max(Math.abs(from), Math.abs(to)));
  const { step, ticks } = roundTickValues(from * unitShown.factor, to * unitShown.factor, count);
  let decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const size = Math.max(...ticks.map(Math.abs), 0);
  if (ticks.length > 1 && size / step > 2e4) {
    const base = ticks[ticks.length >> 1];
    const fineUnit = displayUnit(unit === "rad" ? "rad" : unit, (to - from));
    const factor = fineUnit.factor / unitShown.factor;
    const fineDecimals = Math.max(0, Math.ceil(-Math.log10(step * factor) - 1e-9));
    const text = (tick) => {
      const offset = (tick - base) * factor;
      const digits = fineDecimals > 6 ? offset.toExponential(0).replace("e+", "e") : offset.toFixed(fineDecimals);
      return Math.abs(offset) < step * factor / 2 ? "0" : (offset > 0 ? "+" : "") + withMinusSign(digits);
    };
    return {
      unit: fineUnit.unit,
      base: withMinusSign(base.toFixed(Math.min(decimals, 10))) + (unitShown.unit === "°" ? "°" : "\u202f" + unitShown.unit),
      ticks: ticks.map((tick) => ({ value: tick / unitShown.factor, text: text(tick) })),
    };
  }
  decimals = Math.min(decimals, 9);
  const text = (tick) => withMinusSign((Math.abs(tick) < step / 2 ? 0 : tick).toFixed(decimals));
  return { unit: unitShown.unit, base: "", ticks: ticks.map((tick) => ({ value: tick / unitShown.factor, text: text(tick) })) };
}

// Powers of ten on both sides of 0, about `count` of them.
function logarithmicTicks(from, to, threshold, count, unit) {
  const top = Math.floor(Math.log10(Math.max(Math.abs(from), Math.abs(to), threshold)) + 1e-9);
  const low = Math.round(Math.log10(threshold));
  const decades = (top - low + 1) * (from < 0 && to > 0 ? 2 : 1);
  const stride = Math.max(1, Math.ceil(decades / Math.max(count, 2)));
  const ticks = from <= 0 && to >= 0 ? [0] : [];
  for (let exponent = top; exponent >= low; exponent -= stride) {
    for (const sign of [1, -1]) {
      const value = sign * 10 ** exponent;
      if (value >= from && value <= to) ticks.push(value);
    }
  }
  return { unit: "", base: "", ticks: ticks.map((value) => ({ value, text: value === 0 ? "0" : formatQuantity(value, unit, 1) })) };
}

// Ticks of the time axis, in the time unit of the page.
function timeTicks(from, to, count, format) {
  const { step, ticks } = roundTickValues(from * format.factor, to * format.factor, count);
  const decimals = Math.max(0, Math.min(9, Math.ceil(-Math.log10(step) - 1e-9)));
  return ticks.map((tick) => ({ value: tick / format.factor, text: withMinusSign((Math.abs(tick) < step / 2 ? 0 : tick).toFixed(decimals)) }));
}
