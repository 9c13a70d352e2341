// Values → colours, as the pictures have them.

function channels(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

function mixed(stops, part) {
  const place = Math.min(Math.max(part, 0), 1) * (stops.length - 1);
  const below = Math.min(Math.floor(place), stops.length - 2);
  const [a, b] = [channels(stops[below]), channels(stops[below + 1])];
  return a.map((from, c) => Math.round(from + (place - below) * (b[c] - from)));
}

class Scale {
  // From the least to the largest of the values; both ways from zero where the sign counts.
  constructor(colours, quantity, low, high) {
    this.colours = colours;
    this.quantity = quantity;
    if (quantity.flag) [this.from, this.to] = [0, 1];
    else if (!(low <= high)) [this.from, this.to] = [0, 1];
    else if (quantity.signed) {
      const limit = high > 0 ? high : Math.max(Math.abs(low), 1e-30);
      [this.from, this.to] = [-limit, limit];
      this.beyond = low < -limit;
    } else if (low < high) [this.from, this.to] = [low, high];
    else [this.from, this.to] = [low - 0.5 * Math.max(Math.abs(low), 1e-12), high + 0.5 * Math.max(Math.abs(high), 1e-12)];
  }

  colour(value) {
    const { flag, signed } = this.quantity;
    if (flag) return channels(this.colours.flag[value > 0.5 ? 1 : 0]);
    if (signed && value < 0) return mixed(this.colours.negative, 1 - value / this.from);
    if (signed) return mixed(this.colours.positive, value / this.to);
    return mixed(this.colours.sequential, (value - this.from) / (this.to - this.from));
  }
}

// Round values between two, about so many.
function roundTicks(from, to, about) {
  const raw = (to - from) / about;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((m) => m * power >= raw * 0.999) * power;
  const ticks = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to * (1 + 1e-12) + 1e-12 * step; k++) ticks.push(k * step);
  return { ticks, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

// The bar below the volume, with its figures.
function drawBar(canvas, scale) {
  const { ctx, width } = cleared(canvas);
  const { quantity } = scale;
  const [left, right, top, height] = [12, width - 12, 4, 14];
  const wide = right - left;
  if (quantity.flag) return;
  for (let x = 0; x < wide; x++) {
    const value = scale.from + ((x + 0.5) / wide) * (scale.to - scale.from);
    ctx.fillStyle = `rgb(${scale.colour(value).join(",")})`;
    ctx.fillRect(left + x, top, 1.5, height);
  }
  ctx.strokeStyle = colour("soft");
  ctx.lineWidth = 1;
  ctx.strokeRect(left + 0.5, top + 0.5, wide, height);
  const { factor } = quantity;
  const { ticks, decimals } = roundTicks(scale.from * factor, scale.to * factor, Math.max(2, wide / 90));
  ctx.fillStyle = colour("ink");
  ctx.textBaseline = "top";
  const place = (value) => left + ((value / factor - scale.from) / (scale.to - scale.from)) * wide;
  const first = scale.beyond ? minus(`≤ ${(scale.from * factor).toFixed(1)}`) : "";
  if (first) {
    ctx.textAlign = "left";
    ctx.fillText(first, left, top + height + 5);
  }
  const free = first ? left + ctx.measureText(first).width + 14 : 0;
  for (const tick of ticks) {
    const x = place(tick);
    ctx.fillRect(x - 0.5, top + height, 1, 4);
    const text = minus(tick.toFixed(decimals));
    const half = ctx.measureText(text).width / 2;
    if (x - half < free) continue;
    ctx.textAlign = x + half > width ? "right" : x - half < 0 ? "left" : "center";
    ctx.fillText(text, ctx.textAlign === "center" ? x : ctx.textAlign === "right" ? width : 0, top + height + 5);
  }
}
