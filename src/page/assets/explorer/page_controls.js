// Controls of the explorer's page: choice of a scene, buttons, warnings, title, address.

// Symbols of fields in the drawing of the linkage.
const SAME_NAME_SYMBOLS = ["base", "l11", "l12", "l21", "l22", "t22", "w", "q11", "q21"].map((name) => [name, name]);
const FIELD_SYMBOLS = new Map([...SAME_NAME_SYMBOLS, ["phi22", "φ22"], ["l21_fraction", "l21"], ["arm_ratio", "l22"], ["width", "w"]]);
const EXPLORER_KEY_HELP = [
  [["Ctrl z", "Ctrl Shift z"], "undo, redo"],
  [["k"], "keep this run as A for comparison"],
  [["/"], "find a field"],
  [["←", "→"], "on a slider: one step, with shift ten steps"],
];

// The path of the scene; for the text of a preset, the path of the preset.
const scenePath = ({ presets, settings: { file, text } }) => presets.find((each) => each.text === text)?.file ?? file;

// Fills the list of presets.
function connectPresets(explorer) {
  const select = byId("preset");
  const groups = new Map();
  for (const { file, name, title, group } of explorer.presets) {
    if (!groups.has(group)) groups.set(group, element("optgroup", { label: PRESET_GROUP_TITLES[group] ?? group }));
    groups.get(group).append(element("option", { value: file, title: title ?? "" }, name));
  }
  select.append(...groups.values());
  selectOption(select, scenePath(explorer));
  select.addEventListener("change", () => explorer.loadPreset(select.value));
}

// Shows problems once: next to the field if it is visible, otherwise as a warning on the page. The last valid results
// remain, dimmed and without a verdict.
function showProblems(explorer, problems) {
  explorer.problems = problems;
  document.body.classList.toggle("wrong", problems.length > 0);
  const [first, ...others] = problems;
  const path = first && (problems.find(({ field }) => explorer.fields?.rows.has(field))?.field ?? explorer.lastChangedField);
  const isShownAtField = first && others.length === 0 && explorer.fields?.isVisible(path);
  explorer.fields?.markInvalid(path, isShownAtField ? first : null);
  showWarning(isShownAtField ? [] : problems);
  if (!first) return;
  explorer.verdict = null;
  if (explorer.app) showVerdict({ verdict: "wrong", text: "The settings are not a valid scene; the results of the last valid scene are shown." });
}

// Shows a warning on the page.
function showWarning(problems) {
  const box = byId("warning");
  box.hidden = problems.length === 0;
  const paragraphs = problems.map(({ message, help, line }) => element("p", {}, element("strong", {}, message), ...(line ? [` (line ${line})`] : []), ...(help ? [`: ${help}`] : [])));
  box.replaceChildren(...paragraphs);
}

function showTitle(explorer, { name, description }) {
  const titleText = name || explorer.settings.file;
  if (document.title !== titleText) document.title = titleText;
  setText("name", titleText);
  setText("description", description ?? "");
  selectOption(byId("preset"), scenePath(explorer));
  explorer.app.name = titleText;
}

// Updates the states of the buttons.
function updateButtons(explorer) {
  const { settings, reference } = explorer;
  byId("undo").disabled = settings.past.length === 0;
  byId("redo").disabled = settings.future.length === 0;
  byId("reset-all").disabled = settings.set.size === 0;
  for (const id of ["swap", "drop"]) byId(id).disabled = !reference;
  setText("kept-note", reference ? describeChanges(explorer) : "Keep a run as A; later changes are run B, which is overlaid on it.");
}

// Describes the differences between A and B.
function describeChanges({ settings, reference }) {
  if (reference.scene.text !== settings.text) return `A is ${reference.scene.file}, B is ${settings.file}.`;
  const [referenceValues, currentValues] = [new Map(reference.scene.set), settings.set];
  const paths = [...new Set([...referenceValues.keys(), ...currentValues.keys()])].filter((path) => referenceValues.get(path) !== currentValues.get(path));
  const changes = paths.map((path) => `${path}: ${referenceValues.get(path) ?? "as in the scene"} → ${currentValues.get(path) ?? "as in the scene"}`);
  return changes.length > 0 ? `From A to B: ${changes.join("; ")}.` : "B is equal to A.";
}

// Connects the controls of the explorer.
function connectExplorerControls(explorer) {
  const { fields } = explorer;
  const onClick = (id, action) => byId(id).addEventListener("click", action);
  onClick("undo", explorer.undo);
  onClick("redo", explorer.redo);
  onClick("keep", () => keepReference(explorer));
  onClick("swap", () => swapReference(explorer));
  onClick("drop", () => dropReference(explorer));
  onClick("reset-all", () => explorer.loadScene({ ...explorer.settings.copy(), set: [] }));
  byId("filter").addEventListener("input", ({ target }) => {
    fields.filter = target.value;
    fields.applyFilter();
  });
  byId("changed-only").addEventListener("change", ({ target }) => {
    fields.changedOnly = target.checked;
    fields.applyFilter();
  });
  onClick("scene-show", async () => {
    const reply = await explorer.queues.live.request("toml", explorer.settings.request("toml"));
    if (reply?.response.text) byId("scene").value = reply.response.text;
  });
  onClick("scene-take", () => {
    const text = byId("scene").value;
    if (text.trim() !== "") explorer.loadScene({ file: "own.toml", text, set: [] });
  });
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || event.altKey) return;
    // Text inputs have their own undo.
    if (event.target.matches("textarea, input[type='search'], input[type='text']")) return;
    event.preventDefault();
    if (event.shiftKey) explorer.redo();
    else explorer.undo();
  });
  addEventListener("hashchange", async () => {
    const { scene, reference, time_s, error } = await decodeFragment(location.hash, explorer.page);
    if (error) showWarning([{ message: error }]);
    if (scene && !isSameScene(scene, explorer.settings.copy())) explorer.loadScene(scene);
    if (reference) await restoreReference(explorer, reference);
    if (time_s !== null) {
      explorer.app.pause();
      explorer.app.seek(time_s);
    }
  });
}

// Opens a scene file that is chosen or dropped on the page.
function connectFileInputs(explorer) {
  const loadFile = async (file) => {
    if (file?.size > explorer.page.largest_scene_bytes) showWarning([{ message: tooLongMessage(file.name, explorer.page) }]);
    else if (file) explorer.loadScene({ file: file.name, text: await file.text(), set: [] });
  };
  byId("scene-file").addEventListener("change", ({ target }) => loadFile(target.files[0]));
  const isFile = (event) => event.dataTransfer.types.includes("Files");
  document.addEventListener("dragover", (event) => isFile(event) && event.preventDefault());
  document.addEventListener("drop", (event) => {
    if (!isFile(event)) return;
    event.preventDefault();
    loadFile(event.dataTransfer.files[0]);
  });
}

const currentFragment = (explorer) => encodeFragment({
  scene: explorer.settings.committed,
  reference: explorer.reference?.scene,
  time_s: explorer.app.clock.playing || explorer.pausedByEdit ? NaN : explorer.app.clock.time,
  map: explorer.map?.axes.x && explorer.tabs.shown() === "panel-map" ? [explorer.map.axes.x, explorer.map.axes.y, explorer.map.criterion] : null,
}, explorer.presets);

// Updates the address after a delay, because browsers reject frequent changes.
function scheduleLinkUpdate(explorer) {
  clearTimeout(explorer.linkTimer);
  if (explorer.app.clock.playing) return;
  explorer.linkTimer = setTimeout(async () => {
    const fragment = await currentFragment(explorer);
    if (fragment === explorer.linkedFragment) return;
    explorer.linkedFragment = fragment;
    try {
      history.replaceState(null, "", fragment);
    } catch {
      // The page works without the link.
    }
  }, 300);
}
