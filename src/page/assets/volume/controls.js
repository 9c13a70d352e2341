// Controls of the page of volumes.

const byId = (id) => document.getElementById(id);

const setText = (id, text) => {
  if (byId(id).textContent !== text) byId(id).textContent = text;
};

function connectControls(app) {
  const { data } = app;
  const addOptions = (id, entries) => byId(id).append(...entries.map(([value, text]) => element("option", { value }, text)));
  addOptions("base", data.bases.map((base, index) => [index, baseText(base)]));
  if (data.bases.length > 1) addOptions("base", [[-1, "all bases at once"]]);
  addOptions("friction", data.mu_static.map((mu, index) => [index, String(mu)]));
  addOptions("quantity", data.quantities.map((quantity, index) => [index, quantity.unit ? `${quantity.name}, ${quantity.unit}` : quantity.name]));
  const onChange = (id, action) => byId(id).addEventListener("change", (event) => action(event.target));
  onChange("base", (target) => app.setBase(Number(target.value)));
  onChange("friction", (target) => app.setFriction(Number(target.value)));
  onChange("quantity", (target) => app.setQuantity(Number(target.value)));
  onChange("region", (target) => app.setRegion(target.value));
  onChange("rest", (target) => app.setRest(target.checked));
  onChange("same", (target) => app.setSameScale(target.checked));
  const onClick = (id, action) => byId(id).addEventListener("click", action);
  for (const name of Object.keys(VIEWS)) onClick(`view-${name}`, () => app.view(name));
  onClick("zoom-in", () => app.zoom(1.25));
  onClick("zoom-out", () => app.zoom(0.8));
  onClick("zoom-fit", app.fit);
  onClick("slices-all", app.allSlices);
  onClick("theme", app.toggleTheme);
  const sliders = data.axes.map((axis, index) => createSlice(app, axis, index));
  byId("slices").append(...sliders.map((slider) => slider.field));
  connectPointers(app);
  return () => {
    byId("base").value = String(app.base);
    byId("friction").value = String(app.friction);
    byId("quantity").value = String(data.quantities.indexOf(app.quantity));
    byId("region").value = app.region;
    byId("rest").checked = app.rest;
    byId("same").checked = app.sameScale;
    for (const slider of sliders) slider.refresh();
    showShares(app);
    showLegend(app);
    setText("pinned", app.selectedCell && !app.hover ? "chosen" : app.hover ? "under the pointer" : "");
    showDesign(app, byId("design"));
  };
}

// Two sliders for the ends of the visible range of an axis.
function createSlice(app, axis, index) {
  const last = axis.values.length - 1;
  const output = element("output", {});
  const field = element("fieldset", { class: "slice" }, element("legend", {}, element("span", {}, axis.name), output));
  const inputs = ["from", "to"].map((end, side) => {
    const input = element("input", { type: "range", min: 0, max: last, step: 1, "aria-label": `${axis.name}: ${end}` });
    input.addEventListener("input", () => app.setSlice(index, side, Number(input.value)));
    input.disabled = last === 0;
    field.append(input);
    return input;
  });
  return {
    field,
    refresh() {
      const [from, to] = app.slices[index];
      inputs[0].value = String(from);
      inputs[1].value = String(to);
      const [a, b] = [from, to].map((at) => formatAxisValue(axis, axis.values[at]));
      inputs[0].setAttribute("aria-valuetext", a);
      inputs[1].setAttribute("aria-valuetext", b);
      const text = from === to ? a : `${a} to ${b}`;
      if (output.textContent !== text) output.textContent = text;
    },
  };
}

function showShares(app) {
  const texts = [["stable", "stable"], ["palm", "with PFP ≥ 0"], ["closed", "form-closed"]];
  const key = `${app.base} ${app.friction}`;
  const body = byId("shares");
  if (body.dataset.shown === key) return;
  body.dataset.shown = key;
  body.replaceChildren(...texts.flatMap(([region, name]) => {
    const share = `${regionShare(app.volume, region).toFixed(2)}\u202f%`;
    return [element("dt", {}, name), element("dd", { "data-region": region }, share)];
  }));
}

function showLegend(app) {
  const { quantity, data, scale } = app;
  const worst = app.base < 0 && !quantity.flag ? ` (${quantity.worst} of all bases)` : "";
  setText("legend-title", (quantity.unit ? `${quantity.name}, ${quantity.unit}` : quantity.name) + worst);
  byId("bar").hidden = Boolean(quantity.flag);
  if (!quantity.flag) drawColourBar(byId("bar"), scale);
  const entries = quantity.flag ? [[data.colours.flag[1], "form-closed"], [data.colours.flag[0], "not form-closed"]] : [];
  const restText = { stable: "not stable: a phalanx would have to pull", palm: "not stable, or PFP < 0", closed: "not stable, or not form-closed" };
  if (app.rest) entries.push(["var(--unstable)", restText[app.region]]);
  if (app.volume.hasFinger.includes(0)) entries.push(["transparent", "empty: no such finger"]);
  const key = JSON.stringify(entries);
  const box = byId("swatches");
  if (box.dataset.shown === key) return;
  box.dataset.shown = key;
  box.replaceChildren(...entries.map(([fill, text]) => element("span", {}, element("i", { style: `background: ${fill}` }), text)));
}

// One pointer rotates the volume; two pointers or the wheel zoom it; hovering shows designs.
function connectPointers(app) {
  const { canvas, cube } = app.stage;
  const pointersDown = new Map();
  let movedDistance = 0;
  const canvasPoint = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointersDown.set(event.pointerId, canvasPoint(event));
    movedDistance = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const point = canvasPoint(event);
    const previousPoint = pointersDown.get(event.pointerId);
    if (!previousPoint) {
      if (event.pointerType !== "touch") app.setHover(app.stage.cellAt(point));
      return;
    }
    const [dx, dy] = [point[0] - previousPoint[0], point[1] - previousPoint[1]];
    movedDistance += Math.hypot(dx, dy);
    if (pointersDown.size === 1) {
      if (movedDistance > 3) app.turn(0.01 * dx, 0.01 * dy);
    } else {
      const [other] = [...pointersDown].filter(([id]) => id !== event.pointerId).map(([, position]) => position);
      const previousDistance = Math.hypot(previousPoint[0] - other[0], previousPoint[1] - other[1]);
      const distance = Math.hypot(point[0] - other[0], point[1] - other[1]);
      if (previousDistance > 5 && distance > 5) app.zoom(distance / previousDistance);
    }
    pointersDown.set(event.pointerId, point);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (pointersDown.size === 1 && movedDistance <= 3) app.choose(app.stage.cellAt(canvasPoint(event)));
    pointersDown.delete(event.pointerId);
  });
  canvas.addEventListener("pointercancel", (event) => pointersDown.delete(event.pointerId));
  canvas.addEventListener("pointerleave", () => app.setHover(null));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    app.zoom(Math.exp(-event.deltaY * 0.002));
  }, { passive: false });
  return cube;
}
