// The parts of the explorer's page that are no film: the choice of a scene, buttons, warnings, the title, the address.

// The letters of variables in the drawing of the linkage.
const SAME = ["base", "l11", "l12", "l21", "l22", "t22", "w", "q11", "q21"].map((each) => [each, each]);
const LETTERS = new Map([...SAME, ["phi22", "φ22"], ["l21_fraction", "l21"], ["arm_ratio", "l22"], ["width", "w"]]);
const EXPLORER_KEYS = [
  [["Ctrl z", "Ctrl Shift z"], "undo, redo"],
  [["k"], "keep this run as A, to compare with"],
  [["/"], "find a field"],
  [["←", "→"], "on a slider: a step; with shift ten"],
];

// The file of the scene: of one that comes with the page, as it is there.
const nameOf = ({ presets, setting: { file, text } }) => presets.find((each) => each.text === text)?.file ?? file;

// The list of scenes that come with the page.
function chooser(lab) {
  const select = byId("preset");
  const groups = new Map();
  for (const { file, name, title, group } of lab.presets) {
    if (!groups.has(group)) groups.set(group, element("optgroup", { label: HEADINGS[group] ?? group }));
    groups.get(group).append(element("option", { value: file, title: title ?? "" }, name));
  }
  select.append(...groups.values());
  choose(select, nameOf(lab));
  select.addEventListener("change", () => lab.preset(select.value));
}

// What is wrong, said once: beside its field where that is seen, otherwise over the page. The last good results stay, pale, and are no longer those
// of a check.
function wrong(lab, problems) {
  lab.wrong = problems;
  document.body.classList.toggle("wrong", problems.length > 0);
  const [first, ...others] = problems;
  const path = first && (problems.find(({ field }) => lab.fields?.rows.has(field))?.field ?? lab.last);
  const beside = first && others.length === 0 && lab.fields?.isSeen(path);
  lab.fields?.wrong(path, beside ? first : null);
  warn(beside ? [] : problems);
  if (!first) return;
  lab.verdict = null;
  if (lab.app) showVerdict({ verdict: "wrong", text: "What is set is no scene; these results are the last ones." });
}

// Says it over the page.
function warn(problems) {
  const box = byId("warning");
  box.hidden = problems.length === 0;
  const said = problems.map(({ message, help, line }) => element("p", {}, element("strong", {}, message), ...(line ? [` (line ${line})`] : []), ...(help ? [`: ${help}`] : [])));
  box.replaceChildren(...said);
}

function title(lab, { name, description }) {
  const words = name || lab.setting.file;
  if (document.title !== words) document.title = words;
  put("name", words);
  put("description", description ?? "");
  choose(byId("preset"), nameOf(lab));
  lab.app.name = words;
}

// Brings the buttons up to date.
function buttons(lab) {
  const { setting, kept } = lab;
  byId("undo").disabled = setting.past.length === 0;
  byId("redo").disabled = setting.future.length === 0;
  byId("reset-all").disabled = setting.set.size === 0;
  for (const id of ["swap", "drop"]) byId(id).disabled = !kept;
  put("kept-note", kept ? keptWords(lab) : "Keep a run as A: what is changed afterwards is B, drawn over it.");
}

// What B differs in from A.
function keptWords({ setting, kept }) {
  if (kept.scene.text !== setting.text) return `A is ${kept.scene.file}, B is ${setting.file}.`;
  const [before, now] = [new Map(kept.scene.set), setting.set];
  const paths = [...new Set([...before.keys(), ...now.keys()])].filter((path) => before.get(path) !== now.get(path));
  const said = paths.map((path) => `${path}: ${before.get(path) ?? "as in the scene"} → ${now.get(path) ?? "as in the scene"}`);
  return said.length > 0 ? `From A to B: ${said.join("; ")}.` : "B is the same as A so far.";
}

// What is pressed and typed.
function controlsOf(lab) {
  const { fields } = lab;
  const click = (id, action) => byId(id).addEventListener("click", action);
  click("undo", lab.undo);
  click("redo", lab.redo);
  click("keep", () => keep(lab));
  click("swap", () => swap(lab));
  click("drop", () => drop(lab));
  click("reset-all", () => lab.take({ ...lab.setting.copy(), set: [] }));
  byId("filter").addEventListener("input", ({ target }) => {
    fields.filter = target.value;
    fields.sift();
  });
  byId("changed-only").addEventListener("change", ({ target }) => {
    fields.changedOnly = target.checked;
    fields.sift();
  });
  click("scene-show", async () => {
    const heard = await lab.lines.live.ask("toml", lab.setting.asks("toml"));
    if (heard?.answer.text) byId("scene").value = heard.answer.text;
  });
  click("scene-take", () => {
    const text = byId("scene").value;
    if (text.trim() !== "") lab.take({ file: "own.toml", text, set: [] });
  });
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || event.altKey) return;
    // In a text that is being typed these keys undo letters.
    if (event.target.matches("textarea, input[type='search'], input[type='text']")) return;
    event.preventDefault();
    if (event.shiftKey) lab.redo();
    else lab.undo();
  });
  addEventListener("hashchange", async () => {
    const { scene, kept, time_s, refused } = await stateOf(location.hash, lab.page);
    if (refused) warn([{ message: refused }]);
    if (scene && !same(scene, lab.setting.copy())) lab.take(scene);
    if (kept) await keptAgain(lab, kept);
    if (time_s !== null) {
      lab.app.pause();
      lab.app.seek(time_s);
    }
  });
}

// A scene of one's own, from a file that is chosen or dropped on the page.
function openable(lab) {
  const take = async (file) => {
    if (file?.size > lab.page.largest_scene_bytes) warn([{ message: tooLong(file.name, lab.page) }]);
    else if (file) lab.take({ file: file.name, text: await file.text(), set: [] });
  };
  byId("scene-file").addEventListener("change", ({ target }) => take(target.files[0]));
  const isFile = (event) => event.dataTransfer.types.includes("Files");
  document.addEventListener("dragover", (event) => isFile(event) && event.preventDefault());
  document.addEventListener("drop", (event) => {
    if (!isFile(event)) return;
    event.preventDefault();
    take(event.dataTransfer.files[0]);
  });
}

const addressNow = (lab) => fragmentOf({
  scene: lab.setting.settled,
  kept: lab.kept?.scene,
  time_s: lab.app.clock.playing || lab.held ? NaN : lab.app.clock.time,
  map: lab.map?.axes.x && lab.tabs.shown() === "panel-map" ? [lab.map.axes.x, lab.map.axes.y, lab.map.criterion] : null,
}, lab.presets);

// The address follows when nothing moves: browsers refuse addresses that change all the time.
function linkSoon(lab) {
  clearTimeout(lab.linking);
  if (lab.app.clock.playing) return;
  lab.linking = setTimeout(async () => {
    const fragment = await addressNow(lab);
    if (fragment === lab.linked) return;
    lab.linked = fragment;
    try {
      history.replaceState(null, "", fragment);
    } catch {
      // The link is a convenience: the page is whole without it.
    }
  }, 300);
}
