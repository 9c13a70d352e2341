// The explorer: a scene, the fields set on top of it, and everything that follows from them as they move.

// A hand that has not moved for so long has settled; a film that was held goes on so much later.
const SETTLED_MS = 150;
const RESUMED_MS = 1600;
const HEADINGS = { finger: "One finger", gripper: "Gripper", discs: "Discs", hard: "Hard cases" };

async function explorer() {
  const page = JSON.parse(byId("explorer").textContent);
  const { presets } = page;
  for (const [word, ink] of page.inks) inks.set(word, ink);
  const module = moduleOf(page);
  // The first answers the slider and nothing else that takes long, the second everything that may wait.
  const lines = { live: new Line(module), patient: null };
  module.catch((error) => warn([{ message: `The simulator could not be started: ${error.message ?? error}` }]));
  const opened = await stateOf(location.hash, page);
  const setting = new Setting(opened.scene ?? page.start);
  const lab = { page, presets, lines, setting, opened, app: null, run: null, figures: [], kept: null, verdict: null, wrong: [] };
  // Every move has a number; these are of the last one, and of those that are shown and that everything has been done for.
  Object.assign(lab, { stamp: 0, shownStamp: -1, settledStamp: -1, doneStamp: -1, ms: null, pictures: [], waiting: [] });

  chooser(lab);
  openable(lab);
  lab.put = (path, text) => {
    if (text === null) setting.set.delete(path);
    else setting.set.set(path, text);
    lab.last = path;
    return moved(lab);
  };
  lab.take = (scene) => {
    if (scene.text.length > page.largest_scene_bytes) return warn([{ message: tooLong(scene.file, page) }]);
    const other = scene.file !== setting.file || scene.text !== setting.text;
    setting.take(scene);
    lab.last = null;
    if (other) lab.fields?.forget();
    lab.fit = other;
    return moved(lab);
  };
  lab.preset = (file) => {
    const preset = presets.find((each) => each.file === file);
    if (preset) return lab.take({ ...preset, set: [] });
    return undefined;
  };
  lab.undo = () => setting.go(-1) && lab.take(setting.settled);
  lab.redo = () => setting.go(1) && lab.take(setting.settled);
  await moved(lab);
  if (opened.refused) warn([{ message: opened.refused }]);
}

// Something has moved: the run of what is set now is asked for, and when the hand rests, the rest.
async function moved(lab) {
  const { lines, setting } = lab;
  const stamp = ++lab.stamp;
  clearTimeout(lab.resting);
  clearTimeout(lab.resuming);
  if (lab.app?.clock.playing) {
    lab.app.clock.pause();
    lab.held = true;
  }
  lab.map?.drop();
  for (const kind of ["check", "cloud", "statics"]) lines.patient?.drop(kind);
  document.body.classList.add("busy");
  lab.resting = setTimeout(() => rested(lab, stamp), SETTLED_MS);
  const shot = setting.copy();
  const heard = await lines.live.ask("run", setting.asks("run"));
  if (!heard) return;
  lab.shownStamp = stamp;
  await shown(lab, heard, shot);
  if (stamp === lab.stamp) {
    document.body.classList.remove("busy");
    if (lab.rests === stamp) rested(lab, stamp);
  }
}

// Puts the answer of a run on the page.
async function shown(lab, { answer, data, ms }, shot) {
  const { film, figures, problems, failed } = answer;
  if (!film?.samples) {
    if (!lab.app) put("waiting", "This scene cannot be simulated here. Choose another one above.");
    wrong(lab, problems ?? [{ message: failed ?? "There is no answer." }]);
    return;
  }
  wrong(lab, []);
  lab.ms = ms;
  lab.steps = answer.steps;
  lab.failed = failed ?? null;
  const run = runOf(film, 0, film.columns.map(([offset, length]) => data.subarray(offset, offset + length)));
  run.visible = lab.run?.visible ?? true;
  lab.run = run;
  lab.of = shot;
  lab.figures = figures ?? [];
  lab.verdict = null;
  if (lab.app) refilm(lab);
  else begin(lab);
  lab.pictures.push(performance.now());
  if (lab.pictures.length > 30) lab.pictures.shift();
  lab.strip.show(lab.figures, lab.kept?.figures ?? null);
  showVerdict(null);
  byId("ended").hidden = !lab.failed;
  put("ended", lab.failed ? `The run has ended early: ${lab.failed}` : "");
  showWarnings(answer.warnings ?? []);
  put("class-reason", answer.verdict ?? "");
  byId("class-reason").title = answer.verdict ?? "";
  put("speed-of-run", speedWords(lab));
}

// How fast the last run was, and how often the picture changes under a moving hand.
function speedWords({ ms, steps, pictures }) {
  const recent = pictures.filter((time) => time > performance.now() - 1000);
  const rate = recent.length > 5 ? (recent.length - 1) / (recent.at(-1) - recent[0]) * 1000 : 0;
  return `simulated in ${ms.toFixed(ms < 10 ? 2 : 0)}\u202fms${steps ? `, ${steps} steps` : ""}${rate > 5 ? `, ${Math.round(rate)}\u202fHz` : ""}`;
}

// The film of the present run and of what was kept.
function filmNow(lab) {
  const { run, kept } = lab;
  run.label = kept ? "B" : "now";
  run.kept = kept ? false : undefined;
  const film = filmOf(kept ? [run, kept.run] : [run]);
  film.unit.decimals = Math.min(film.unit.decimals, 4);
  return film;
}

function refilm(lab) {
  lab.app.replace(filmNow(lab));
  if (lab.fit) lab.app.fit();
  lab.fit = false;
}

// The first run has come: there is something to draw.
function begin(lab) {
  byId("film").hidden = false;
  byId("waiting").hidden = true;
  const find = () => {
    lab.tabs.show("fields-box");
    byId("filter").focus();
  };
  const more = { keys: EXPLORER_KEYS, actions: { k: () => keep(lab), "/": find } };
  const app = viewer(filmNow(lab), (app) => keyboard(app, more));
  lab.app = app;
  app.clock.loops = true;
  app.pause = () => {
    lab.held = false;
    app.clock.pause();
  };
  const drawn = (canvas) => {
    const { top, bottom, height } = canvas.getBoundingClientRect();
    return height > 0 && bottom > -100 && top < innerHeight + 100;
  };
  app.plots.wanted = drawn;
  addEventListener("scroll", app.changed, { passive: true });
  app.files = filesOf(app, (kind) => lab.lines.live.ask(kind, lab.setting.asks(kind)));
  if (!app.files.webm) byId("save").querySelector("[value='webm']").remove();
  lab.strip = new Figures(byId("strip"), byId("table"));
  lab.tabs = tabs(byId("tabs"), () => {
    app.changed();
    seen(lab);
  });
  lab.tabs.kept();
  // What follows the animation on a small page begins below it.
  const left = document.querySelector(".left");
  new ResizeObserver(() => document.documentElement.style.setProperty("--left-high", `${left.offsetHeight}px`)).observe(left);
  app.drawn.push(() => {
    lab.firstPicture_ms ??= performance.now();
    if (lab.map?.canvas.clientWidth !== lab.mapWide) {
      lab.mapWide = lab.map?.canvas.clientWidth;
      lab.map?.draw();
    }
    linkSoon(lab);
  });
  const theme = app.theme;
  app.theme = (name) => {
    theme(name);
    if (lab.map) Object.assign(lab.map, { legendForm: null });
    lab.map?.draw();
  };
  if (lab.opened.time_s !== null) app.seek(lab.opened.time_s);
  else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) app.clock.play();
  else app.seek(app.film.end);
  app.render();
  window.phalanx = explorerForTests(lab);
}

// The hand rests: a step that can be undone, and what takes longer.
async function rested(lab, stamp) {
  lab.rests = stamp;
  if (stamp !== lab.stamp || lab.shownStamp !== stamp || lab.settledStamp === stamp) return;
  lab.settledStamp = stamp;
  lab.rests = null;
  const { setting, lines } = lab;
  setting.settle();
  if (!lab.app) return done(lab, stamp);
  lines.patient ??= new Line(lines.live.module);
  if (!lab.fields) furnish(lab);
  const still = () => stamp === lab.stamp;
  const base = await baseOf(lab);
  const heard = await lines.patient.ask("fields", setting.asks("fields"), -1);
  if (!still()) return undefined;
  if (heard?.answer.fields && base) {
    lab.fields.show(heard.answer, base, setting.set);
    lab.known = heard.answer;
    title(lab, heard.answer);
  }
  buttons(lab);
  if (lab.opened.kept) await keptAgain(lab, lab.opened.kept);
  done(lab, stamp);
  if (lab.held) lab.resuming = setTimeout(() => lab.held && lab.app.clock.play(), RESUMED_MS);
  if (lab.wrong.length > 0) return undefined;
  seen(lab);
  const checked = await lines.patient.ask("check", setting.asks("check"), 0);
  if (checked && still()) {
    lab.verdict = checked.answer.verdict ? checked.answer : { verdict: "unknown", text: checked.answer.failed ?? checked.answer.problems?.[0]?.message ?? "" };
    showVerdict(lab.verdict);
    lab.run.trusted_s = trustedUntil(lab.verdict, lab.app.film.start);
    lab.app.changed();
    lab.waiting = lab.waiting.filter(({ verdict, resolve }) => !verdict || resolve());
    await clouded(lab, still);
  }
  return undefined;
}

// Of a run that cannot be trusted, its neighbours, and from when on they part.
async function clouded(lab, still) {
  const { verdict, run, of, lines, known, app } = lab;
  if (!known || run.trusted_s === undefined) return;
  const cloud = await cloudOf(lines.patient, of, known.fields, still);
  if (!cloud || !still()) return;
  run.cloud = cloud;
  const parted = verdict.from_s ?? parting(run, cloud, verdict.error_rad ?? verdict.error ?? 0);
  run.trusted_s = parted ?? app.film.start;
  if (parted !== null) sayDoubt(verdict, ` from ${timeText(parted, app.film.unit, 2)} on, where its neighbours part`);
  app.changed();
}

// Whoever waits for the page to be up to date hears that it is.
function done(lab, stamp) {
  lab.doneStamp = stamp;
  lab.waiting = lab.waiting.filter((each) => {
    if (!each.verdict) each.resolve();
    return each.verdict;
  });
}

// What of the setting is shown only if it is looked at.
function seen(lab) {
  if (lab.settledStamp !== lab.stamp) return;
  lab.map?.renew();
  lab.statics?.renew();
  // A scene may have thousands of events.
  if (lab.tabs.shown() === "panel-events" && lab.listed !== lab.app.film.events) {
    lab.listed = lab.app.film.events;
    lab.app.events.renew();
    lab.app.changed();
  }
}

// The fields of the scene alone, once for each.
async function baseOf(lab) {
  const { setting, lines } = lab;
  const { file, text } = setting;
  if (lab.base?.file === file && lab.base.text === text) return lab.base.answer;
  const heard = await lines.patient.ask("base", { ask: "fields", scene: { file, text }, set: [] }, -1);
  if (!heard?.answer.fields) return null;
  lab.base = { file, text, answer: heard.answer };
  return heard.answer;
}

// What is built when the first picture is there.
function furnish(lab) {
  const { app, setting, lines } = lab;
  lab.fields = new Fields(byId("fields"), {
    put: lab.put,
    hint: (key) => {
      app.stage.hinted = LETTERS.get(key) ?? null;
      app.changed();
    },
  });
  lab.map = new DesignMap(lines.patient, {
    setting: () => setting.copy(),
    fields: lab.fields,
    figures: () => lab.figures,
    go: (pairs) => {
      for (const [path, text] of pairs) setting.set.set(path, text);
      lab.last = pairs[0][0];
      moved(lab);
    },
    changed: () => linkSoon(lab),
    wanted: () => lab.tabs.shown() === "panel-map",
  });
  const { map } = lab.opened;
  if (map) {
    Object.assign(lab.map.axes, { x: map[0], y: map[1] });
    lab.map.criterion = map[2] ?? "";
  }
  lab.statics = new Statics(lines.patient, byId("panel-statics"), { setting: () => setting, wanted: () => lab.tabs.shown() === "panel-statics" });
  controlsOf(lab);
  // An address that has a map is of one who looked at it.
  if (map) lab.tabs.show("panel-map");
}

// Keeps the present film as the pale one.
function keep(lab) {
  if (!lab.run || lab.wrong.length > 0) return;
  lab.kept = { scene: lab.of, figures: lab.figures, verdict: lab.verdict, run: { ...lab.run, index: 1, label: "A", kept: true, visible: true, trusted_s: lab.run.trusted_s } };
  compared(lab);
}

function drop(lab) {
  lab.kept = null;
  compared(lab);
}

function compared(lab) {
  refilm(lab);
  seen(lab);
  lab.strip.show(lab.figures, lab.kept?.figures ?? null);
  buttons(lab);
  linkSoon(lab);
}

// A becomes what is changed, and what was changed becomes A.
function swap(lab) {
  if (!lab.kept) return;
  const { scene } = lab.kept;
  keep(lab);
  lab.take(scene);
}

// What an address keeps as A is simulated once more.
async function keptAgain(lab, scene) {
  lab.opened.kept = null;
  const heard = await lab.lines.live.ask("kept", { ask: "run", scene: { file: scene.file, text: scene.text }, set: scene.set });
  const { film, figures } = heard?.answer ?? {};
  if (!film) return;
  const run = runOf(film, 1, film.columns.map(([offset, length]) => heard.data.subarray(offset, offset + length)));
  lab.kept = { scene, figures, verdict: null, run: { ...run, index: 1, label: "A", kept: true, visible: true } };
  compared(lab);
}

explorer();
