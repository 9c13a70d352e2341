// Starts the page of volumes and redraws it on changes.

function main() {
  const data = loadVolumes();
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const app = {
    data,
    base: 0,
    friction: data.mu_static.length - 1,
    quantity: data.quantities[0],
    region: "stable",
    rest: true,
    sameScale: false,
    slices: data.size.map((count) => [0, count - 1]),
    selectedCell: null,
    hover: null,
    dirty: true,
  };
  app.stage = new Stage(byId("stage"), data);
  const requestRedraw = () => { app.dirty = true; };
  const reevaluate = () => {
    app.volume = evaluateVolume(data, app.base, app.friction, app.quantity);
    app.scale = scaleOf(app);
    requestRedraw();
  };

  const wrap = (value, count) => ((value % count) + count) % count;
  app.setBase = (base) => { app.base = base; reevaluate(); };
  app.setFriction = (friction) => { app.friction = friction; reevaluate(); };
  app.setQuantity = (index) => { app.quantity = data.quantities[index]; reevaluate(); };
  app.setRegion = (region) => { app.region = region; requestRedraw(); };
  app.setRest = (rest) => { app.rest = rest; requestRedraw(); };
  app.setSameScale = (sameScale) => { app.sameScale = sameScale; reevaluate(); };
  app.nextBase = (step) => {
    const list = [...data.bases.keys(), ...(data.bases.length > 1 ? [-1] : [])];
    app.setBase(list[wrap(list.indexOf(app.base) + step, list.length)]);
  };
  app.nextFriction = (step) => app.setFriction(wrap(app.friction + step, data.mu_static.length));
  app.nextQuantity = (step) => app.setQuantity(wrap(data.quantities.indexOf(app.quantity) + step, data.quantities.length));
  app.nextRegion = () => {
    const list = Object.keys(REGIONS);
    app.setRegion(list[wrap(list.indexOf(app.region) + 1, list.length)]);
  };
  // The two ends of a range push each other.
  app.setSlice = (axis, side, value) => {
    const other = app.slices[axis][1 - side];
    app.slices[axis] = side === 0 ? [value, Math.max(value, other)] : [Math.min(value, other), value];
    requestRedraw();
  };
  app.allSlices = () => {
    app.slices = data.size.map((count) => [0, count - 1]);
    requestRedraw();
  };
  // Restricts an axis to the slice of the selected design, or restores the full axis.
  app.cut = (axis) => {
    const [from, to] = app.slices[axis];
    const at = (app.selectedCell ?? data.size.map((count) => count >> 1))[axis];
    app.slices[axis] = from === at && to === at ? [0, data.size[axis] - 1] : [at, at];
    requestRedraw();
  };
  app.turn = (turn, tilt) => { app.stage.cube.turnBy(turn, tilt); requestRedraw(); };
  app.zoom = (factor) => { app.stage.cube.zoomBy(factor); requestRedraw(); };
  app.fit = () => { app.stage.cube.zoom = 1; requestRedraw(); };
  app.view = (name) => { app.stage.cube.view(name); requestRedraw(); };
  app.setHover = (cell) => {
    if (JSON.stringify(cell) === JSON.stringify(app.hover)) return;
    app.hover = cell;
    requestRedraw();
  };
  app.choose = (cell) => {
    app.selectedCell = cell;
    app.hover = null;
    requestRedraw();
  };
  app.moveDesign = (axis, step) => {
    const cell = app.selectedCell ?? data.size.map((count) => count >> 1);
    const newCell = [...cell];
    if (app.selectedCell) newCell[axis] = Math.min(Math.max(newCell[axis] + step, 0), data.size[axis] - 1);
    app.choose(newCell);
  };
  app.setTheme = (name) => {
    document.documentElement.dataset.theme = name;
    byId("theme").setAttribute("aria-pressed", name === "dark");
    clearColourCache();
    requestRedraw();
  };
  app.toggleTheme = () => app.setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");

  app.setTheme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => app.setTheme(dark.matches ? "dark" : "light"));
  reevaluate();
  const refresh = connectControls(app);
  connectKeyboard(app);
  setText("source", data.note);
  app.render = () => {
    if (!app.dirty) return;
    app.dirty = false;
    app.stage.draw(app);
    refresh();
  };
  new ResizeObserver(requestRedraw).observe(document.body);
  new ResizeObserver(requestRedraw).observe(app.stage.canvas);
  window.addEventListener("beforeprint", () => {
    app.setTheme("light");
    app.render();
  });
  const frame = () => {
    app.render();
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  window.phalanx = createTestHooks(app);
}

// The colour scale of the present volume, or a common scale of all volumes.
function scaleOf(app) {
  const { data, quantity } = app;
  let [low, high] = [Infinity, -Infinity];
  const include = (volume) => {
    for (let point = 0; point < data.points; point++) {
      if (!volume.hasFinger[point] || !REGIONS.stable(volume.flags[point])) continue;
      low = Math.min(low, volume.values[point]);
      high = Math.max(high, volume.values[point]);
    }
  };
  if (!app.sameScale) include(app.volume);
  else data.bases.forEach((_, base) => data.mu_static.forEach((_, friction) => include(evaluateVolume(data, base, friction, quantity))));
  return new Scale(data.colours, quantity, low, high);
}

// Interface for tests: the state of the page, and the controls as functions.
function createTestHooks(app) {
  const state = () => {
    app.render();
    const { cube, faces } = app.stage;
    const colouredPoints = new Set(faces.filter((face) => face.fill >= 0).map((face) => face.fill));
    return {
      base: app.base,
      friction: app.friction,
      quantity: app.quantity.key,
      region: app.region,
      rest: app.rest,
      slices: app.slices,
      design: app.hover ?? app.selectedCell,
      chosen: app.selectedCell,
      turn_rad: cube.turn,
      tilt_rad: cube.tilt,
      zoom: cube.zoom,
      names_px: app.stage.nameExtents,
      faces: faces.length,
      coloured: colouredPoints.size,
      scale: [app.scale.from, app.scale.to],
      shares: Object.fromEntries(Object.keys(REGIONS).map((region) => [region, regionShare(app.volume, region)])),
    };
  };
  const { setBase, setFriction, setQuantity, setRegion, setRest, setSameScale, setSlice, allSlices, choose, view, zoom, turn, setTheme } = app;
  return Object.freeze({
    state,
    setBase, setFriction, setQuantity, setRegion, setRest, setSameScale, setSlice, allSlices, choose, view, zoom, turn, setTheme,
    size: app.data.size,
    point(cell) {
      const point = app.data.index(cell);
      const base = app.data.bases[app.base];
      const names = [...Object.keys(base.columns), ...Object.keys(base.frictions[app.friction].columns)];
      return {
        flags: base.frictions[app.friction].flags[point],
        reason: base.reason[point] ? base.reasons[base.reason[point] - 1] : null,
        ...Object.fromEntries(names.map((name) => [name, getColumn(base, app.friction, name)[point]])),
      };
    },
    // Position on the screen and colour of a cell.
    toScreen: (cell) => app.stage.cellCentre(cell),
    colour: (cell) => app.scale.colour(app.volume.values[app.data.index(cell)]),
  });
}

main();
