// The states of the grasped object: one bar per run along its time axis, with a legend of the states that occur.

const STATES = {
  gripped: "contacts of the hand press on the object from all sides",
  carried: "the hand touches the object, and nothing else does",
  resting: "something else touches the object",
  free: "nothing touches the object",
  released: "after the release, the grasp is not judged",
};

function showStates(playback) {
  const { runs, start, end, timeFormat } = playback;
  const container = byId("states");
  const judged = runs.filter((run) => run.grasp);
  container.hidden = judged.length === 0;
  const bars = judged.map((run) => stateBar(run, start, end, timeFormat, runs.length > 1));
  const occurring = Object.keys(STATES).filter((name) => judged.some((run) => run.grasp.states.some((state) => state.name === name)));
  const entries = occurring.map((name) => element("span", { class: "entry", title: STATES[name] }, element("span", { class: `swatch ${name}` }), name));
  container.replaceChildren(...bars, element("div", { class: "legend soft" }, ...entries));
  // A label that does not fit would be cut off; the legend and the description name the part.
  for (const part of container.querySelectorAll(".part")) if (part.scrollWidth > part.clientWidth) part.textContent = "";
}

// One bar. Its description lists all states with their times, because colours and short parts may not be seen.
function stateBar(run, start, end, timeFormat, isLabelled) {
  const runEnd = run.time[run.samples - 1];
  const texts = [];
  const parts = run.grasp.states.map(({ from_s: from, name }, index, all) => {
    const to = all[index + 1]?.from_s ?? runEnd;
    const fraction = (to - from) / (end - start);
    const text = `${name} from ${formatTime(from, timeFormat)} to ${formatTime(to, timeFormat)}`;
    texts.push(text);
    const part = element("span", { class: `part ${name}`, title: `${text}: ${STATES[name]}` }, name);
    Object.assign(part.style, { left: `${100 * (from - start) / (end - start)}%`, width: `${100 * fraction}%` });
    return part;
  });
  const label = isLabelled ? `${run.label}: ` : "";
  return element("div", { class: "bar", role: "img", "aria-label": `${label}object ${texts.join(", ")}`, title: run.label }, ...parts);
}
