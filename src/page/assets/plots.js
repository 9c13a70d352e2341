// The plots: curves of both runs over one time axis, with the values at the cursor.

const LEFT = 62;
const RIGHT = 10;
const TOP = 8;
const FOOT = 20;
// Pixels of a curve that are drawn as one straight line.
const PIECE = 1;

class Plots {
  constructor(film, holder, { seek, range, changed }) {
    Object.assign(this, { film, holder, seek, range, changed });
    this.panels = [];
    // Whether a canvas has to be drawn.
    this.wanted = () => true;
    this.renew();
  }

  // Takes the film as it is now. Where it has the same curves, the plots stay as they are, and what was switched stays so.
  renew() {
    const next = panelsOf(this.film);
    const form = JSON.stringify([this.film.runs.map((run) => run.label), next.map(({ title, series }) => [title, series.map(({ name }) => name)])]);
    const before = new Map(this.panels.map((panel) => [panel.title, panel]));
    for (const panel of next) {
      const old = before.get(panel.title);
      if (old) panel.logarithmic = old.logarithmic;
      for (const series of panel.series) series.visible = old?.series.find(({ name }) => name === series.name)?.visible ?? true;
    }
    if (form !== this.form) this.build(next);
    else next.forEach(({ size, series }, k) => {
      const panel = this.panels[k];
      panel.size = size;
      series.forEach(({ runs, rates }, row) => Object.assign(panel.series[row], { runs, rates }));
    });
    this.form = form;
  }

  build(panels) {
    const { holder, seek, changed } = this;
    holder.replaceChildren();
    this.panels = panels.map((panel) => {
      const canvas = element("canvas", { role: "img", "aria-label": `${panel.title} over time` });
      const scale = element("button", { type: "button", "aria-label": `Logarithmic scale: ${panel.title}` });
      const unit = element("span", { class: "soft" });
      const head = element("header", {}, element("h2", {}, panel.title + " ", unit), scale);
      const table = this.table(panel, changed);
      const body = element("div", { class: "body" }, canvas, table.element);
      holder.append(element("section", { class: "plot", "aria-label": panel.title }, head, body));
      const made = { ...panel, canvas, unitText: unit, scaleButton: scale, cells: table.cells };
      scale.addEventListener("click", () => {
        made.logarithmic = !made.logarithmic;
        changed();
      });
      drags(canvas, made, this, seek);
      return made;
    });
  }

  // Rows of series, columns of runs.
  table(panel, changed) {
    const runs = this.film.runs;
    const heads = runs.map((run) => element("th", { scope: "col", title: run.label }, run.label));
    const first = element("th", { scope: "col" }, element("span", { class: "hidden" }, "Series"));
    const head = element("thead", {}, element("tr", {}, first, ...(runs.length > 1 ? heads : [element("th", { scope: "col" }, "at the cursor")])));
    const body = element("tbody");
    const cells = panel.series.map((series) => {
      const mark = element("i");
      mark.style.color = `var(--${seriesColour(series.index)})`;
      const button = element("button", { type: "button", class: "series", "aria-pressed": series.visible, title: series.name }, mark, element("span", {}, series.name));
      button.addEventListener("click", () => {
        series.visible = !series.visible;
        button.setAttribute("aria-pressed", series.visible);
        changed();
      });
      const row = runs.map(() => element("td"));
      body.append(element("tr", {}, element("th", { scope: "row" }, button), ...row));
      return row;
    });
    return { element: element("table", {}, head, body), cells };
  }

  draw(time) {
    for (const panel of this.panels) if (this.wanted(panel.canvas)) this.drawPanel(panel, time);
  }

  // Values at the cursor, as they stand in the tables.
  read(time) {
    const out = this.film.runs.map(() => ({}));
    for (const panel of this.panels) {
      panel.series.forEach((series, row) => {
        series.runs.forEach((values, index) => {
          const run = this.film.runs[index];
          const value = values && run.visible ? valueAt(values, placeAt(run, time), series.rates[index]) : undefined;
          const text = value === undefined ? "–" : withUnit(value, panel.unit);
          if (panel.cells[row][index].textContent !== text) panel.cells[row][index].textContent = text;
          (out[index][panel.title] ??= {})[series.name] = value;
        });
      });
    }
    return out;
  }

  drawPanel(panel, time) {
    const { ctx, width, height } = cleared(panel.canvas);
    const [from, to] = this.range();
    const inner = { left: LEFT, right: width - RIGHT, top: TOP, bottom: height - FOOT };
    const foot = footOf(panel.size);
    // Nothing but zeros has no decades.
    const logarithmic = panel.logarithmic && panel.size > 0;
    const scale = logarithmic ? logarithmicScale(foot) : LINEAR;
    const [low, high] = this.limits(panel, from, to, scale);
    const x = (t) => inner.left + (t - from) / (to - from) * (inner.right - inner.left);
    const y = (value) => inner.bottom - (scale.to(value) - low) / (high - low) * (inner.bottom - inner.top);
    const rows = Math.max(2, Math.round((inner.bottom - inner.top) / 22));
    const ticks = logarithmic
      ? logarithmicTicks(scale.back(low), scale.back(high), foot, rows, panel.unit)
      : linearTicks(low, high, rows, panel.unit);
    panel.place = { x, inner, from, to };
    this.frame(ctx, inner, ticks, x, y, from, to);
    for (const run of this.film.runs) if (run.visible && run.trusted_s < to) hatched(ctx, inner, Math.max(x(run.trusted_s), inner.left));
    const unit = ticks.unit ? `(${ticks.unit})` : "";
    if (panel.unitText.textContent !== unit) panel.unitText.textContent = unit;
    const name = panel.logarithmic ? "logarithmic" : "linear";
    if (panel.scaleButton.textContent !== name) panel.scaleButton.textContent = name;
    panel.scaleButton.setAttribute("aria-pressed", panel.logarithmic);

    ctx.save();
    ctx.beginPath();
    ctx.rect(inner.left, inner.top - 3, inner.right - inner.left, inner.bottom - inner.top + 6);
    ctx.clip();
    const both = this.film.runs.length > 1;
    for (const run of this.film.runs) {
      if (!run.visible) continue;
      for (const series of panel.series) {
        const values = series.runs[run.index];
        if (!series.visible || !values) continue;
        const { width, alpha, dash } = lineOf(run, both);
        ctx.strokeStyle = colour(seriesColour(series.index));
        ctx.lineWidth = width;
        ctx.globalAlpha = alpha;
        ctx.setLineDash(dash);
        curve(ctx, run.time, values, series.rates[run.index], { x, y, from, to: Math.min(to, run.trusted_s ?? Infinity), logarithmic });
        // Runs beside it show how far it might be another one.
        ctx.lineWidth = 1;
        ctx.globalAlpha = 0.4;
        ctx.setLineDash([]);
        for (const other of run.cloud ?? []) {
          const same = other.panels.find(({ title }) => title === panel.title)?.series.find(({ name }) => name === series.name);
          if (same) curve(ctx, other.time, same.values, same.rates, { x, y, from: Math.max(from, run.trusted_s ?? from), to, logarithmic });
        }
        ctx.lineWidth = width;
        ctx.globalAlpha = alpha;
        if (run.trusted_s < to) {
          // What follows is one of many courses: points, no curve.
          ctx.setLineDash([1.5, 4]);
          curve(ctx, run.time, values, series.rates[run.index], { x, y, from: Math.max(from, run.trusted_s), to, logarithmic });
        }
        ctx.globalAlpha = 1;
      }
    }
    ctx.setLineDash([]);
    ctx.restore();
    this.cursor(ctx, panel, inner, x, y, time);
    if (ticks.base) label(ctx, `${ticks.base} +`, inner.left + 4, inner.top + 6, "soft");
  }

  // Lowest and highest place that is needed for what is shown, with some room.
  limits(panel, from, to, scale) {
    let [low, high] = [Infinity, -Infinity];
    const take = (value) => {
      if (!Number.isFinite(value)) return;
      low = Math.min(low, value);
      high = Math.max(high, value);
    };
    for (const run of this.film.runs) {
      if (!run.visible) continue;
      const [a, b] = [placeAt(run, from), placeAt(run, to)];
      for (const series of panel.series) {
        const values = series.runs[run.index];
        if (!series.visible || !values) continue;
        take(valueAt(values, a, series.rates[run.index]));
        for (let i = a.i + 1; i <= b.i; i++) take(values[i]);
        take(valueAt(values, b, series.rates[run.index]));
      }
    }
    if (!(low <= high)) [low, high] = [0, 1];
    [low, high] = [scale.to(low), scale.to(high)];
    const size = Math.max(Math.abs(low), Math.abs(high));
    // What is constant but for its last digits gets an axis of its own size.
    if (size === 0) [low, high] = [-0.2, 1];
    else if (high - low < 1e-9 * size) [low, high] = [low - 0.1 * size, high + 0.1 * size];
    const room = 0.07 * (high - low);
    return [low - room, high + room];
  }

  frame(ctx, inner, ticks, x, y, from, to) {
    ctx.lineWidth = 1;
    ctx.setLineDash([]);
    ctx.fillStyle = colour("soft");
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    const named = [];
    for (const tick of ticks.ticks) {
      const at = Math.round(y(tick.at)) + 0.5;
      if (at < inner.top - 1 || at > inner.bottom + 1) continue;
      ctx.strokeStyle = colour(tick.at === 0 ? "soft" : "faint");
      ctx.globalAlpha = tick.at === 0 ? 0.6 : 1;
      ctx.beginPath();
      ctx.moveTo(inner.left, at);
      ctx.lineTo(inner.right, at);
      ctx.stroke();
      ctx.globalAlpha = 1;
      if (named.some((other) => Math.abs(other - at) < 13)) continue;
      named.push(at);
      ctx.fillText(tick.text, inner.left - 6, at);
    }
    const by = this.film.unit;
    ctx.textBaseline = "alphabetic";
    const count = (inner.right - inner.left) / 90;
    for (const tick of timeTicks(from, to, count, by)) {
      const at = Math.round(x(tick.at)) + 0.5;
      ctx.strokeStyle = colour("faint");
      ctx.beginPath();
      ctx.moveTo(at, inner.top);
      ctx.lineTo(at, inner.bottom);
      ctx.stroke();
      const half = ctx.measureText(tick.text).width / 2;
      ctx.textAlign = "center";
      ctx.fillText(tick.text, Math.min(Math.max(at, half + 22), inner.right + RIGHT - half), inner.bottom + 15);
    }
    ctx.textAlign = "left";
    ctx.fillText(by.unit, 4, inner.bottom + 15);
    for (const event of this.film.events) {
      if (event.time_s < from || event.time_s > to || !event.run.visible) continue;
      const at = x(event.time_s);
      ctx.fillRect(at - 0.5, inner.bottom - 4, 1, 4);
    }
  }

  cursor(ctx, panel, inner, x, y, time) {
    const at = x(time);
    if (at < inner.left - 1 || at > inner.right + 1) return;
    ctx.strokeStyle = colour("accent");
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(at, inner.top);
    ctx.lineTo(at, inner.bottom);
    ctx.stroke();
    for (const run of this.film.runs) {
      if (!run.visible) continue;
      for (const series of panel.series) {
        const values = series.runs[run.index];
        if (!series.visible || !values) continue;
        const value = valueAt(values, placeAt(run, time), series.rates[run.index]);
        if (!Number.isFinite(value)) continue;
        ctx.beginPath();
        ctx.arc(at, y(value), run.index === 0 ? 4 : 2.5, 0, 2 * Math.PI);
        ctx.fillStyle = colour(run.index === 0 ? seriesColour(series.index) : "panel");
        ctx.strokeStyle = colour(run.index === 0 ? "panel" : seriesColour(series.index));
        ctx.fill();
        ctx.stroke();
      }
    }
  }
}

// How the curves of a run are drawn. One that was kept to be compared with is dashed and weak; of two runs side by side the
// first is wide and pale and the second is dashed.
function lineOf(run, both) {
  if (run.kept) return { width: 1.5, alpha: 0.7, dash: [5, 3] };
  if (!both || run.kept === false) return { width: 1.75, alpha: 1, dash: [] };
  return run.index === 0 ? { width: 4.5, alpha: 0.45, dash: [] } : { width: 1.5, alpha: 1, dash: [5, 3] };
}

// Hatches a plot from a place on: what is drawn there is not to be trusted.
function hatched(ctx, { right, top, bottom }, from) {
  if (from >= right) return;
  const high = bottom - top;
  ctx.save();
  ctx.beginPath();
  ctx.rect(from, top, right - from, high);
  ctx.clip();
  ctx.beginPath();
  for (let x = from - high; x < right; x += 9) {
    ctx.moveTo(x, bottom);
    ctx.lineTo(x + high, top);
  }
  ctx.setLineDash([]);
  ctx.lineWidth = 1;
  ctx.globalAlpha = 0.45;
  ctx.strokeStyle = colour("warn");
  ctx.stroke();
  ctx.restore();
}

// Panels of all runs, series of one name together.
function panelsOf(film) {
  const panels = new Map();
  for (const run of film.runs) {
    for (const panel of run.panels) {
      if (!panels.has(panel.title)) panels.set(panel.title, { ...panel, series: [], size: 0 });
      const into = panels.get(panel.title);
      for (const { name, values, rates } of panel.series) {
        let series = into.series.find((each) => each.name === name);
        if (!series) into.series.push(series = { name, visible: true, index: into.series.length, runs: [], rates: [] });
        series.runs[run.index] = values;
        series.rates[run.index] = rates;
        for (const value of values) if (Number.isFinite(value)) into.size = Math.max(into.size, Math.abs(value));
      }
    }
  }
  return [...panels.values()];
}

// A curve within a span of time. Where samples are denser than pixels, each column of pixels gets its first, lowest,
// highest and last value, so that no peak is lost. Where they are farther apart, what lies between them is drawn as it is:
// a straight line on the screen would be another curve on a logarithmic scale, ten times off where a gap closes.
function curve(ctx, times, values, rates, { x, y, from, to, logarithmic }) {
  const straight = !logarithmic && !rates;
  const start = indexAt(times, from);
  const end = Math.min(indexAt(times, to) + 1, times.length - 1);
  ctx.beginPath();
  let pen = false;
  const point = (px, value) => {
    if (pen) ctx.lineTo(px, y(value));
    else ctx.moveTo(px, y(value));
    pen = true;
  };
  const between = (i) => {
    const [first, last] = [Math.max(times[i], from), Math.min(times[i + 1], to)];
    const pieces = straight ? 1 : Math.ceil((x(last) - x(first)) / PIECE);
    const step = times[i + 1] - times[i];
    for (let k = 0; k <= pieces && last > first; k++) {
      const time = first + (last - first) * k / pieces;
      const part = (time - times[i]) / step;
      if (part > 0 && part < 1) point(x(time), valueAt(values, { i, j: i + 1, part, step }, rates));
    }
  };
  let i = start;
  while (i <= end) {
    const px = Math.min(Math.max(x(times[i]), -1e4), 1e5);
    const column = Math.floor(px * 2);
    let [low, high, last] = [values[i], values[i], values[i]];
    let j = i + 1;
    while (j <= end && Math.floor(x(times[j]) * 2) === column) {
      last = values[j];
      if (last < low) low = last;
      if (last > high) high = last;
      j++;
    }
    if (!Number.isFinite(low) || !Number.isFinite(high)) {
      pen = false;
    } else {
      point(px, values[i]);
      if (j - i > 1) [low, high, last].forEach((value) => point(px, value));
      if (j <= end && Number.isFinite(values[j])) between(j - 1);
    }
    i = j;
  }
  ctx.stroke();
}

// Pointers on a plot: one moves the cursor, two zoom; the wheel zooms with ctrl and moves with shift.
function drags(canvas, panel, plots, seek) {
  const pointers = new Map();
  const timeAt = (px) => {
    const { inner, from, to } = panel.place;
    return from + (px - inner.left) / (inner.right - inner.left) * (to - from);
  };
  const inside = (event) => event.clientX - canvas.getBoundingClientRect().left;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, inside(event));
    if (pointers.size === 1) seek(timeAt(inside(event)));
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    if (pointers.size === 2) {
      const before = [...pointers.values()];
      pointers.set(event.pointerId, inside(event));
      const now = [...pointers.values()];
      const [apart, wide] = [Math.abs(before[0] - before[1]), Math.abs(now[0] - now[1])];
      if (apart > 5 && wide > 5) plots.zoomTime(apart / wide, timeAt((now[0] + now[1]) / 2));
    } else {
      pointers.set(event.pointerId, inside(event));
      seek(timeAt(inside(event)));
    }
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    if (event.ctrlKey || event.metaKey) plots.zoomTime(Math.exp(event.deltaY * 0.004), timeAt(inside(event)));
    else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) plots.moveTime((event.deltaX || event.deltaY) / canvas.clientWidth);
    else return;
    event.preventDefault();
  }, { passive: false });
}
