// What a test may look at, and the controls as functions.

function explorerForTests(lab) {
  const { app, setting } = lab;
  const settled = () => (lab.doneStamp === lab.stamp ? Promise.resolve() : new Promise((resolve) => lab.waiting.push({ resolve })));
  const after = (action) => async (...args) => {
    if (action(...args) === false) return;
    await new Promise((resolve) => lab.waiting.push({ resolve }));
  };
  const { state: filmState, ...film } = forTests(app);
  return Object.freeze({
    ...film,
    state: () => ({
      ...filmState(),
      file: setting.file,
      set: [...setting.set],
      fields: Object.fromEntries((lab.known?.fields ?? []).map(({ path, value, unit, text }) => [path, { value, unit, text }])),
      figures: lab.figures,
      kept: lab.kept?.figures ?? null,
      samples: lab.run.samples,
      verdict: lab.verdict,
      cloud: lab.run.cloud?.length ?? 0,
      trusted_s: lab.run.trusted_s ?? null,
      problems: lab.wrong,
      busy: lab.doneStamp !== lab.stamp,
      ms: lab.ms,
      firstPicture_ms: lab.firstPicture_ms,
    }),
    settled,
    set: after(lab.put),
    preset: after(lab.preset),
    undo: after(lab.undo),
    redo: after(lab.redo),
    keep: () => keep(lab),
    swap: after(() => swap(lab)),
    drop: () => drop(lab),
    check: async () => {
      await settled();
      // What is wrong is not checked.
      if (lab.wrong.length > 0) return null;
      if (!lab.verdict) await new Promise((resolve) => lab.waiting.push({ verdict: true, resolve }));
      return lab.verdict;
    },
    url: () => addressNow(lab),
    map: async (x, y, criterion) => {
      await settled();
      lab.tabs.show("panel-map");
      Object.assign(lab.map.axes, { x, y });
      lab.map.criterion = criterion;
      lab.map.renew();
      await lab.map.ready;
      const { grid } = lab.map;
      return { failed: grid.failed, columns: [...grid.columns, ...grid.words], points: grid.points.size };
    },
    mapAt: (i, j) => {
      const { grid, criterion } = lab.map;
      return { x: grid.textAt(grid.x, i), y: grid.textAt(grid.y, j), value: grid.value(criterion, i, j) };
    },
    mapPlace: (i, j) => {
      const box = lab.map.canvas.getBoundingClientRect();
      const place = lab.map.place();
      return [box.left + place.x(i), box.top + place.y(j)];
    },
  });
}
