// Colour scales, equal to those of the pictures.

function parseHex(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

function interpolateColour(stops, fraction) {
  const position = Math.min(Math.max(fraction, 0), 1) * (stops.length - 1);
  const lowerIndex = Math.min(Math.floor(position), stops.length - 2);
  const [a, b] = [parseHex(stops[lowerIndex]), parseHex(stops[lowerIndex + 1])];
  return a.map((from, c) => Math.round(from + (position - lowerIndex) * (b[c] - from)));
}

class Scale {
  // Spans the values; symmetric about zero for signed quantities.
  constructor(colours, quantity, low, high) {
    this.colours = colours;
    this.quantity = quantity;
    if (quantity.flag) [this.from, this.to] = [0, 1];
    else if (!(low <= high)) [this.from, this.to] = [0, 1];
    else if (quantity.signed) {
      const limit = high > 0 ? high : Math.max(Math.abs(low), 1e-30);
      [this.from, this.to] = [-limit, limit];
      this.clipsBelow = low < -limit;
    } else if (low < high) [this.from, this.to] = [low, high];
    else [this.from, this.to] = [low - 0.5 * Math.max(Math.abs(low), 1e-12), high + 0.5 * Math.max(Math.abs(high), 1e-12)];
  }

  colour(value) {
    const { flag, signed } = this.quantity;
    if (flag) return parseHex(this.colours.flag[value > 0.5 ? 1 : 0]);
    if (signed && value < 0) return interpolateColour(this.colours.negative, 1 - value / this.from);
    if (signed) return interpolateColour(this.colours.positive, value / this.to);
    return interpolateColour(this.colours.sequential, (value - this.from) / (this.to - this.from));
  }
}

// About `count` round values between two values.
function roundTickValues(from, to, count) {
  const raw = (to - from) / count;
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((multiple) => multiple * decade >= raw * 0.999) * decade;
  const ticks = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to * (1 + 1e-12) + 1e-12 * step; k++) ticks.push(k * step);
  return { ticks, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

// Draws the colour bar with its values.
function drawColourBar(canvas, scale) {
  const { ctx, width } = clearCanvas(canvas);
  const { quantity } = scale;
  const [left, right, top, height] = [12, width - 12, 4, 14];
  const barWidth = right - left;
  if (quantity.flag) return;
  for (let x = 0; x < barWidth; x++) {
    const value = scale.from + ((x + 0.5) / barWidth) * (scale.to - scale.from);
    ctx.fillStyle = `rgb(${scale.colour(value).join(",")})`;
    ctx.fillRect(left + x, top, 1.5, height);
  }
  ctx.strokeStyle = colour("soft");
  ctx.lineWidth = 1;
  ctx.strokeRect(left + 0.5, top + 0.5, barWidth, height);
  const { factor } = quantity;
  const { ticks, decimals } = roundTickValues(scale.from * factor, scale.to * factor, Math.max(2, barWidth / 90));
  ctx.fillStyle = colour("ink");
  ctx.textBaseline = "top";
  const position = (value) => left + ((value / factor - scale.from) / (scale.to - scale.from)) * barWidth;
  const clippedText = scale.clipsBelow ? withMinusSign(`≤ ${(scale.from * factor).toFixed(1)}`) : "";
  if (clippedText) {
    ctx.textAlign = "left";
    ctx.fillText(clippedText, left, top + height + 5);
  }
  const textStart = clippedText ? left + ctx.measureText(clippedText).width + 14 : 0;
  for (const tick of ticks) {
    const x = position(tick);
    ctx.fillRect(x - 0.5, top + height, 1, 4);
    const text = withMinusSign(tick.toFixed(decimals));
    const halfWidth = ctx.measureText(text).width / 2;
    if (x - halfWidth < textStart) continue;
    ctx.textAlign = x + halfWidth > width ? "right" : x - halfWidth < 0 ? "left" : "center";
    ctx.fillText(text, ctx.textAlign === "center" ? x : ctx.textAlign === "right" ? width : 0, top + height + 5);
  }
}
