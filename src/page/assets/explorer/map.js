// The map: a criterion over two fields, computed progressively; a click adopts the values of a point.

const MAP_MARGIN = { left: 58, right: 12, top: 10, bottom: 40 };

class DesignMap {
  // `settings()` returns the present settings, `fields` are its fields, `figures()` the names and units of the
  // criteria.
  constructor(queue, { settings, fields, figures, onSelect, onChange, isVisible }) {
    Object.assign(this, { queue, settings, fields, figures, onSelect, onChange, isVisible });
    this.canvas = byId("map");
    this.grid = null;
    this.criterion = "";
    this.axes = { x: "", y: "" };
    for (const id of ["x", "y"]) {
      byId(`map-${id}`).addEventListener("change", ({ target }) => {
        this.axes[id] = target.value;
        this.restart();
      });
    }
    byId("map-criterion").addEventListener("change", ({ target }) => {
      this.criterion = target.value;
      this.draw();
      this.onChange();
    });
    this.connectPointers();
  }

  // Updates the choice of axes; retains the selection if possible. Returns whether a map is possible.
  updateAxes() {
    const variables = this.fields.numericFields();
    if (variables.length < 2) return false;
    const paths = variables.map(({ path }) => path);
    if (!paths.includes(this.axes.x)) this.axes.x = paths.find((path) => path !== this.axes.y);
    if (!paths.includes(this.axes.y) || this.axes.y === this.axes.x) this.axes.y = paths.find((path) => path !== this.axes.x);
    const options = variables.map(({ path, name, kind }) => [path, name, kind && sectionTitle(kind)]);
    for (const id of ["x", "y"]) setOptions(byId(`map-${id}`), options, this.axes[id]);
    return true;
  }

  updateCriteria() {
    // In the order of the figures, most important first; a criterion may exist at some points only.
    const names = [...new Set([...this.figures().map(({ key }) => key), ...this.grid.words, ...this.grid.columns])];
    // The first figure of a mechanism is its fate.
    const main = names[0] === "grasp.fate" && this.fields.hasParts() ? names[0] : names.find((name) => name.endsWith("tts_s"));
    if (!names.includes(this.criterion)) this.criterion = main ?? names[0];
    setOptions(byId("map-criterion"), names.map((name) => [name, this.findFigure(name)?.label ?? name.replaceAll("_", " ")]), this.criterion);
  }

  findFigure(name) {
    return this.figures().find(({ key }) => key === name);
  }

  // The settings common to all points: all overrides except those of the axes.
  sharedSettings() {
    const { file, text, set } = this.settings();
    const otherSettings = set.filter(([path]) => path !== this.axes.x && path !== this.axes.y);
    return { key: JSON.stringify([file, text, otherSettings, this.axes]), request: (extra) => ({ ask: "criteria", scene: { file, text }, set: otherSettings, ...extra }) };
  }

  // Recomputes the map if anything except the values of its two axes has changed.
  reload() {
    if (!this.isVisible() || !this.updateAxes()) return;
    const variables = new Map(this.fields.numericFields().map((each) => [each.path, each]));
    const { key, request } = this.sharedSettings();
    const [x, y] = [variables.get(this.axes.x), variables.get(this.axes.y)];
    const ranges = JSON.stringify([x.range, y.range]);
    if (this.grid && !this.grid.stopped && this.grid.key === key && this.grid.ranges === ranges) {
      this.draw();
      return;
    }
    this.grid?.stop();
    const grid = new Grid(this.queue, { request }, x, y, () => grid === this.grid && this.onProgress());
    Object.assign(grid, { key, ranges });
    this.grid = grid;
    this.cursor = null;
    this.updateCriteria();
    this.ready = grid.fill();
    this.draw();
  }

  restart() {
    this.reload();
    this.onChange();
  }

  // Stops the computation if a field that is not an axis has changed.
  invalidate() {
    if (!this.grid || this.grid.key === this.sharedSettings().key) return;
    this.grid.stop();
    this.draw();
  }

  onProgress() {
    this.updateCriteria();
    this.draw();
  }

  // The layout of the map in pixels, and conversions between grid indices and pixels.
  layout() {
    const { clientWidth, clientHeight } = this.canvas;
    const inner = { left: MAP_MARGIN.left, right: clientWidth - MAP_MARGIN.right, top: MAP_MARGIN.top, bottom: clientHeight - MAP_MARGIN.bottom };
    const [mapWidth, mapHeight] = [inner.right - inner.left, inner.bottom - inner.top];
    return {
      inner,
      x: (k) => inner.left + k / GRID_INTERVALS * mapWidth,
      y: (k) => inner.bottom - k / GRID_INTERVALS * mapHeight,
      nodeAt: (px, py) => [(px - inner.left) / mapWidth, (inner.bottom - py) / mapHeight].map((fraction) => Math.min(GRID_INTERVALS, Math.max(0, Math.round(fraction * GRID_INTERVALS)))),
    };
  }

  // The colours of the values, and the data of the legend.
  colouring() {
    const { grid, criterion } = this;
    const presentWords = new Set(grid.values(criterion).filter((value) => typeof value === "string"));
    const words = [...new Set([...resultColours.keys(), ...presentWords])].filter((word) => presentWords.has(word));
    const wordColour = (word) => colour(resultColour(word));
    if (grid.words.has(criterion) && !grid.columns.has(criterion)) return { colour: wordColour, words };
    // Some figures are numbers at most points and a word at others: a margin without a limit is "any".
    let [low, high] = [Infinity, -Infinity];
    for (const value of grid.values(criterion)) {
      if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    const logarithmic = low > 0 && high > 300 * low;
    const scale = (value) => (high > low ? (logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low)) : 0.5);
    return { colour: (value) => (typeof value === "string" ? wordColour(value) : colourAt(scale(value))), words, isScale: true, low, high, logarithmic };
  }

  draw() {
    const { grid, canvas } = this;
    if (!this.isVisible() || canvas.clientWidth === 0) return;
    const { ctx } = clearCanvas(canvas);
    if (!grid) return;
    const layout = this.layout();
    const colouring = this.colouring();
    ctx.globalAlpha = grid.stopped ? 0.25 : 1;
    for (const stride of STRIDES) this.drawCells(ctx, layout, colouring, stride);
    ctx.globalAlpha = 1;
    this.drawAxes(ctx, layout);
    this.drawMarkers(ctx, layout);
    this.updateLegend(colouring);
    const percent = Math.floor(100 * grid.done / grid.total);
    setText("map-state", grid.failed ?? (grid.stopped ? "outdated: another field has changed" : percent < 100 ? `${percent} %` : `${grid.total} closings`));
  }

  // Draws the points as cells of the grid spacing; cells without a value are hatched.
  drawCells(ctx, { x, y }, colouring, stride) {
    const { grid, criterion } = this;
    const half = stride / 2;
    for (let j = 0; j <= GRID_INTERVALS; j += stride) {
      for (let i = 0; i <= GRID_INTERVALS; i += stride) {
        const value = grid.value(criterion, i, j);
        if (value === undefined) continue;
        const [left, right] = [x(Math.max(i - half, 0)), x(Math.min(i + half, GRID_INTERVALS))];
        const [top, bottom] = [y(Math.min(j + half, GRID_INTERVALS)), y(Math.max(j - half, 0))];
        ctx.fillStyle = value === null ? colour("panel") : colouring.colour(value);
        ctx.fillRect(left, top, right - left + 0.5, bottom - top + 0.5);
        if (value !== null) continue;
        ctx.beginPath();
        ctx.moveTo(left, bottom);
        ctx.lineTo(right, top);
        ctx.lineWidth = 0.5;
        ctx.strokeStyle = colour("soft");
        ctx.stroke();
      }
    }
  }

  drawAxes(ctx, { inner, x, y }) {
    const { grid } = this;
    ctx.strokeStyle = colour("line");
    ctx.lineWidth = 1;
    ctx.strokeRect(inner.left + 0.5, inner.top + 0.5, inner.right - inner.left, inner.bottom - inner.top);
    ctx.fillStyle = colour("soft");
    const ticks = ({ range }, count) => {
      const { step, ticks: tickValues } = roundTickValues(range.from, range.to, count);
      const decimals = Math.max(0, Math.min(9, Math.ceil(-Math.log10(step) - 1e-9)));
      return tickValues.map((value) => ({ k: (value - range.from) / (range.to - range.from) * GRID_INTERVALS, text: withMinusSign(value.toFixed(decimals)) }));
    };
    ctx.textBaseline = "top";
    ctx.textAlign = "center";
    for (const tick of ticks(grid.x, (inner.right - inner.left) / 70)) {
      ctx.fillRect(x(tick.k) - 0.5, inner.bottom, 1, 4);
      ctx.fillText(tick.text, Math.min(x(tick.k), inner.right - 4), inner.bottom + 7);
    }
    ctx.textBaseline = "middle";
    ctx.textAlign = "right";
    for (const tick of ticks(grid.y, (inner.bottom - inner.top) / 40)) {
      ctx.fillRect(inner.left - 4, y(tick.k) - 0.5, 4, 1);
      ctx.fillText(tick.text, inner.left - 7, y(tick.k));
    }
    const name = ({ path, range }) => path + (range.unit ? ` (${range.unit})` : "");
    ctx.textAlign = "right";
    ctx.textBaseline = "bottom";
    ctx.fillText(name(grid.x), inner.right, inner.bottom + MAP_MARGIN.bottom - 2);
    ctx.save();
    ctx.translate(12, inner.top);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    ctx.fillText(name(grid.y), 0, 0);
    ctx.restore();
  }

  // Draws the present design and the cursor.
  drawMarkers(ctx, { x, y }) {
    const ring = (i, j, radius, colourName) => {
      for (const [width, stroke] of [[4, "panel"], [2, colourName]]) {
        ctx.beginPath();
        ctx.arc(x(i), y(j), radius, 0, 2 * Math.PI);
        ctx.lineWidth = width;
        ctx.strokeStyle = colour(stroke);
        ctx.stroke();
      }
    };
    const current = [this.grid.x, this.grid.y].map(({ path, range }) => {
      const field = this.fields.rows.get(path)?.field;
      return field?.unit === range.unit ? (field.value - range.from) / (range.to - range.from) * GRID_INTERVALS : NaN;
    });
    if (current.every(Number.isFinite)) ring(current[0], current[1], 6, "ink");
    if (this.cursor) ring(this.cursor[0], this.cursor[1], 4, "accent");
  }

  updateLegend({ colour: colourOf, words, isScale, low, high, logarithmic }) {
    const hasGaps = this.grid.values(this.criterion).filter((value) => !Number.isNaN(value)).length < this.grid.done;
    const legendKey = JSON.stringify([words, low, high, hasGaps, this.criterion, document.documentElement.dataset.theme]);
    if (legendKey === this.legendKey) return;
    this.legendKey = legendKey;
    const holder = byId("map-legend");
    const entry = (ink, text) => {
      const swatch = element("i", ink ? {} : { class: "none" });
      if (ink) swatch.style.background = ink;
      return element("span", { class: "entry" }, swatch, text);
    };
    const gapEntries = hasGaps ? [entry(null, "invalid scene, or no such result")] : [];
    const wordEntries = words.map((word) => entry(colourOf(word), word));
    if (!isScale) {
      holder.replaceChildren(...wordEntries, ...gapEntries);
      return;
    }
    const bar = element("i", { class: "bar" });
    bar.style.background = `linear-gradient(to right, ${COLOUR_SCALE.join(", ")})`;
    const unit = this.findFigure(this.criterion)?.unit ?? "";
    const endTexts = low <= high ? [formatQuantity(low, unit, 3), formatQuantity(high, unit, 3)] : ["–", "–"];
    holder.replaceChildren(element("span", {}, endTexts[0]), bar, element("span", {}, endTexts[1]), ...(logarithmic ? [element("span", { class: "soft" }, "logarithmic")] : []), ...wordEntries, ...gapEntries);
  }

  // Describes a point in words.
  describe([i, j]) {
    const { grid, criterion } = this;
    const value = grid.value(criterion, i, j);
    const figure = this.findFigure(criterion);
    const valueText = value === undefined ? "not computed yet" : typeof value === "string" ? value : value === null ? `none. ${grid.point(i, j).refused ?? "The run has no such result."}` : formatQuantity(value, figure?.unit ?? "", 4);
    return `${grid.x.path} ${grid.textAt(grid.x, i)}, ${grid.y.path} ${grid.textAt(grid.y, j)}: ${figure?.label ?? criterion} ${valueText}`;
  }

  hoverNode(node) {
    this.cursor = node;
    setText("map-description", node ? this.describe(node) : "");
    this.draw();
  }

  selectNode([i, j]) {
    const { grid } = this;
    if (!grid || grid.stopped) return;
    this.onSelect([[grid.x.path, grid.textAt(grid.x, i)], [grid.y.path, grid.textAt(grid.y, j)]]);
  }

  connectPointers() {
    const { canvas } = this;
    const node = (event) => {
      const box = canvas.getBoundingClientRect();
      return this.layout().nodeAt(event.clientX - box.left, event.clientY - box.top);
    };
    canvas.addEventListener("pointermove", (event) => this.grid && this.hoverNode(node(event)));
    canvas.addEventListener("pointerleave", () => this.grid && this.hoverNode(null));
    canvas.addEventListener("click", (event) => this.selectNode(node(event)));
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!this.grid || !step && event.key !== "Enter") return;
      event.preventDefault();
      const [i, j] = this.cursor ?? [GRID_INTERVALS / 2, GRID_INTERVALS / 2];
      if (!step) this.selectNode([i, j]);
      else this.hoverNode([i + step[0] * (event.shiftKey ? 4 : 1), j + step[1] * (event.shiftKey ? 4 : 1)].map((k) => Math.min(GRID_INTERVALS, Math.max(0, k))));
    });
  }
}

// Sets the options of a select element: values, texts and groups, if any. Unchanged options are retained.
function setOptions(select, options, chosen) {
  const optionsKey = JSON.stringify(options);
  if (select.dataset.form !== optionsKey) {
    const groups = new Map();
    select.replaceChildren();
    for (const [value, optionText, group] of options) {
      if (group && !groups.has(group)) {
        groups.set(group, element("optgroup", { label: group }));
        select.append(groups.get(group));
      }
      (groups.get(group) ?? select).append(element("option", { value }, optionText));
    }
    select.dataset.form = optionsKey;
  }
  select.value = chosen;
}
