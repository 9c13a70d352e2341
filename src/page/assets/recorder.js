// What is drawn on a canvas as an SVG: the part of a canvas's context that this page uses.

const SVG_SPACE = "http://www.w3.org/2000/svg";
const marked = (text) => String(text).replace(/[&<>"]/g, (char) => `&#${char.charCodeAt(0)};`);

class SvgContext {
  constructor(name, width, height) {
    this.name = name;
    this.parts = [];
    this.clips = 0;
    this.open = 0;
    this.kept = [];
    this.path = "";
    this.ruler = document.createElement("canvas").getContext("2d");
    Object.assign(this, { width, height, font: FONT, fillStyle: "black", strokeStyle: "black", lineWidth: 1, globalAlpha: 1, textAlign: "left", textBaseline: "alphabetic", dash: [] });
  }

  // Everything, as a group at a place.
  group(x, y) {
    while (this.open > 0) this.close();
    return `<g transform="translate(${x} ${y})">${this.parts.join("\n")}</g>`;
  }

  close() {
    this.parts.push("</g>");
    this.open--;
  }

  save() {
    const { font, fillStyle, strokeStyle, lineWidth, globalAlpha, textAlign, textBaseline, dash, open } = this;
    this.kept.push({ font, fillStyle, strokeStyle, lineWidth, globalAlpha, textAlign, textBaseline, dash, open });
  }

  restore() {
    const { open, ...state } = this.kept.pop();
    while (this.open > open) this.close();
    Object.assign(this, state);
  }

  beginPath() { this.path = ""; }
  closePath() { this.path += "Z"; }
  moveTo(x, y) { this.path += `M${short(x)} ${short(y)}`; }
  lineTo(x, y) { this.path += `${this.path ? "L" : "M"}${short(x)} ${short(y)}`; }
  rect(x, y, w, h) { this.path += `M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}Z`; }

  // Whole circles are all that is drawn.
  arc(x, y, r) {
    this.path += `M${short(x - r)} ${short(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0Z`;
  }

  clip() {
    const id = `${this.name}-${this.clips++}`;
    // Put together here: a page has no address of anything in it.
    this.parts.push(`<clipPath id="${id}"><path d="${this.path}"/></clipPath><g clip-path="${"url"}(#${id})">`);
    this.open++;
  }

  line() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    return `fill="none" stroke="${marked(this.strokeStyle)}" stroke-width="${this.lineWidth}" stroke-linejoin="round"${dash}`;
  }

  get faded() { return this.globalAlpha < 1 ? ` opacity="${this.globalAlpha}"` : ""; }
  setLineDash(dash) { this.dash = dash; }
  stroke() { if (this.path) this.parts.push(`<path d="${this.path}" ${this.line()}${this.faded}/>`); }
  fill() { if (this.path) this.parts.push(`<path d="${this.path}" fill="${marked(this.fillStyle)}"${this.faded}/>`); }
  fillRect(x, y, w, h) { this.parts.push(`<rect x="${short(x)}" y="${short(y)}" width="${short(w)}" height="${short(h)}" fill="${marked(this.fillStyle)}"${this.faded}/>`); }

  text(text, x, y, paint) {
    const anchor = { left: "start", right: "end", center: "middle" }[this.textAlign];
    const middle = this.textBaseline === "middle" ? ' dominant-baseline="central"' : "";
    this.parts.push(`<text x="${short(x)}" y="${short(y)}" text-anchor="${anchor}"${middle} style="font:${marked(this.font)}" ${paint}>${marked(text)}</text>`);
  }

  fillText(text, x, y) { this.text(text, x, y, `fill="${marked(this.fillStyle)}"`); }
  strokeText(text, x, y) { this.text(text, x, y, this.line()); }

  measureText(text) {
    this.ruler.font = this.font;
    return this.ruler.measureText(text);
  }
}

// A hundredth of a pixel is enough.
const short = (value) => Number(value.toFixed(2));

// What a function draws on a canvas.
function recorded(name, canvas, draw) {
  const recorder = new SvgContext(name, canvas.clientWidth, canvas.clientHeight);
  canvas.recorder = recorder;
  try {
    draw();
  } finally {
    delete canvas.recorder;
  }
  return recorder;
}
