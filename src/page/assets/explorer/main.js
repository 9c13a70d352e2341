// The explorer: simulates a scene with overridden fields, and updates all views when they change.

// Time without edits until the checks start, and until a paused playback resumes.
const SETTLE_DELAY_MS = 150;
const RESUME_DELAY_MS = 1600;
const PRESET_GROUP_TITLES = { finger: "One finger", gripper: "Gripper", mechanism: "Mechanism", hard: "Hard cases" };

async function startExplorer() {
  const page = JSON.parse(byId("explorer").textContent);
  const { presets } = page;
  for (const [word, colour] of page.inks) resultColours.set(word, colour);
  const modulePromise = compileModule(page);
  // `live` serves the sliders; `background` serves slow requests.
  const queues = { live: new WorkerQueue(modulePromise), background: null };
  modulePromise.catch((error) => showWarning([{ message: `The simulator could not be started: ${error.message ?? error}` }]));
  const initialState = await decodeFragment(location.hash, page);
  const settings = new SceneSettings(initialState.scene ?? page.start);
  const explorer = { page, presets, queues, settings, initialState, app: null, run: null, figures: [], reference: null, verdict: null, problems: [] };
  // Each edit has a revision number. These are the latest, the shown, the committed and the completed revision.
  Object.assign(explorer, { revision: 0, shownRevision: -1, settledRevision: -1, finishedRevision: -1, ms: null, pictureTimes: [], waiters: [] });

  connectPresets(explorer);
  connectFileInputs(explorer);
  explorer.setField = (path, text) => {
    if (text === null) settings.set.delete(path);
    else settings.set.set(path, text);
    explorer.lastChangedField = path;
    return simulate(explorer);
  };
  explorer.loadScene = (scene) => {
    if (scene.text.length > page.largest_scene_bytes) return showWarning([{ message: tooLongMessage(scene.file, page) }]);
    const isOtherScene = scene.file !== settings.file || scene.text !== settings.text;
    settings.load(scene);
    explorer.lastChangedField = null;
    if (isOtherScene) explorer.fields?.reset();
    explorer.fitsOnUpdate = isOtherScene;
    return simulate(explorer);
  };
  explorer.loadPreset = (file) => {
    const preset = presets.find((candidate) => candidate.file === file);
    if (preset) return explorer.loadScene({ ...preset, set: [] });
    return undefined;
  };
  explorer.undo = () => settings.moveInHistory(-1) && explorer.loadScene(settings.committed);
  explorer.redo = () => settings.moveInHistory(1) && explorer.loadScene(settings.committed);
  await simulate(explorer);
  if (initialState.error) showWarning([{ message: initialState.error }]);
}

// Simulates the present settings; after a delay without further edits, `settle` requests the other results.
async function simulate(explorer) {
  const { queues, settings } = explorer;
  const revision = ++explorer.revision;
  clearTimeout(explorer.settleTimer);
  clearTimeout(explorer.resumeTimer);
  if (explorer.app?.clock.playing) {
    explorer.app.clock.pause();
    explorer.pausedByEdit = true;
  }
  explorer.map?.invalidate();
  for (const kind of ["check", "cloud", "statics"]) queues.background?.cancel(kind);
  document.body.classList.add("busy");
  explorer.settleTimer = setTimeout(() => settle(explorer, revision), SETTLE_DELAY_MS);
  const scene = settings.copy();
  const reply = await queues.live.request("run", settings.request("run"));
  if (!reply) return;
  explorer.shownRevision = revision;
  await showRun(explorer, reply, scene);
  if (revision === explorer.revision) {
    document.body.classList.remove("busy");
    if (explorer.pendingRevision === revision) settle(explorer, revision);
  }
}

// Shows the results of a run.
async function showRun(explorer, { response, data, ms }, scene) {
  const { playback: rawRun, figures, problems, failed } = response;
  if (!rawRun?.samples) {
    if (!explorer.app) setText("waiting", "This scene cannot be simulated here. Choose another one above.");
    showProblems(explorer, problems ?? [{ message: failed ?? "The simulator has not responded." }]);
    return;
  }
  showProblems(explorer, []);
  explorer.ms = ms;
  explorer.steps = response.steps;
  explorer.failed = failed ?? null;
  const run = decodeRun(rawRun, 0, rawRun.columns.map(([offset, length]) => data.subarray(offset, offset + length)));
  run.visible = explorer.run?.visible ?? true;
  explorer.run = run;
  explorer.runScene = scene;
  explorer.figures = figures ?? [];
  explorer.verdict = null;
  if (explorer.app) updatePlayback(explorer);
  else startViewer(explorer);
  explorer.pictureTimes.push(performance.now());
  if (explorer.pictureTimes.length > 30) explorer.pictureTimes.shift();
  explorer.strip.show(explorer.figures, explorer.reference?.figures ?? null);
  showVerdict(null);
  byId("ended").hidden = !explorer.failed;
  setText("ended", explorer.failed ? `The run was aborted: ${explorer.failed}` : "");
  updateWarnings(response.warnings ?? []);
  setText("class-reason", response.verdict ?? "");
  byId("class-reason").title = response.verdict ?? "";
  setText("speed-of-run", performanceText(explorer));
}

// Duration of the last run, and update rate while a slider moves.
function performanceText({ ms, steps, pictureTimes }) {
  const recent = pictureTimes.filter((time) => time > performance.now() - 1000);
  const rate = recent.length > 5 ? (recent.length - 1) / (recent.at(-1) - recent[0]) * 1000 : 0;
  return `simulated in ${ms.toFixed(ms < 10 ? 2 : 0)}\u202fms${steps ? `, ${steps} steps` : ""}${rate > 5 ? `, ${Math.round(rate)}\u202fHz` : ""}`;
}

// The playback of the present run and of the reference run.
function currentPlayback(explorer) {
  const { run, reference } = explorer;
  run.label = reference ? "B" : "now";
  run.isReference = reference ? false : undefined;
  const playback = buildPlayback(reference ? [run, reference.run] : [run]);
  playback.timeFormat.decimals = Math.min(playback.timeFormat.decimals, 4);
  return playback;
}

function updatePlayback(explorer) {
  explorer.app.replacePlayback(currentPlayback(explorer));
  if (explorer.fitsOnUpdate) explorer.app.fit();
  explorer.fitsOnUpdate = false;
}

// Creates the viewer after the first run.
function startViewer(explorer) {
  byId("playback").hidden = false;
  byId("waiting").hidden = true;
  const focusFilter = () => {
    explorer.tabs.show("fields-box");
    byId("filter").focus();
  };
  const extraKeys = { keys: EXPLORER_KEY_HELP, actions: { k: () => keepReference(explorer), "/": focusFilter } };
  const app = createViewer(currentPlayback(explorer), (app) => connectKeyboard(app, extraKeys));
  explorer.app = app;
  app.clock.loops = true;
  app.pause = () => {
    explorer.pausedByEdit = false;
    app.clock.pause();
  };
  const isNearViewport = (canvas) => {
    const { top, bottom, height } = canvas.getBoundingClientRect();
    return height > 0 && bottom > -100 && top < innerHeight + 100;
  };
  app.plots.needsDrawing = isNearViewport;
  addEventListener("scroll", app.requestRedraw, { passive: true });
  app.exporters = createExporters(app, (kind) => explorer.queues.live.request(kind, explorer.settings.request(kind)));
  if (!app.exporters.webm) byId("save").querySelector("[value='webm']").remove();
  explorer.strip = new Figures(byId("strip"), byId("table"));
  explorer.tabs = createTabs(byId("tabs"), () => {
    app.requestRedraw();
    refreshVisibleTab(explorer);
  });
  explorer.tabs.ensureVisibleTab();
  // On a small screen, the content below the animation starts at its lower edge.
  const leftColumn = document.querySelector(".left");
  new ResizeObserver(() => document.documentElement.style.setProperty("--left-high", `${leftColumn.offsetHeight}px`)).observe(leftColumn);
  app.afterRender.push(() => {
    explorer.firstPicture_ms ??= performance.now();
    if (explorer.map?.canvas.clientWidth !== explorer.mapWidth) {
      explorer.mapWidth = explorer.map?.canvas.clientWidth;
      explorer.map?.draw();
    }
    scheduleLinkUpdate(explorer);
  });
  const setViewerTheme = app.setTheme;
  app.setTheme = (name) => {
    setViewerTheme(name);
    if (explorer.map) Object.assign(explorer.map, { legendKey: null });
    explorer.map?.draw();
  };
  if (explorer.initialState.time_s !== null) app.seek(explorer.initialState.time_s);
  else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) app.clock.play();
  else app.seek(app.playback.end);
  app.render();
  window.phalanx = createExplorerTestHooks(explorer);
}

// After a pause in the edits: commits an undo step and requests the slow results.
async function settle(explorer, revision) {
  explorer.pendingRevision = revision;
  if (revision !== explorer.revision || explorer.shownRevision !== revision || explorer.settledRevision === revision) return;
  explorer.settledRevision = revision;
  explorer.pendingRevision = null;
  const { settings, queues } = explorer;
  settings.commit();
  if (!explorer.app) return finishRevision(explorer, revision);
  queues.background ??= new WorkerQueue(queues.live.module);
  if (!explorer.fields) buildControls(explorer);
  const isCurrent = () => revision === explorer.revision;
  const fieldsOfScene = await loadSceneFields(explorer);
  const reply = await queues.background.request("fields", settings.request("fields"), -1);
  if (!isCurrent()) return undefined;
  if (reply?.response.fields && fieldsOfScene) {
    explorer.fields.show(reply.response, fieldsOfScene, settings.set);
    explorer.fieldData = reply.response;
    showTitle(explorer, reply.response);
  }
  updateButtons(explorer);
  if (explorer.initialState.reference) await restoreReference(explorer, explorer.initialState.reference);
  finishRevision(explorer, revision);
  if (explorer.pausedByEdit) explorer.resumeTimer = setTimeout(() => explorer.pausedByEdit && explorer.app.clock.play(), RESUME_DELAY_MS);
  if (explorer.problems.length > 0) return undefined;
  refreshVisibleTab(explorer);
  const checkReply = await queues.background.request("check", settings.request("check"), 0);
  if (checkReply && isCurrent()) {
    explorer.verdict = checkReply.response.verdict ? checkReply.response : { verdict: "unknown", text: checkReply.response.failed ?? checkReply.response.problems?.[0]?.message ?? "" };
    showVerdict(explorer.verdict);
    explorer.run.trusted_s = trustedUntil(explorer.verdict, explorer.app.playback.start);
    explorer.app.requestRedraw();
    explorer.waiters = explorer.waiters.filter(({ verdict, resolve }) => !verdict || resolve());
    await showVariations(explorer, isCurrent);
  }
  return undefined;
}

// Shows the variations of an unreliable run, and the time from which they diverge.
async function showVariations(explorer, isCurrent) {
  const { verdict, run, runScene, queues, fieldData, app } = explorer;
  if (!fieldData || run.trusted_s === undefined) return;
  const variationRuns = await runVariations(queues.background, runScene, fieldData.fields, isCurrent);
  if (!variationRuns || !isCurrent()) return;
  run.variationRuns = variationRuns;
  const divergence_s = verdict.from_s ?? divergenceTime(run, variationRuns, verdict.error_rad ?? verdict.error ?? 0);
  run.trusted_s = divergence_s ?? app.playback.start;
  if (divergence_s !== null) showDoubt(verdict, ` from ${formatTime(divergence_s, app.playback.timeFormat, 2)} on, where perturbed runs diverge`);
  app.requestRedraw();
}

// Notifies the waiters that the page is up to date.
function finishRevision(explorer, revision) {
  explorer.finishedRevision = revision;
  explorer.waiters = explorer.waiters.filter((each) => {
    if (!each.verdict) each.resolve();
    return each.verdict;
  });
}

// Updates the contents of the visible tab.
function refreshVisibleTab(explorer) {
  if (explorer.settledRevision !== explorer.revision) return;
  explorer.map?.reload();
  explorer.statics?.reload();
  // A scene may have thousands of events, so the list is built on demand.
  if (explorer.tabs.shown() === "panel-events" && explorer.listedEvents !== explorer.app.playback.events) {
    explorer.listedEvents = explorer.app.playback.events;
    explorer.app.events.reload();
    explorer.app.requestRedraw();
  }
}

// The fields of the scene without overrides, cached per scene.
async function loadSceneFields(explorer) {
  const { settings, queues } = explorer;
  const { file, text } = settings;
  if (explorer.sceneFields?.file === file && explorer.sceneFields.text === text) return explorer.sceneFields.response;
  const reply = await queues.background.request("base", { ask: "fields", scene: { file, text }, set: [] }, -1);
  if (!reply?.response.fields) return null;
  explorer.sceneFields = { file, text, response: reply.response };
  return reply.response;
}

// Creates the controls after the first run is shown.
function buildControls(explorer) {
  const { app, settings, queues } = explorer;
  explorer.fields = new FieldList(byId("fields"), {
    setField: explorer.setField,
    onHover: (key) => {
      app.stage.highlightedSymbol = FIELD_SYMBOLS.get(key) ?? null;
      app.requestRedraw();
    },
  });
  explorer.map = new DesignMap(queues.background, {
    settings: () => settings.copy(),
    fields: explorer.fields,
    figures: () => explorer.figures,
    onSelect: (pairs) => {
      for (const [path, text] of pairs) settings.set.set(path, text);
      explorer.lastChangedField = pairs[0][0];
      simulate(explorer);
    },
    onChange: () => scheduleLinkUpdate(explorer),
    isVisible: () => explorer.tabs.shown() === "panel-map",
  });
  const { map } = explorer.initialState;
  if (map) {
    Object.assign(explorer.map.axes, { x: map[0], y: map[1] });
    explorer.map.criterion = map[2] ?? "";
  }
  explorer.statics = new Statics(queues.background, byId("panel-statics"), { settings: () => settings, isVisible: () => explorer.tabs.shown() === "panel-statics" });
  connectExplorerControls(explorer);
  // An address with a map opens the map.
  if (map) explorer.tabs.show("panel-map");
}

// Retains the present run as reference run A.
function keepReference(explorer) {
  if (!explorer.run || explorer.problems.length > 0) return;
  explorer.reference = { scene: explorer.runScene, figures: explorer.figures, verdict: explorer.verdict, run: { ...explorer.run, index: 1, label: "A", isReference: true, visible: true, trusted_s: explorer.run.trusted_s } };
  refreshComparison(explorer);
}

function dropReference(explorer) {
  explorer.reference = null;
  refreshComparison(explorer);
}

function refreshComparison(explorer) {
  updatePlayback(explorer);
  refreshVisibleTab(explorer);
  explorer.strip.show(explorer.figures, explorer.reference?.figures ?? null);
  updateButtons(explorer);
  scheduleLinkUpdate(explorer);
}

// Exchanges the reference run and the present run.
function swapReference(explorer) {
  if (!explorer.reference) return;
  const { scene } = explorer.reference;
  keepReference(explorer);
  explorer.loadScene(scene);
}

// Simulates the reference run of an address.
async function restoreReference(explorer, scene) {
  explorer.initialState.reference = null;
  const reply = await explorer.queues.live.request("kept", { ask: "run", scene: { file: scene.file, text: scene.text }, set: scene.set });
  const { playback: rawRun, figures } = reply?.response ?? {};
  if (!rawRun) return;
  const run = decodeRun(rawRun, 1, rawRun.columns.map(([offset, length]) => reply.data.subarray(offset, offset + length)));
  explorer.reference = { scene, figures, verdict: null, run: { ...run, index: 1, label: "A", isReference: true, visible: true } };
  refreshComparison(explorer);
}

startExplorer();
