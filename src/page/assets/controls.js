// Buttons, sliders and pointers of the animation.

const byId = (id) => document.getElementById(id);

// Ties the elements of the page to what they do; returns what brings them up to date.
function controls(app) {
  const { film } = app;
  const click = (id, action) => byId(id).addEventListener("click", action);
  click("play", app.toggle);
  click("back", () => app.step(-1));
  click("forth", () => app.step(1));
  click("previous", () => app.jump(-1));
  click("next", () => app.jump(1));
  click("zoom-in", () => app.zoom(1.5));
  click("zoom-out", () => app.zoom(1 / 1.5));
  click("zoom-fit", app.fit);
  click("letters", app.toggleLetters);
  click("window-in", () => app.zoomTime(0.5));
  click("window-out", () => app.zoomTime(2));
  click("window-event", app.windowEvent);
  click("window-all", () => app.window(film.start, film.end));
  click("theme", app.toggleTheme);
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
    const words = first.textContent;
    target.value = "";
    const tell = (part) => {
      target.disabled = true;
      first.textContent = `${Math.floor(100 * part)} %`;
    };
    try {
      await saveAs(app, kind, tell);
    } finally {
      first.textContent = words;
      target.disabled = false;
    }
  });
  byId("follow").addEventListener("change", (event) => app.follow(event.target.value || null));
  choices(app);
  stagePointers(app);
  overviewPointers(app);
  return () => refresh(app);
}

// What there is to choose: the contacts and the runs of the film as it is now.
function choices(app) {
  const { film, stage } = app;
  const contacts = [...stage.camera.deepest.keys()];
  for (const id of ["previous", "next", "window-event"]) byId(id).disabled = film.events.length === 0;
  // Elements that are there stay, for someone may have them open.
  const form = JSON.stringify([contacts, film.runs.map((run) => [run.label, run.kept])]);
  if (form === app.chosenFrom) return;
  app.chosenFrom = form;
  byId("letters").hidden = !film.runs.some((run) => run.bodies.some((body) => body.name.endsWith("l22")));
  byId("follow").replaceChildren(element("option", { value: "" }, "Whole"), ...contacts.map((name) => element("option", { value: name }, `At ${name}`)));
  byId("follow").hidden = contacts.length === 0;
  byId("arrows-box").hidden = contacts.length === 0;
  byId("runs").hidden = film.runs.length < 2;
  byId("runs").replaceChildren(...film.runs.map((run) => {
    const box = element("input", { type: "checkbox", checked: "", "aria-label": `Show ${run.label}` });
    box.addEventListener("change", () => app.show(run.index, box.checked));
    const name = element("span", { class: "name", title: run.label }, run.label);
    return element("label", {}, box, strokeSample(run), name);
  }));
}

const put = (id, text) => {
  if (byId(id).textContent !== text) byId(id).textContent = text;
};

function refresh(app) {
  const { film, clock, stage } = app;
  const [from, to] = app.range();
  const by = film.unit;
  const playing = clock.playing;
  byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  byId("play").querySelector("use").setAttribute("href", playing ? "#i-pause" : "#i-play");
  const now = timeText(clock.time, by);
  put("time", now);
  const first = film.runs.find((run) => run.visible) ?? film.runs[0];
  put("sample", `sample ${placeAt(first, clock.time).i + 1} of ${first.samples}`);
  byId("scrub").value = (clock.time - from) / (to - from);
  byId("scrub").setAttribute("aria-valuetext", now);
  const digits = Math.min(by.decimals, Math.max(0, Math.ceil(-Math.log10((to - from) * by.factor)) + 3));
  put("from", timeText(from, by, digits));
  put("to", timeText(to, by, digits));
  const whole = from <= film.start && to >= film.end;
  put("window-note", whole ? "" : `window of ${durationText(to - from)}`);
  put("span", whole ? `Time axis: all, ${durationText(to - from)}` : `Time axis: ${durationText(to - from)}`);
  byId("auto").checked = clock.auto;
  if (clock.auto) byId("speed").value = Math.round(3 * Math.log10(clock.speed / SLOWEST));
  else byId("speed").value = clock.notch;
  put("speed-text", speedText(clock.speed));
  byId("speed").setAttribute("aria-valuetext", speedText(clock.speed));
  byId("follow").value = stage.camera.follow ?? "";
  byId("letters").setAttribute("aria-pressed", stage.named);
  byId("arrows").value = stage.arrowsToScale ? "linear" : "log";
  byId("runs").querySelectorAll("input").forEach((box, index) => { box.checked = film.runs[index].visible; });
  overview(app);
}

// The whole run as a bar: events, the window of the time axis, the cursor.
function overview({ film, clock, range }) {
  const { ctx, width, height } = cleared(byId("overview"));
  const margin = 8;
  const x = (time) => margin + (time - film.start) / (film.end - film.start) * (width - 2 * margin);
  const [from, to] = range();
  ctx.fillStyle = colour("faint");
  ctx.fillRect(margin, height / 2 - 3, width - 2 * margin, 6);
  if (from > film.start || to < film.end) {
    ctx.fillStyle = colour("line");
    ctx.fillRect(x(from), 1, Math.max(2, x(to) - x(from)), height - 2);
  }
  ctx.fillStyle = colour("soft");
  for (const event of film.events) {
    if (!event.run.visible) continue;
    const tall = event.kind === "touch-down" ? height - 4 : 6;
    ctx.fillRect(x(event.time_s) - 0.75, (height - tall) / 2, 1.5, tall);
  }
  ctx.fillStyle = colour("accent");
  ctx.fillRect(x(clock.time) - 1, 0, 2, height);
}

function overviewPointers({ film, seek }) {
  const bar = byId("overview");
  const move = (event) => {
    const box = bar.getBoundingClientRect();
    seek(film.start + (event.clientX - box.left - 8) / (box.width - 16) * (film.end - film.start));
  };
  bar.addEventListener("pointerdown", (event) => {
    bar.setPointerCapture(event.pointerId);
    move(event);
  });
  bar.addEventListener("pointermove", (event) => {
    if (bar.hasPointerCapture(event.pointerId)) move(event);
  });
}

// One pointer moves the animation, two zoom it, the wheel too.
function stagePointers(app) {
  const { canvas, camera } = app.stage;
  const pointers = new Map();
  const inside = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, inside(event));
  });
  canvas.addEventListener("pointerleave", () => {
    app.stage.pointer = null;
    if (app.stage.pointed) app.changed();
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    const now = inside(event);
    if (!before) {
      // A finger on the glass moves the picture; only what hovers points at something.
      app.stage.pointer = event.pointerType === "touch" ? null : now;
      app.changed();
      return;
    }
    if (pointers.size === 1) {
      camera.panBy(now[0] - before[0], now[1] - before[1]);
    } else {
      const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const apart = Math.hypot(before[0] - other[0], before[1] - other[1]);
      const wide = Math.hypot(now[0] - other[0], now[1] - other[1]);
      if (apart > 5 && wide > 5) camera.zoomBy(wide / apart, (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    }
    pointers.set(event.pointerId, now);
    app.changed();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    camera.zoomBy(Math.exp(-event.deltaY * 0.002), ...inside(event));
    app.changed();
  }, { passive: false });
}
