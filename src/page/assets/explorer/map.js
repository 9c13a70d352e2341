// The map: a criterion over two variables, which fills in while one waits; a click goes there.

const MAP_ROOM = { left: 58, right: 12, top: 10, bottom: 40 };

class DesignMap {
  // `setting()` is what is simulated, `fields` its variables, `figures()` the names and units of criteria.
  constructor(line, { setting, fields, figures, go, changed, wanted }) {
    Object.assign(this, { line, setting, fields, figures, go, changed, wanted });
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
      this.changed();
    });
    this.pointers();
  }

  // The variables and criteria there are; what was chosen stays where it can.
  choices() {
    const variables = this.fields.numeric();
    if (variables.length < 2) return false;
    const paths = variables.map(({ path }) => path);
    if (!paths.includes(this.axes.x)) this.axes.x = paths.find((path) => path !== this.axes.y);
    if (!paths.includes(this.axes.y) || this.axes.y === this.axes.x) this.axes.y = paths.find((path) => path !== this.axes.x);
    for (const id of ["x", "y"]) options(byId(`map-${id}`), paths.map((path) => [path, calledShort(path)]), this.axes[id]);
    return true;
  }

  criteria() {
    // In the order of the figures, which has the most telling first; a point may lack what others have.
    const names = [...new Set([...this.figures().map(({ key }) => key), ...this.grid.words, ...this.grid.columns])];
    if (!names.includes(this.criterion)) this.criterion = names.find((name) => name.endsWith("tts_s")) ?? names[0];
    options(byId("map-criterion"), names.map((name) => [name, this.figureOf(name)?.label ?? name.replaceAll("_", " ")]), this.criterion);
  }

  figureOf(name) {
    return this.figures().find(({ key }) => key === name);
  }

  // What all points share: all that is set but the two axes.
  shared() {
    const { file, text, set } = this.setting();
    const rest = set.filter(([path]) => path !== this.axes.x && path !== this.axes.y);
    return { key: JSON.stringify([file, text, rest, this.axes]), request: (more) => ({ ask: "criteria", scene: { file, text }, set: rest, ...more }) };
  }

  // Computes the map anew if anything but its two variables has changed.
  renew() {
    if (!this.wanted() || !this.choices()) return;
    const variables = new Map(this.fields.numeric().map((each) => [each.path, each]));
    const { key, request } = this.shared();
    const [x, y] = [variables.get(this.axes.x), variables.get(this.axes.y)];
    const ranges = JSON.stringify([x.range, y.range]);
    if (this.grid && !this.grid.stopped && this.grid.key === key && this.grid.ranges === ranges) {
      this.draw();
      return;
    }
    this.grid?.stop();
    const grid = new Grid(this.line, { request }, x, y, () => grid === this.grid && this.filled());
    Object.assign(grid, { key, ranges });
    this.grid = grid;
    this.cross = null;
    this.criteria();
    this.ready = grid.fill();
    this.draw();
  }

  restart() {
    this.renew();
    this.changed();
  }

  // Another variable moves: what is there is of another scene.
  drop() {
    if (!this.grid || this.grid.key === this.shared().key) return;
    this.grid.stop();
    this.draw();
  }

  filled() {
    this.criteria();
    this.draw();
  }

  // Where the pixels of the map are.
  place() {
    const { clientWidth, clientHeight } = this.canvas;
    const inner = { left: MAP_ROOM.left, right: clientWidth - MAP_ROOM.right, top: MAP_ROOM.top, bottom: clientHeight - MAP_ROOM.bottom };
    const [wide, high] = [inner.right - inner.left, inner.bottom - inner.top];
    return {
      inner,
      x: (k) => inner.left + k / FINEST * wide,
      y: (k) => inner.bottom - k / FINEST * high,
      node: (px, py) => [(px - inner.left) / wide, (inner.bottom - py) / high].map((part) => Math.min(FINEST, Math.max(0, Math.round(part * FINEST)))),
    };
  }

  // What the values look like: a colour for each, and the legend.
  paint() {
    const { grid, criterion } = this;
    if (grid.words.has(criterion)) {
      const seen = new Set(grid.values(criterion));
      return { colour: (word) => colour(inkOf(word)), words: [...new Set([...inks.keys(), ...seen])].filter((word) => seen.has(word)) };
    }
    let [low, high] = [Infinity, -Infinity];
    for (const value of grid.values(criterion)) {
      if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    const logarithmic = low > 0 && high > 300 * low;
    const scale = (value) => (high > low ? (logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low)) : 0.5);
    return { colour: (value) => scaleColour(scale(value)), low, high, logarithmic };
  }

  draw() {
    const { grid, canvas } = this;
    if (!this.wanted() || canvas.clientWidth === 0) return;
    const { ctx } = cleared(canvas);
    if (!grid) return;
    const place = this.place();
    const paint = this.paint();
    ctx.globalAlpha = grid.stopped ? 0.25 : 1;
    for (const stride of STRIDES) this.cells(ctx, place, paint, stride);
    ctx.globalAlpha = 1;
    this.frame(ctx, place);
    this.here(ctx, place);
    this.legend(paint);
    const share = Math.floor(100 * grid.done / grid.total);
    put("map-state", grid.failed ?? (grid.stopped ? "another variable has changed" : share < 100 ? `${share} %` : `${grid.total} closings`));
  }

  // Points as cells as wide as their neighbours are apart; what has no value is hatched.
  cells(ctx, { x, y }, paint, stride) {
    const { grid, criterion } = this;
    const half = stride / 2;
    for (let j = 0; j <= FINEST; j += stride) {
      for (let i = 0; i <= FINEST; i += stride) {
        const value = grid.value(criterion, i, j);
        if (value === undefined) continue;
        const [left, right] = [x(Math.max(i - half, 0)), x(Math.min(i + half, FINEST))];
        const [top, bottom] = [y(Math.min(j + half, FINEST)), y(Math.max(j - half, 0))];
        ctx.fillStyle = value === null ? colour("panel") : paint.colour(value);
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

  frame(ctx, { inner, x, y }) {
    const { grid } = this;
    ctx.strokeStyle = colour("line");
    ctx.lineWidth = 1;
    ctx.strokeRect(inner.left + 0.5, inner.top + 0.5, inner.right - inner.left, inner.bottom - inner.top);
    ctx.fillStyle = colour("soft");
    const ticks = ({ range }, count) => {
      const { step, ticks: at } = roundTicks(range.from, range.to, count);
      const decimals = Math.max(0, Math.min(9, Math.ceil(-Math.log10(step) - 1e-9)));
      return at.map((value) => ({ k: (value - range.from) / (range.to - range.from) * FINEST, text: minus(value.toFixed(decimals)) }));
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
    ctx.fillText(name(grid.x), inner.right, inner.bottom + MAP_ROOM.bottom - 2);
    ctx.save();
    ctx.translate(12, inner.top);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    ctx.fillText(name(grid.y), 0, 0);
    ctx.restore();
  }

  // Where the design is, and the point a key or a pointer is at.
  here(ctx, { x, y }) {
    const ring = (i, j, radius, ink) => {
      for (const [width, stroke] of [[4, "panel"], [2, ink]]) {
        ctx.beginPath();
        ctx.arc(x(i), y(j), radius, 0, 2 * Math.PI);
        ctx.lineWidth = width;
        ctx.strokeStyle = colour(stroke);
        ctx.stroke();
      }
    };
    const now = [this.grid.x, this.grid.y].map(({ path, range }) => {
      const field = this.fields.rows.get(path)?.field;
      return field?.unit === range.unit ? (field.value - range.from) / (range.to - range.from) * FINEST : NaN;
    });
    if (now.every(Number.isFinite)) ring(now[0], now[1], 6, "ink");
    if (this.cross) ring(this.cross[0], this.cross[1], 4, "accent");
  }

  legend({ colour: of, words, low, high, logarithmic }) {
    const lacks = this.grid.values(this.criterion).filter((value) => !Number.isNaN(value)).length < this.grid.done;
    const form = JSON.stringify([words, low, high, lacks, this.criterion, document.documentElement.dataset.theme]);
    if (form === this.legendForm) return;
    this.legendForm = form;
    const holder = byId("map-legend");
    const entry = (ink, said) => {
      const mark = element("i", ink ? {} : { class: "none" });
      if (ink) mark.style.background = ink;
      return element("span", { class: "entry" }, mark, said);
    };
    const hatched = lacks ? [entry(null, "no valid scene, or the run has no such figure")] : [];
    if (words) {
      holder.replaceChildren(...words.map((word) => entry(of(word), word)), ...hatched);
      return;
    }
    const bar = element("i", { class: "bar" });
    bar.style.background = `linear-gradient(to right, ${SCALE.join(", ")})`;
    const unit = this.figureOf(this.criterion)?.unit ?? "";
    const ends = low <= high ? [withUnit(low, unit, 3), withUnit(high, unit, 3)] : ["–", "–"];
    holder.replaceChildren(element("span", {}, ends[0]), bar, element("span", {}, ends[1]), ...(logarithmic ? [element("span", { class: "soft" }, "logarithmic")] : []), ...hatched);
  }

  // What is at a point, in words.
  said([i, j]) {
    const { grid, criterion } = this;
    const value = grid.value(criterion, i, j);
    const figure = this.figureOf(criterion);
    const found = value === undefined ? "not computed yet" : typeof value === "string" ? value : value === null ? `none. ${grid.point(i, j).refused ?? "The run has no such figure."}` : withUnit(value, figure?.unit ?? "", 4);
    return `${grid.x.path} ${grid.textAt(grid.x, i)}, ${grid.y.path} ${grid.textAt(grid.y, j)}: ${figure?.label ?? criterion} ${found}`;
  }

  pointAt(node) {
    this.cross = node;
    put("map-said", node ? this.said(node) : "");
    this.draw();
  }

  take([i, j]) {
    const { grid } = this;
    if (!grid || grid.stopped) return;
    this.go([[grid.x.path, grid.textAt(grid.x, i)], [grid.y.path, grid.textAt(grid.y, j)]]);
  }

  pointers() {
    const { canvas } = this;
    const node = (event) => {
      const box = canvas.getBoundingClientRect();
      return this.place().node(event.clientX - box.left, event.clientY - box.top);
    };
    canvas.addEventListener("pointermove", (event) => this.grid && this.pointAt(node(event)));
    canvas.addEventListener("pointerleave", () => this.grid && this.pointAt(null));
    canvas.addEventListener("click", (event) => this.take(node(event)));
    canvas.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (!this.grid || !by && event.key !== "Enter") return;
      event.preventDefault();
      const [i, j] = this.cross ?? [FINEST / 2, FINEST / 2];
      if (!by) this.take([i, j]);
      else this.pointAt([i + by[0] * (event.shiftKey ? 4 : 1), j + by[1] * (event.shiftKey ? 4 : 1)].map((k) => Math.min(FINEST, Math.max(0, k))));
    });
  }
}

// Fills a list of choices; what is there already stays.
function options(select, pairs, chosen) {
  const form = JSON.stringify(pairs);
  if (select.dataset.form !== form) {
    select.replaceChildren(...pairs.map(([value, words]) => element("option", { value }, words)));
    select.dataset.form = form;
  }
  select.value = chosen;
}
