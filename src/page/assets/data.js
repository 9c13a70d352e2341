// Decodes the samples: base64 columns → one array per quantity and run.

// Columns are little-endian, like every platform with a browser.
function decodeColumn(text) {
  const bytes = Uint8Array.from(atob(text), (char) => char.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

// Replaces the column numbers of a run by arrays. A column with a single number is constant.
function decodeRun(raw, index, columns = raw.columns.map(decodeColumn)) {
  const column = (number) => {
    const values = columns[number];
    return values.length === raw.samples ? values : new Float64Array(raw.samples).fill(values[0]);
  };
  const withColumns = (item, names) => {
    const out = { ...item };
    for (const name of names) out[name] = column(item[name]);
    return out;
  };
  const contactColumns = ["gap_m", "gap_rate_m_s", "normal_n", "tangential_n", "point_x_m", "point_y_m", "normal_x", "normal_y"];
  return {
    index,
    label: raw.label,
    visible: true,
    samples: raw.samples,
    recorded: raw.recorded,
    time: column(raw.time_s),
    bodies: raw.bodies.map((body) => withColumns(body, ["x_m", "y_m", "angle_rad", "vx_m_s", "vy_m_s", "spin_rad_s"])),
    contacts: raw.contacts.map((item) => withColumns(item, contactColumns)),
    panels: raw.panels.map((panel) => ({ ...panel, series: panel.series.map((item) => withColumns(item, item.rates === undefined ? ["values"] : ["values", "rates"])) })),
    events: raw.events,
    grasp: raw.grasp,
    arrowPerNewton: raw.arrow_m_per_n,
    longestArrow: raw.longest_arrow_m,
    extent: raw.extent_m,
    isTurned: raw.is_turned,
  };
}

// The playback embedded in the page.
function loadPlayback() {
  const { runs } = JSON.parse(document.getElementById("data").textContent);
  return buildPlayback(runs.map((raw, index) => decodeRun(raw, index)).filter((run) => run.samples > 0));
}

// Playback of one or two runs: the runs, their common time span, all events in order.
function buildPlayback(runs) {
  const start = Math.min(...runs.map((run) => run.time[0]));
  const end = Math.max(...runs.map((run) => run.time[run.samples - 1]));
  const events = runs.flatMap((run) => run.events.map((event) => ({ ...event, run })));
  events.sort((a, b) => a.time_s - b.time_s || a.run.index - b.run.index);
  return { runs, events, start, end: Math.max(end, start + 1e-12), timeFormat: chooseTimeFormat(end, shortestStep(runs)) };
}

// Shortest positive time between two samples.
function shortestStep(runs) {
  let shortest = Infinity;
  for (const run of runs) {
    for (let i = 1; i < run.samples; i++) {
      const step = run.time[i] - run.time[i - 1];
      if (step > 0 && step < shortest) shortest = step;
    }
  }
  return Number.isFinite(shortest) ? shortest : 1e-3;
}
