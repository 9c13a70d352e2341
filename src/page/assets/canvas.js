// Canvas utilities: device resolution, colours of the style sheet, polygon clipping, text with an outline.

const FONT = "12px system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";

let colourCache = new Map();

// A colour of the style sheet, by name.
function colour(name) {
  if (!colourCache.has(name)) colourCache.set(name, getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim());
  return colourCache.get(name);
}

const clearColourCache = () => { colourCache = new Map(); };

// Colour name of the curve with an index.
const SERIES_COLOURS = 7;
const seriesColour = (index) => "s" + (index % SERIES_COLOURS);

// Dashes of the curve with an index in a line style: curves of equal colour differ by the number of dots between dashes.
function seriesDash(index, dash) {
  const dots = Math.floor(index / SERIES_COLOURS);
  return dots === 0 ? dash : [...(dash.length > 0 ? dash : [9, 3]), ...Array(dots).fill([2, 3]).flat()];
}

// Clears a canvas; returns its context, scaled to CSS pixels, and its size in CSS pixels.
function clearCanvas(canvas) {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.svgContext) return { ctx: canvas.svgContext, width, height };
  const ratio = window.devicePixelRatio || 1;
  const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const ctx = canvas.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, width, height);
  ctx.font = FONT;
  ctx.lineJoin = "round";
  return { ctx, width, height };
}

// Clips a polygon to a box (Sutherland and Hodgman). Canvas coordinates have 24 bits, but a finger is a million pixels
// long at a zoom to micrometres.
function clipPolygon(points, box) {
  let polygon = points;
  for (const [axis, limit, sign] of [[0, box.left, 1], [0, box.right, -1], [1, box.top, 1], [1, box.bottom, -1]]) {
    const clippedPoints = [];
    for (let i = 0; i < polygon.length; i++) {
      const p = polygon[i];
      const q = polygon[(i + 1) % polygon.length];
      const inP = sign * (p[axis] - limit) >= 0;
      const inQ = sign * (q[axis] - limit) >= 0;
      if (inP) clippedPoints.push(p);
      if (inP !== inQ) {
        const t = (limit - p[axis]) / (q[axis] - p[axis]);
        const cut = [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
        cut[axis] = limit;
        clippedPoints.push(cut);
      }
    }
    polygon = clippedPoints;
    if (polygon.length === 0) break;
  }
  return polygon;
}

// Draws a text with an outline in the background colour, so that it is legible on any background.
function drawLabel(ctx, text, x, y, colourName = "ink", align = "left", baseline = "middle") {
  ctx.textAlign = align;
  ctx.textBaseline = baseline;
  ctx.lineWidth = 4;
  ctx.setLineDash([]);
  ctx.strokeStyle = colour("panel");
  ctx.strokeText(text, x, y);
  ctx.fillStyle = colour(colourName);
  ctx.fillText(text, x, y);
}

// A sample of the line style of a run: the first wide, the second dashed. A run compared with a reference is solid.
function strokeSample({ index, isReference }) {
  const isWide = index === 0 && isReference === undefined;
  return lineSample(26, "ink", { "stroke-width": isWide ? 6 : 2, "stroke-opacity": isWide ? 0.45 : 1, "stroke-dasharray": !isWide && index > 0 ? "5 3" : "none" });
}

// A sample of the colour and dashes of a curve.
const seriesSwatch = (index) => lineSample(20, seriesColour(index), { "stroke-width": 4, "stroke-dasharray": seriesDash(index, []).join(" ") || "none" });

// A horizontal line of 12 pixels height.
function lineSample(width, colourName, style) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", `0 0 ${width} 12`);
  svg.setAttribute("aria-hidden", "true");
  const attributes = { d: `M1 6H${width - 1}`, fill: "none", stroke: `var(--${colourName})`, ...style };
  for (const [name, value] of Object.entries(attributes)) line.setAttribute(name, value);
  svg.append(line);
  return svg;
}

// Creates an element with attributes and children.
function element(name, attributes = {}, ...children) {
  const created = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) created.setAttribute(key, value);
  created.append(...children);
  return created;
}
