// Scales and ticks of the plots.

// Linear about 0 up to about `foot`, logarithmic beyond; keeps signs.
function logarithmicScale(foot) {
  return {
    to: (value) => Math.sign(value) * Math.log10(1 + Math.abs(value) / foot),
    back: (place) => Math.sign(place) * foot * (10 ** Math.abs(place) - 1),
  };
}

const LINEAR = { to: (value) => value, back: (place) => place };

// Six decades below the largest size, on a whole power of ten.
function footOf(size) {
  return 10 ** (Math.ceil(Math.log10(size > 0 && Number.isFinite(size) ? size : 1)) - 6);
}

// Round numbers between two values, about `count` of them.
function roundTicks(from, to, count) {
  const raw = (to - from) / Math.max(count, 1);
  if (!(raw > 0)) return { step: 1, ticks: [] };
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((each) => each * power >= raw * 0.999999) * power;
  const ticks = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + step * 1e-9 && ticks.length < 50; k++) ticks.push(k * step);
  return { step, ticks };
}

// Ticks of a linear axis with their texts. Where the values differ only in their last digits, the texts count from a
// value that is given once (`base`).
function linearTicks(from, to, count, unit) {
  const shown = shownUnit(unit, Math.max(Math.abs(from), Math.abs(to)));
  const { step, ticks } = roundTicks(from * shown.factor, to * shown.factor, count);
  let decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const size = Math.max(...ticks.map(Math.abs), 0);
  if (ticks.length > 1 && size / step > 2e4) {
    const base = ticks[ticks.length >> 1];
    const fine = shownUnit(unit === "rad" ? "rad" : unit, (to - from));
    const factor = fine.factor / shown.factor;
    const fineDecimals = Math.max(0, Math.ceil(-Math.log10(step * factor) - 1e-9));
    const text = (tick) => {
      const off = (tick - base) * factor;
      const digits = fineDecimals > 6 ? off.toExponential(0).replace("e+", "e") : off.toFixed(fineDecimals);
      return Math.abs(off) < step * factor / 2 ? "0" : (off > 0 ? "+" : "") + minus(digits);
    };
    return {
      unit: fine.unit,
      base: minus(base.toFixed(Math.min(decimals, 10))) + (shown.unit === "°" ? "°" : "\u202f" + shown.unit),
      ticks: ticks.map((tick) => ({ at: tick / shown.factor, text: text(tick) })),
    };
  }
  decimals = Math.min(decimals, 9);
  const text = (tick) => minus((Math.abs(tick) < step / 2 ? 0 : tick).toFixed(decimals));
  return { unit: shown.unit, base: "", ticks: ticks.map((tick) => ({ at: tick / shown.factor, text: text(tick) })) };
}

// Powers of ten on both sides of 0, as many as have room.
function logarithmicTicks(from, to, foot, count, unit) {
  const top = Math.floor(Math.log10(Math.max(Math.abs(from), Math.abs(to), foot)) + 1e-9);
  const low = Math.round(Math.log10(foot));
  const decades = (top - low + 1) * (from < 0 && to > 0 ? 2 : 1);
  const stride = Math.max(1, Math.ceil(decades / Math.max(count, 2)));
  const ticks = from <= 0 && to >= 0 ? [0] : [];
  for (let exponent = top; exponent >= low; exponent -= stride) {
    for (const sign of [1, -1]) {
      const value = sign * 10 ** exponent;
      if (value >= from && value <= to) ticks.push(value);
    }
  }
  return { unit: "", base: "", ticks: ticks.map((at) => ({ at, text: at === 0 ? "0" : withUnit(at, unit, 1) })) };
}

// Ticks of the time axis, all in the unit of the page.
function timeTicks(from, to, count, by) {
  const { step, ticks } = roundTicks(from * by.factor, to * by.factor, count);
  const decimals = Math.max(0, Math.min(9, Math.ceil(-Math.log10(step) - 1e-9)));
  return ticks.map((tick) => ({ at: tick / by.factor, text: minus((Math.abs(tick) < step / 2 ? 0 : tick).toFixed(decimals)) }));
}
