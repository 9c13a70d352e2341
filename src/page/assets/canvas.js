// Canvases as sharp as the screen, colours of the scheme, and lines cut off at the edge of the view.

const FONT = "12px system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";

let colours = new Map();

// A colour of the style sheet by its name.
function colour(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim());
  return colours.get(name);
}

const forgetColours = () => { colours = new Map(); };

// Colour of the curve with an index.
const seriesColour = (index) => "s" + (index % 7);

// A context in CSS pixels on an empty canvas, and the canvas's size in them.
function cleared(canvas) {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.recorder) return { ctx: canvas.recorder, width, height };
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

// The part of a polygon within a box (Sutherland and Hodgman). A canvas has 24 bits for a coordinate, and zoomed to
// micrometres a finger is a million pixels long: what is far outside must not reach it.
function clipped(points, box) {
  let from = points;
  for (const [axis, limit, sign] of [[0, box.left, 1], [0, box.right, -1], [1, box.top, 1], [1, box.bottom, -1]]) {
    const out = [];
    for (let i = 0; i < from.length; i++) {
      const p = from[i];
      const q = from[(i + 1) % from.length];
      const inP = sign * (p[axis] - limit) >= 0;
      const inQ = sign * (q[axis] - limit) >= 0;
      if (inP) out.push(p);
      if (inP !== inQ) {
        const t = (limit - p[axis]) / (q[axis] - p[axis]);
        const cut = [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
        cut[axis] = limit;
        out.push(cut);
      }
    }
    from = out;
    if (from.length === 0) break;
  }
  return from;
}

// A text with a rim of the ground's colour, so that it is read over anything.
function label(ctx, text, x, y, ink = "ink", align = "left", baseline = "middle") {
  ctx.textAlign = align;
  ctx.textBaseline = baseline;
  ctx.lineWidth = 4;
  ctx.setLineDash([]);
  ctx.strokeStyle = colour("panel");
  ctx.strokeText(text, x, y);
  ctx.fillStyle = colour(ink);
  ctx.fillText(text, x, y);
}

// A small sample of how a run is drawn: the first solid and wide, the second dashed; one that is held against what was kept, solid.
function strokeSample({ index, kept }, name = "ink") {
  const wide = index === 0 && kept === undefined;
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", "0 0 26 12");
  svg.setAttribute("aria-hidden", "true");
  line.setAttribute("d", "M1 6H25");
  line.setAttribute("fill", "none");
  line.setAttribute("stroke", `var(--${name})`);
  line.setAttribute("stroke-width", wide ? "6" : "2");
  if (wide) line.setAttribute("stroke-opacity", "0.45");
  else if (index > 0) line.setAttribute("stroke-dasharray", "5 3");
  svg.append(line);
  return svg;
}

// A new element with attributes and children.
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
