// Buttons, sliders and pointers of the viewer.

const byId = (id) => document.getElementById(id);

// Connects the controls to their actions; returns the function that updates them.
function connectControls(app) {
  const { playback } = app;
  const onClick = (id, action) => byId(id).addEventListener("click", action);
  onClick("play", app.toggle);
  onClick("backward", () => app.step(-1));
  onClick("forward", () => app.step(1));
  onClick("previous", () => app.jump(-1));
  onClick("next", () => app.jump(1));
  onClick("zoom-in", () => app.zoom(1.5));
  onClick("zoom-out", () => app.zoom(1 / 1.5));
  onClick("zoom-fit", app.fit);
  onClick("symbols", app.toggleSymbols);
  onClick("window-in", () => app.zoomTime(0.5));
  onClick("window-out", () => app.zoomTime(2));
  onClick("window-event", app.showNearestImpact);
  onClick("window-all", () => app.setWindow(playback.start, playback.end));
  onClick("theme", app.toggleTheme);
  byId("scrub").addEventListener("input", (event) => {
    const [from, to] = app.range();
    app.seek(from + Number(event.target.value) * (to - from));
  });
  byId("speed").addEventListener("input", (event) => app.setNotch(Number(event.target.value)));
  byId("auto").addEventListener("change", (event) => app.setAuto(event.target.checked));
  byId("arrows").addEventListener("change", (event) => app.setArrows(event.target.value));
  byId("save").addEventListener("change", async ({ target }) => {
    const kind = target.value;
    const [first] = target.options;
    const caption = first.textContent;
    target.value = "";
    const showProgress = (fraction) => {
      target.disabled = true;
      first.textContent = `${Math.floor(100 * fraction)} %`;
    };
    try {
      await saveFile(app, kind, showProgress);
    } finally {
      first.textContent = caption;
      target.disabled = false;
    }
  });
  byId("follow").addEventListener("change", (event) => app.follow(event.target.value || null));
  updateChoices(app);
  connectStage(app);
  connectOverview(app);
  return () => updateControls(app);
}

// Updates the choice of contacts and runs of the present playback.
function updateChoices(app) {
  const { playback, stage } = app;
  const contacts = [...stage.camera.maxPenetrations.keys()];
  for (const id of ["previous", "next", "window-event"]) byId(id).disabled = playback.events.length === 0;
  // Unchanged elements are retained because one may be open.
  const choicesKey = JSON.stringify([contacts, playback.runs.map((run) => [run.label, run.isReference])]);
  if (choicesKey === app.choicesKey) return;
  app.choicesKey = choicesKey;
  byId("symbols").hidden = !playback.runs.some((run) => run.bodies.some((body) => body.name.endsWith("l22")));
  byId("follow").replaceChildren(element("option", { value: "" }, "Everything"), ...contacts.map((name) => element("option", { value: name }, `At ${name}`)));
  byId("follow").hidden = contacts.length === 0;
  byId("arrows-box").hidden = contacts.length === 0;
  byId("runs").hidden = playback.runs.length < 2;
  byId("runs").replaceChildren(...playback.runs.map((run) => {
    const box = element("input", { type: "checkbox", checked: "", "aria-label": `Show ${run.label}` });
    box.addEventListener("change", () => app.show(run.index, box.checked));
    const name = element("span", { class: "name", title: run.label }, run.label);
    return element("label", {}, box, strokeSample(run), name);
  }));
}

const setText = (id, text) => {
  if (byId(id).textContent !== text) byId(id).textContent = text;
};

function updateControls(app) {
  const { playback, clock, stage } = app;
  const [from, to] = app.range();
  const format = playback.timeFormat;
  const playing = clock.playing;
  byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  byId("play").querySelector("use").setAttribute("href", playing ? "#i-pause" : "#i-play");
  const now = formatTime(clock.time, format);
  setText("time", now);
  const first = playback.runs.find((run) => run.visible) ?? playback.runs[0];
  setText("sample", `sample ${locateSample(first, clock.time).i + 1} of ${first.samples}`);
  byId("scrub").value = (clock.time - from) / (to - from);
  byId("scrub").setAttribute("aria-valuetext", now);
  const digits = Math.min(format.decimals, Math.max(0, Math.ceil(-Math.log10((to - from) * format.factor)) + 3));
  setText("from", formatTime(from, format, digits));
  setText("to", formatTime(to, format, digits));
  const whole = from <= playback.start && to >= playback.end;
  setText("window-note", whole ? "" : `window of ${formatDuration(to - from)}`);
  setText("span", whole ? `Time axis: all, ${formatDuration(to - from)}` : `Time axis: ${formatDuration(to - from)}`);
  byId("auto").checked = clock.auto;
  if (clock.auto) byId("speed").value = Math.round(3 * Math.log10(clock.speed / MIN_SPEED));
  else byId("speed").value = clock.notch;
  setText("speed-text", formatSpeed(clock.speed));
  byId("speed").setAttribute("aria-valuetext", formatSpeed(clock.speed));
  byId("follow").value = stage.camera.follow ?? "";
  byId("symbols").setAttribute("aria-pressed", stage.showsSymbols);
  byId("arrows").value = stage.arrowsToScale ? "linear" : "log";
  byId("runs").querySelectorAll("input").forEach((box, index) => { box.checked = playback.runs[index].visible; });
  drawOverview(app);
}

// Draws the whole run as a bar: events, window of the time axis, cursor.
function drawOverview({ playback, clock, range }) {
  const { ctx, width, height } = clearCanvas(byId("overview"));
  const margin = 8;
  const x = (time) => margin + (time - playback.start) / (playback.end - playback.start) * (width - 2 * margin);
  const [from, to] = range();
  ctx.fillStyle = colour("faint");
  ctx.fillRect(margin, height / 2 - 3, width - 2 * margin, 6);
  if (from > playback.start || to < playback.end) {
    ctx.fillStyle = colour("line");
    ctx.fillRect(x(from), 1, Math.max(2, x(to) - x(from)), height - 2);
  }
  ctx.fillStyle = colour("soft");
  for (const event of playback.events) {
    if (!event.run.visible) continue;
    const barHeight = event.kind === "touch-down" ? height - 4 : 6;
    ctx.fillRect(x(event.time_s) - 0.75, (height - barHeight) / 2, 1.5, barHeight);
  }
  ctx.fillStyle = colour("accent");
  ctx.fillRect(x(clock.time) - 1, 0, 2, height);
}

function connectOverview({ playback, seek }) {
  const canvas = byId("overview");
  const move = (event) => {
    const box = canvas.getBoundingClientRect();
    seek(playback.start + (event.clientX - box.left - 8) / (box.width - 16) * (playback.end - playback.start));
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    move(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) move(event);
  });
}

// One pointer pans the animation; two pointers or the wheel zoom it.
function connectStage(app) {
  const { canvas, camera } = app.stage;
  const pointers = new Map();
  const canvasPoint = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, canvasPoint(event));
  });
  canvas.addEventListener("pointerleave", () => {
    app.stage.pointer = null;
    if (app.stage.isHovered) app.requestRedraw();
  });
  canvas.addEventListener("pointermove", (event) => {
    const previousPoint = pointers.get(event.pointerId);
    const point = canvasPoint(event);
    if (!previousPoint) {
      // Touch pans the picture and does not hover.
      app.stage.pointer = event.pointerType === "touch" ? null : point;
      app.requestRedraw();
      return;
    }
    if (pointers.size === 1) {
      camera.panBy(point[0] - previousPoint[0], point[1] - previousPoint[1]);
    } else {
      const [otherPoint] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, position]) => position);
      const previousDistance = Math.hypot(previousPoint[0] - otherPoint[0], previousPoint[1] - otherPoint[1]);
      const distance = Math.hypot(point[0] - otherPoint[0], point[1] - otherPoint[1]);
      if (previousDistance > 5 && distance > 5) camera.zoomBy(distance / previousDistance, (point[0] + otherPoint[0]) / 2, (point[1] + otherPoint[1]) / 2);
    }
    pointers.set(event.pointerId, point);
    app.requestRedraw();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoomBy(Math.exp(-event.deltaY * 0.002), ...canvasPoint(event));
    app.requestRedraw();
  }, { passive: false });
}
