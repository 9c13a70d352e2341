// The plots: curves of all runs over a common time axis, with the values at the cursor.

const MARGIN_LEFT = 62;
const MARGIN_RIGHT = 10;
const MARGIN_TOP = 8;
const MARGIN_BOTTOM = 20;
// Length of the straight segments of a curve, px.
const SEGMENT_PX = 1;

class Plots {
  constructor(playback, container, { seek, range, requestRedraw }) {
    Object.assign(this, { playback, container, seek, range, requestRedraw });
    this.panels = [];
    // Whether a canvas must be drawn.
    this.needsDrawing = () => true;
    this.reload();
  }

  // Adopts the present playback. Scales and hidden series are retained, and so are the elements if the curves are the
  // same.
  reload() {
    const newPanels = mergePanels(this.playback);
    const layoutKey = JSON.stringify([this.playback.runs.map((run) => run.label), newPanels.map(({ title, series }) => [title, series.map(({ name }) => name)])]);
    const panelsByTitle = new Map(this.panels.map((panel) => [panel.title, panel]));
    for (const panel of newPanels) {
      const previousPanel = panelsByTitle.get(panel.title);
      if (previousPanel) panel.logarithmic = previousPanel.logarithmic;
      for (const series of panel.series) series.visible = previousPanel?.series.find(({ name }) => name === series.name)?.visible ?? true;
    }
    if (layoutKey !== this.layoutKey) this.build(newPanels);
    else newPanels.forEach(({ size, series }, k) => {
      const panel = this.panels[k];
      panel.size = size;
      series.forEach(({ runs, rates }, row) => Object.assign(panel.series[row], { runs, rates }));
    });
    this.layoutKey = layoutKey;
  }

  build(panels) {
    const { container, seek, requestRedraw } = this;
    container.replaceChildren();
    this.panels = panels.map((panel) => {
      const canvas = element("canvas", { role: "img", "aria-label": `${panel.title} over time` });
      const scale = element("button", { type: "button", "aria-label": `Logarithmic scale: ${panel.title}` });
      const unit = element("span", { class: "soft" });
      const head = element("header", {}, element("h2", {}, panel.title + " ", unit), scale);
      const table = this.createTable(panel, requestRedraw);
      const body = element("div", { class: "body" }, canvas, table.element);
      container.append(element("section", { class: "plot", "aria-label": panel.title }, head, body));
      const created = { ...panel, canvas, unitText: unit, scaleButton: scale, cells: table.cells };
      scale.addEventListener("click", () => {
        created.logarithmic = !created.logarithmic;
        requestRedraw();
      });
      connectPlot(canvas, created, this, seek);
      return created;
    });
  }

  // A table with one row per series and one column per run.
  createTable(panel, requestRedraw) {
    const runs = this.playback.runs;
    const runHeads = runs.map((run) => element("th", { scope: "col", title: run.label }, run.label));
    const first = element("th", { scope: "col" }, element("span", { class: "hidden" }, "Series"));
    const head = element("thead", {}, element("tr", {}, first, ...(runs.length > 1 ? runHeads : [element("th", { scope: "col" }, "at the cursor")])));
    const body = element("tbody");
    const cells = panel.series.map((series) => {
      // Long names break at spaces, else after an underscore.
      const name = series.name.match(/[^_]*_*/g).flatMap((part) => [part, element("wbr")]);
      const button = element("button", { type: "button", class: "series", "aria-pressed": series.visible, title: series.name }, seriesSwatch(series.index), element("span", {}, ...name));
      button.addEventListener("click", () => {
        series.visible = !series.visible;
        button.setAttribute("aria-pressed", series.visible);
        requestRedraw();
      });
      const row = runs.map(() => element("td"));
      body.append(element("tr", {}, element("th", { scope: "row" }, button), ...row));
      return row;
    });
    return { element: element("table", {}, head, body), cells };
  }

  draw(time) {
    for (const panel of this.panels) if (this.needsDrawing(panel.canvas)) this.drawPanel(panel, time);
  }

  // Writes the values at the cursor to the tables; returns them.
  updateReadings(time) {
    const readings = this.playback.runs.map(() => ({}));
    for (const panel of this.panels) {
      panel.series.forEach((series, row) => {
        series.runs.forEach((values, index) => {
          const run = this.playback.runs[index];
          const value = values && run.visible ? interpolate(values, locateSample(run, time), series.rates[index]) : undefined;
          const text = value === undefined ? "–" : formatQuantity(value, panel.unit);
          if (panel.cells[row][index].textContent !== text) panel.cells[row][index].textContent = text;
          (readings[index][panel.title] ??= {})[series.name] = value;
        });
      });
    }
    return readings;
  }

  drawPanel(panel, time) {
    const { ctx, width, height } = clearCanvas(panel.canvas);
    const [from, to] = this.range();
    const inner = { left: MARGIN_LEFT, right: width - MARGIN_RIGHT, top: MARGIN_TOP, bottom: height - MARGIN_BOTTOM };
    const threshold = linearThreshold(panel.size);
    // A plot of zeros has no decades.
    const logarithmic = panel.logarithmic && panel.size > 0;
    const scale = logarithmic ? logarithmicScale(threshold) : LINEAR;
    const [low, high] = this.valueRange(panel, from, to, scale);
    const x = (t) => inner.left + (t - from) / (to - from) * (inner.right - inner.left);
    const y = (value) => inner.bottom - (scale.forward(value) - low) / (high - low) * (inner.bottom - inner.top);
    const rows = Math.max(2, Math.round((inner.bottom - inner.top) / 22));
    const ticks = logarithmic
      ? logarithmicTicks(scale.inverse(low), scale.inverse(high), threshold, rows, panel.unit)
      : linearTicks(low, high, rows, panel.unit);
    panel.layout = { x, inner, from, to };
    this.drawFrame(ctx, inner, ticks, x, y, from, to);
    for (const run of this.playback.runs) if (run.visible && run.trusted_s < to) hatchUntrusted(ctx, inner, Math.max(x(run.trusted_s), inner.left));
    const unit = ticks.unit ? `(${ticks.unit})` : "";
    if (panel.unitText.textContent !== unit) panel.unitText.textContent = unit;
    const name = panel.logarithmic ? "logarithmic" : "linear";
    if (panel.scaleButton.textContent !== name) panel.scaleButton.textContent = name;
    panel.scaleButton.setAttribute("aria-pressed", panel.logarithmic);

    ctx.save();
    ctx.beginPath();
    ctx.rect(inner.left, inner.top - 3, inner.right - inner.left, inner.bottom - inner.top + 6);
    ctx.clip();
    const isComparison = this.playback.runs.length > 1;
    for (const run of this.playback.runs) {
      if (!run.visible) continue;
      for (const series of panel.series) {
        const values = series.runs[run.index];
        if (!series.visible || !values) continue;
        const { width, alpha, dash } = lineStyle(run, isComparison);
        ctx.strokeStyle = colour(seriesColour(series.index));
        ctx.lineWidth = width;
        ctx.globalAlpha = alpha;
        ctx.setLineDash(seriesDash(series.index, dash));
        drawCurve(ctx, run.time, values, series.rates[run.index], { x, y, from, to: Math.min(to, run.trusted_s ?? Infinity), logarithmic });
        // Runs with perturbed settings show the uncertainty.
        ctx.lineWidth = 1;
        ctx.globalAlpha = 0.4;
        ctx.setLineDash([]);
        for (const other of run.variationRuns ?? []) {
          const matchingSeries = other.panels.find(({ title }) => title === panel.title)?.series.find(({ name }) => name === series.name);
          if (matchingSeries) drawCurve(ctx, other.time, matchingSeries.values, matchingSeries.rates, { x, y, from: Math.max(from, run.trusted_s ?? from), to, logarithmic });
        }
        ctx.lineWidth = width;
        ctx.globalAlpha = alpha;
        if (run.trusted_s < to) {
          // Beyond this time, the run is one of many possible runs: dotted.
          ctx.setLineDash([1.5, 4]);
          drawCurve(ctx, run.time, values, series.rates[run.index], { x, y, from: Math.max(from, run.trusted_s), to, logarithmic });
        }
        ctx.globalAlpha = 1;
      }
    }
    ctx.setLineDash([]);
    ctx.restore();
    this.drawCursor(ctx, panel, inner, x, y, time);
    if (ticks.base) drawLabel(ctx, `${ticks.base} +`, inner.left + 4, inner.top + 6, "soft");
  }

  // Lower and upper limit of the visible values on the axis, with padding.
  valueRange(panel, from, to, scale) {
    let [low, high] = [Infinity, -Infinity];
    const include = (value) => {
      if (!Number.isFinite(value)) return;
      low = Math.min(low, value);
      high = Math.max(high, value);
    };
    for (const run of this.playback.runs) {
      if (!run.visible) continue;
      const [a, b] = [locateSample(run, from), locateSample(run, to)];
      for (const series of panel.series) {
        const values = series.runs[run.index];
        if (!series.visible || !values) continue;
        include(interpolate(values, a, series.rates[run.index]));
        for (let i = a.i + 1; i <= b.i; i++) include(values[i]);
        include(interpolate(values, b, series.rates[run.index]));
      }
    }
    if (!(low <= high)) [low, high] = [0, 1];
    [low, high] = [scale.forward(low), scale.forward(high)];
    const size = Math.max(Math.abs(low), Math.abs(high));
    // A quantity that is constant up to its last digits gets an axis of its own magnitude.
    if (size === 0) [low, high] = [-0.2, 1];
    else if (high - low < 1e-9 * size) [low, high] = [low - 0.1 * size, high + 0.1 * size];
    const padding = 0.07 * (high - low);
    return [low - padding, high + padding];
  }

  drawFrame(ctx, inner, ticks, x, y, from, to) {
    ctx.lineWidth = 1;
    ctx.setLineDash([]);
    ctx.fillStyle = colour("soft");
    ctx.textAlign = "right";
    ctx.textBaseline = "middle";
    const labelledPositions = [];
    for (const tick of ticks.ticks) {
      const position = Math.round(y(tick.value)) + 0.5;
      if (position < inner.top - 1 || position > inner.bottom + 1) continue;
      ctx.strokeStyle = colour(tick.value === 0 ? "soft" : "faint");
      ctx.globalAlpha = tick.value === 0 ? 0.6 : 1;
      ctx.beginPath();
      ctx.moveTo(inner.left, position);
      ctx.lineTo(inner.right, position);
      ctx.stroke();
      ctx.globalAlpha = 1;
      if (labelledPositions.some((other) => Math.abs(other - position) < 13)) continue;
      labelledPositions.push(position);
      ctx.fillText(tick.text, inner.left - 6, position);
    }
    const format = this.playback.timeFormat;
    ctx.textBaseline = "alphabetic";
    const count = (inner.right - inner.left) / 90;
    for (const tick of timeTicks(from, to, count, format)) {
      const position = Math.round(x(tick.value)) + 0.5;
      ctx.strokeStyle = colour("faint");
      ctx.beginPath();
      ctx.moveTo(position, inner.top);
      ctx.lineTo(position, inner.bottom);
      ctx.stroke();
      const halfWidth = ctx.measureText(tick.text).width / 2;
      ctx.textAlign = "center";
      ctx.fillText(tick.text, Math.min(Math.max(position, halfWidth + 22), inner.right + MARGIN_RIGHT - halfWidth), inner.bottom + 15);
    }
    ctx.textAlign = "left";
    ctx.fillText(format.unit, 4, inner.bottom + 15);
    for (const event of this.playback.events) {
      if (event.time_s < from || event.time_s > to || !event.run.visible) continue;
      const position = x(event.time_s);
      ctx.fillRect(position - 0.5, inner.bottom - 4, 1, 4);
    }
  }

  drawCursor(ctx, panel, inner, x, y, time) {
    const position = x(time);
    if (position < inner.left - 1 || position > inner.right + 1) return;
    ctx.strokeStyle = colour("accent");
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(position, inner.top);
    ctx.lineTo(position, inner.bottom);
    ctx.stroke();
    for (const run of this.playback.runs) {
      if (!run.visible) continue;
      for (const series of panel.series) {
        const values = series.runs[run.index];
        if (!series.visible || !values) continue;
        const value = interpolate(values, locateSample(run, time), series.rates[run.index]);
        if (!Number.isFinite(value)) continue;
        ctx.beginPath();
        ctx.arc(position, y(value), run.index === 0 ? 4 : 2.5, 0, 2 * Math.PI);
        ctx.fillStyle = colour(run.index === 0 ? seriesColour(series.index) : "panel");
        ctx.strokeStyle = colour(run.index === 0 ? "panel" : seriesColour(series.index));
        ctx.fill();
        ctx.stroke();
      }
    }
  }
}

// Line style of a run. A reference run is dashed and faint. Of two overlaid runs, the first is wide and pale and the
// second dashed.
function lineStyle(run, isComparison) {
  if (run.isReference) return { width: 1.5, alpha: 0.7, dash: [5, 3] };
  if (!isComparison || run.isReference === false) return { width: 1.75, alpha: 1, dash: [] };
  return run.index === 0 ? { width: 4.5, alpha: 0.45, dash: [] } : { width: 1.5, alpha: 1, dash: [5, 3] };
}

// Hatches a plot to the right of `from`, where the run is not reliable.
function hatchUntrusted(ctx, { right, top, bottom }, from) {
  if (from >= right) return;
  const height = bottom - top;
  ctx.save();
  ctx.beginPath();
  ctx.rect(from, top, right - from, height);
  ctx.clip();
  ctx.beginPath();
  for (let x = from - height; x < right; x += 9) {
    ctx.moveTo(x, bottom);
    ctx.lineTo(x + height, top);
  }
  ctx.setLineDash([]);
  ctx.lineWidth = 1;
  ctx.globalAlpha = 0.45;
  ctx.strokeStyle = colour("warn");
  ctx.stroke();
  ctx.restore();
}

// Merges the panels of all runs; series of equal name are joined.
function mergePanels(playback) {
  const panels = new Map();
  for (const run of playback.runs) {
    for (const panel of run.panels) {
      if (!panels.has(panel.title)) panels.set(panel.title, { ...panel, series: [], size: 0 });
      const merged = panels.get(panel.title);
      for (const { name, values, rates } of panel.series) {
        let series = merged.series.find((each) => each.name === name);
        if (!series) merged.series.push(series = { name, visible: true, index: merged.series.length, runs: [], rates: [] });
        series.runs[run.index] = values;
        series.rates[run.index] = rates;
        for (const value of values) if (Number.isFinite(value)) merged.size = Math.max(merged.size, Math.abs(value));
      }
    }
  }
  return [...panels.values()];
}

// Draws a curve within a time span. If samples are denser than pixels, each column of pixels shows its first, lowest,
// highest and last value, so that no peak is lost. Otherwise the interpolant is drawn in short segments: a straight
// line on a logarithmic scale would be wrong by a factor of ten where a gap closes.
function drawCurve(ctx, times, values, rates, { x, y, from, to, logarithmic }) {
  const straight = !logarithmic && !rates;
  const start = sampleIndexAt(times, from);
  const end = Math.min(sampleIndexAt(times, to) + 1, times.length - 1);
  ctx.beginPath();
  let isPenDown = false;
  const lineTo = (px, value) => {
    if (isPenDown) ctx.lineTo(px, y(value));
    else ctx.moveTo(px, y(value));
    isPenDown = true;
  };
  const drawSegment = (i) => {
    const [first, last] = [Math.max(times[i], from), Math.min(times[i + 1], to)];
    const segmentCount = straight ? 1 : Math.ceil((x(last) - x(first)) / SEGMENT_PX);
    const step = times[i + 1] - times[i];
    for (let k = 0; k <= segmentCount && last > first; k++) {
      const time = first + (last - first) * k / segmentCount;
      const fraction = (time - times[i]) / step;
      if (fraction > 0 && fraction < 1) lineTo(x(time), interpolate(values, { i, j: i + 1, fraction, step }, rates));
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
      isPenDown = false;
    } else {
      lineTo(px, values[i]);
      if (j - i > 1) [low, high, last].forEach((value) => lineTo(px, value));
      if (j <= end && Number.isFinite(values[j])) drawSegment(j - 1);
    }
    i = j;
  }
  ctx.stroke();
}

// Pointers on a plot: one moves the cursor, two zoom; the wheel zooms with ctrl and scrolls with shift.
function connectPlot(canvas, panel, plots, seek) {
  const pointers = new Map();
  const timeAt = (px) => {
    const { inner, from, to } = panel.layout;
    return from + (px - inner.left) / (inner.right - inner.left) * (to - from);
  };
  const pointerX = (event) => event.clientX - canvas.getBoundingClientRect().left;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, pointerX(event));
    if (pointers.size === 1) seek(timeAt(pointerX(event)));
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    if (pointers.size === 2) {
      const panelsByTitle = [...pointers.values()];
      pointers.set(event.pointerId, pointerX(event));
      const positions = [...pointers.values()];
      const [previousDistance, distance] = [Math.abs(panelsByTitle[0] - panelsByTitle[1]), Math.abs(positions[0] - positions[1])];
      if (previousDistance > 5 && distance > 5) plots.zoomTime(previousDistance / distance, timeAt((positions[0] + positions[1]) / 2));
    } else {
      pointers.set(event.pointerId, pointerX(event));
      seek(timeAt(pointerX(event)));
    }
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    if (event.ctrlKey || event.metaKey) plots.zoomTime(Math.exp(event.deltaY * 0.004), timeAt(pointerX(event)));
    else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) plots.moveTime((event.deltaX || event.deltaY) / canvas.clientWidth);
    else return;
    event.preventDefault();
  }, { passive: false });
}
