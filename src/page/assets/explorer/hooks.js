// Interface for tests: the state of the explorer, and the controls as functions.

function createExplorerTestHooks(explorer) {
  const { app, settings } = explorer;
  const untilSettled = () => (explorer.finishedRevision === explorer.revision ? Promise.resolve() : new Promise((resolve) => explorer.waiters.push({ resolve })));
  const afterUpdate = (action) => async (...args) => {
    if (action(...args) === false) return;
    await new Promise((resolve) => explorer.waiters.push({ resolve }));
  };
  const { state: playbackState, ...playbackHooks } = createTestHooks(app);
  return Object.freeze({
    ...playbackHooks,
    state: () => ({
      ...playbackState(),
      file: settings.file,
      set: [...settings.set],
      fields: Object.fromEntries((explorer.fieldData?.fields ?? []).map(({ path, value, unit, text }) => [path, { value, unit, text }])),
      figures: explorer.figures,
      reference: explorer.reference?.figures ?? null,
      samples: explorer.run.samples,
      verdict: explorer.verdict,
      variations: explorer.run.variationRuns?.length ?? 0,
      trusted_s: explorer.run.trusted_s ?? null,
      problems: explorer.problems,
      busy: explorer.finishedRevision !== explorer.revision,
      ms: explorer.ms,
      firstPicture_ms: explorer.firstPicture_ms,
    }),
    settled: untilSettled,
    set: afterUpdate(explorer.setField),
    preset: afterUpdate(explorer.loadPreset),
    undo: afterUpdate(explorer.undo),
    redo: afterUpdate(explorer.redo),
    keep: () => keepReference(explorer),
    swap: afterUpdate(() => swapReference(explorer)),
    drop: () => dropReference(explorer),
    check: async () => {
      await untilSettled();
      // Invalid settings are not checked.
      if (explorer.problems.length > 0) return null;
      if (!explorer.verdict) await new Promise((resolve) => explorer.waiters.push({ verdict: true, resolve }));
      return explorer.verdict;
    },
    url: () => currentFragment(explorer),
    map: async (x, y, criterion) => {
      await untilSettled();
      explorer.tabs.show("panel-map");
      Object.assign(explorer.map.axes, { x, y });
      explorer.map.criterion = criterion;
      explorer.map.reload();
      await explorer.map.ready;
      const { grid } = explorer.map;
      return { failed: grid.failed, columns: [...grid.columns, ...grid.words], points: grid.points.size };
    },
    mapAt: (i, j) => {
      const { grid, criterion } = explorer.map;
      return { x: grid.textAt(grid.x, i), y: grid.textAt(grid.y, j), value: grid.value(criterion, i, j) };
    },
    mapPlace: (i, j) => {
      const box = explorer.map.canvas.getBoundingClientRect();
      const layout = explorer.map.layout();
      return [box.left + layout.x(i), box.top + layout.y(j)];
    },
  });
}
