// The samples: base64 columns → arrays, one a quantity and run.

// Columns are little-endian, as every machine with a browser is.
function decoded(text) {
  const bytes = Uint8Array.from(atob(text), (char) => char.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

// A run with arrays in place of column numbers. A column that is one number long does not change.
function runOf(raw, index, columns = raw.columns.map(decoded)) {
  const column = (number) => {
    const values = columns[number];
    return values.length === raw.samples ? values : new Float64Array(raw.samples).fill(values[0]);
  };
  const withColumns = (object, names) => {
    const out = { ...object };
    for (const name of names) out[name] = column(object[name]);
    return out;
  };
  const contact = ["gap_m", "gap_rate_m_s", "normal_n", "tangential_n", "point_x_m", "point_y_m", "normal_x", "normal_y"];
  return {
    index,
    label: raw.label,
    visible: true,
    samples: raw.samples,
    recorded: raw.recorded,
    time: column(raw.time_s),
    bodies: raw.bodies.map((body) => withColumns(body, ["x_m", "y_m", "angle_rad", "vx_m_s", "vy_m_s", "spin_rad_s"])),
    contacts: raw.contacts.map((each) => withColumns(each, contact)),
    panels: raw.panels.map((panel) => ({ ...panel, series: panel.series.map((each) => withColumns(each, each.rates === undefined ? ["values"] : ["values", "rates"])) })),
    events: raw.events,
    arrowPerNewton: raw.arrow_m_per_n,
    longestArrow: raw.longest_arrow_m,
    extent: raw.extent_m,
  };
}

// The film in the page.
function loaded() {
  const { runs } = JSON.parse(document.getElementById("data").textContent);
  return filmOf(runs.map((raw, index) => runOf(raw, index)).filter((run) => run.samples > 0));
}

// Everything a page knows: runs, the span of time they cover together, all events in order.
function filmOf(runs) {
  const start = Math.min(...runs.map((run) => run.time[0]));
  const end = Math.max(...runs.map((run) => run.time[run.samples - 1]));
  const events = runs.flatMap((run) => run.events.map((event) => ({ ...event, run })));
  events.sort((a, b) => a.time_s - b.time_s || a.run.index - b.run.index);
  return { runs, events, start, end: Math.max(end, start + 1e-12), unit: timeUnit(end, finest(runs)) };
}

// Shortest time between two samples that differ.
function finest(runs) {
  let least = Infinity;
  for (const run of runs) {
    for (let i = 1; i < run.samples; i++) {
      const step = run.time[i] - run.time[i - 1];
      if (step > 0 && step < least) least = step;
    }
  }
  return Number.isFinite(least) ? least : 1e-3;
}
