// Puts the page together and draws it when something has changed.

function main() {
  const data = loaded();
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const app = {
    data,
    base: 0,
    friction: data.mu_static.length - 1,
    quantity: data.quantities[0],
    region: "stable",
    rest: true,
    same: false,
    slices: data.size.map((count) => [0, count - 1]),
    at: null,
    hover: null,
    dirty: true,
  };
  app.stage = new Stage(byId("stage"), data);
  const changed = () => { app.dirty = true; };
  const recount = () => {
    app.volume = volumeOf(data, app.base, app.friction, app.quantity);
    app.scale = scaleOf(app);
    changed();
  };

  const within = (value, count) => ((value % count) + count) % count;
  app.setBase = (base) => { app.base = base; recount(); };
  app.setFriction = (friction) => { app.friction = friction; recount(); };
  app.setQuantity = (index) => { app.quantity = data.quantities[index]; recount(); };
  app.setRegion = (region) => { app.region = region; changed(); };
  app.setRest = (rest) => { app.rest = rest; changed(); };
  app.setSame = (same) => { app.same = same; recount(); };
  app.nextBase = (by) => {
    const list = [...data.bases.keys(), ...(data.bases.length > 1 ? [-1] : [])];
    app.setBase(list[within(list.indexOf(app.base) + by, list.length)]);
  };
  app.nextFriction = (by) => app.setFriction(within(app.friction + by, data.mu_static.length));
  app.nextQuantity = (by) => app.setQuantity(within(data.quantities.indexOf(app.quantity) + by, data.quantities.length));
  app.nextRegion = () => {
    const list = Object.keys(REGIONS);
    app.setRegion(list[within(list.indexOf(app.region) + 1, list.length)]);
  };
  // The two ends of a slice push each other along.
  app.setSlice = (axis, side, value) => {
    const other = app.slices[axis][1 - side];
    app.slices[axis] = side === 0 ? [value, Math.max(value, other)] : [Math.min(value, other), value];
    changed();
  };
  app.allSlices = () => {
    app.slices = data.size.map((count) => [0, count - 1]);
    changed();
  };
  // The slice of the chosen design across one axis, or all of the axis again.
  app.cut = (axis) => {
    const [from, to] = app.slices[axis];
    const at = (app.at ?? data.size.map((count) => count >> 1))[axis];
    app.slices[axis] = from === at && to === at ? [0, data.size[axis] - 1] : [at, at];
    changed();
  };
  app.turn = (turn, tilt) => { app.stage.cube.turnBy(turn, tilt); changed(); };
  app.zoom = (factor) => { app.stage.cube.zoomBy(factor); changed(); };
  app.fit = () => { app.stage.cube.zoom = 1; changed(); };
  app.view = (name) => { app.stage.cube.view(name); changed(); };
  app.setHover = (cell) => {
    if (JSON.stringify(cell) === JSON.stringify(app.hover)) return;
    app.hover = cell;
    changed();
  };
  app.choose = (cell) => {
    app.at = cell;
    app.hover = null;
    changed();
  };
  app.moveDesign = (axis, by) => {
    const cell = app.at ?? data.size.map((count) => count >> 1);
    const moved = [...cell];
    if (app.at) moved[axis] = Math.min(Math.max(moved[axis] + by, 0), data.size[axis] - 1);
    app.choose(moved);
  };
  app.theme = (name) => {
    document.documentElement.dataset.theme = name;
    byId("theme").setAttribute("aria-pressed", name === "dark");
    forgetColours();
    changed();
  };
  app.toggleTheme = () => app.theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");

  app.theme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => app.theme(dark.matches ? "dark" : "light"));
  recount();
  const refresh = controls(app);
  keyboard(app);
  put("source", data.note);
  app.render = () => {
    if (!app.dirty) return;
    app.dirty = false;
    app.stage.draw(app);
    refresh();
  };
  new ResizeObserver(changed).observe(document.body);
  new ResizeObserver(changed).observe(app.stage.canvas);
  window.addEventListener("beforeprint", () => {
    app.theme("light");
    app.render();
  });
  const frame = () => {
    app.render();
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  window.phalanx = forTests(app);
}

// The scale of what is shown, or of all volumes.
function scaleOf(app) {
  const { data, quantity } = app;
  let [low, high] = [Infinity, -Infinity];
  const take = (volume) => {
    for (let n = 0; n < data.points; n++) {
      if (!volume.finger[n] || !REGIONS.stable(volume.flags[n])) continue;
      low = Math.min(low, volume.values[n]);
      high = Math.max(high, volume.values[n]);
    }
  };
  if (!app.same) take(app.volume);
  else data.bases.forEach((_, base) => data.mu_static.forEach((_, friction) => take(volumeOf(data, base, friction, quantity))));
  return new Scale(data.colours, quantity, low, high);
}

// What a test may look at, and the controls as functions.
function forTests(app) {
  const state = () => {
    app.render();
    const { cube, faces } = app.stage;
    const coloured = new Set(faces.filter((face) => face.fill >= 0).map((face) => face.fill));
    return {
      base: app.base,
      friction: app.friction,
      quantity: app.quantity.key,
      region: app.region,
      rest: app.rest,
      slices: app.slices,
      design: app.hover ?? app.at,
      chosen: app.at,
      turn_rad: cube.turn,
      tilt_rad: cube.tilt,
      zoom: cube.zoom,
      names_px: app.stage.names,
      faces: faces.length,
      coloured: coloured.size,
      scale: [app.scale.from, app.scale.to],
      shares: Object.fromEntries(Object.keys(REGIONS).map((region) => [region, shareOf(app.volume, region)])),
    };
  };
  const { setBase, setFriction, setQuantity, setRegion, setRest, setSame, setSlice, allSlices, choose, view, zoom, turn, theme } = app;
  return Object.freeze({
    state,
    setBase, setFriction, setQuantity, setRegion, setRest, setSame, setSlice, allSlices, choose, view, zoom, turn, theme,
    size: app.data.size,
    point(cell) {
      const n = app.data.index(cell);
      const base = app.data.bases[app.base];
      const names = [...Object.keys(base.columns), ...Object.keys(base.frictions[app.friction].columns)];
      return {
        flags: base.frictions[app.friction].flags[n],
        reason: base.reason[n] ? base.reasons[base.reason[n] - 1] : null,
        ...Object.fromEntries(names.map((name) => [name, columnOf(base, app.friction, name)[n]])),
      };
    },
    // Where a cell is on the screen, and the colour it is drawn in.
    place: (cell) => app.stage.middle(cell),
    colour: (cell) => app.scale.colour(app.volume.values[app.data.index(cell)]),
  });
}

main();
