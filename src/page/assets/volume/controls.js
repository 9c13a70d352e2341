// Choices, sliders, pointers.

const byId = (id) => document.getElementById(id);

const put = (id, text) => {
  if (byId(id).textContent !== text) byId(id).textContent = text;
};

function controls(app) {
  const { data } = app;
  const options = (id, entries) => byId(id).append(...entries.map(([value, text]) => element("option", { value }, text)));
  options("base", data.bases.map((base, index) => [index, baseText(base)]));
  if (data.bases.length > 1) options("base", [[-1, "all bases at once"]]);
  options("friction", data.mu_static.map((mu, index) => [index, String(mu)]));
  options("quantity", data.quantities.map((quantity, index) => [index, quantity.unit ? `${quantity.name}, ${quantity.unit}` : quantity.name]));
  const change = (id, action) => byId(id).addEventListener("change", (event) => action(event.target));
  change("base", (target) => app.setBase(Number(target.value)));
  change("friction", (target) => app.setFriction(Number(target.value)));
  change("quantity", (target) => app.setQuantity(Number(target.value)));
  change("region", (target) => app.setRegion(target.value));
  change("rest", (target) => app.setRest(target.checked));
  change("same", (target) => app.setSame(target.checked));
  const click = (id, action) => byId(id).addEventListener("click", action);
  for (const name of Object.keys(VIEWS)) click(`view-${name}`, () => app.view(name));
  click("zoom-in", () => app.zoom(1.25));
  click("zoom-out", () => app.zoom(0.8));
  click("zoom-fit", app.fit);
  click("slices-all", app.allSlices);
  click("theme", app.toggleTheme);
  const sliders = data.axes.map((axis, index) => slice(app, axis, index));
  byId("slices").append(...sliders.map((each) => each.field));
  pointers(app);
  return () => {
    byId("base").value = String(app.base);
    byId("friction").value = String(app.friction);
    byId("quantity").value = String(data.quantities.indexOf(app.quantity));
    byId("region").value = app.region;
    byId("rest").checked = app.rest;
    byId("same").checked = app.same;
    for (const each of sliders) each.refresh();
    shares(app);
    legend(app);
    put("pinned", app.at && !app.hover ? "chosen" : app.hover ? "under the pointer" : "");
    showDesign(app, byId("design"));
  };
}

// Two sliders: where the shown part of an axis begins and ends.
function slice(app, axis, index) {
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
      const [a, b] = [from, to].map((at) => axisText(axis, axis.values[at]));
      inputs[0].setAttribute("aria-valuetext", a);
      inputs[1].setAttribute("aria-valuetext", b);
      const text = from === to ? a : `${a} to ${b}`;
      if (output.textContent !== text) output.textContent = text;
    },
  };
}

function shares(app) {
  const texts = [["stable", "stable"], ["palm", "with PFP ≥ 0"], ["closed", "form-closed"]];
  const key = `${app.base} ${app.friction}`;
  const body = byId("shares");
  if (body.dataset.shown === key) return;
  body.dataset.shown = key;
  body.replaceChildren(...texts.flatMap(([region, name]) => {
    const share = `${shareOf(app.volume, region).toFixed(2)}\u202f%`;
    return [element("dt", {}, name), element("dd", { "data-region": region }, share)];
  }));
}

function legend(app) {
  const { quantity, data, scale } = app;
  const worst = app.base < 0 && !quantity.flag ? ` (${quantity.worst} of all bases)` : "";
  put("legend-title", (quantity.unit ? `${quantity.name}, ${quantity.unit}` : quantity.name) + worst);
  byId("bar").hidden = Boolean(quantity.flag);
  if (!quantity.flag) drawBar(byId("bar"), scale);
  const entries = quantity.flag ? [[data.colours.flag[1], "form-closed"], [data.colours.flag[0], "not form-closed"]] : [];
  const rest = { stable: "not stable: a phalanx would have to pull", palm: "not stable, or PFP < 0", closed: "not stable, or not form-closed" };
  if (app.rest) entries.push(["var(--unstable)", rest[app.region]]);
  if (app.volume.finger.includes(0)) entries.push(["transparent", "left empty: no such finger"]);
  const key = JSON.stringify(entries);
  const box = byId("swatches");
  if (box.dataset.shown === key) return;
  box.dataset.shown = key;
  box.replaceChildren(...entries.map(([fill, text]) => element("span", {}, element("i", { style: `background: ${fill}` }), text)));
}

// One pointer turns the volume, two zoom it, the wheel too; without a button it reads designs.
function pointers(app) {
  const { canvas, cube } = app.stage;
  const down = new Map();
  let moved = 0;
  const inCanvas = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, inCanvas(event));
    moved = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const now = inCanvas(event);
    const before = down.get(event.pointerId);
    if (!before) {
      if (event.pointerType !== "touch") app.setHover(app.stage.pick(now));
      return;
    }
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    moved += Math.hypot(dx, dy);
    if (down.size === 1) {
      if (moved > 3) app.turn(0.01 * dx, 0.01 * dy);
    } else {
      const [other] = [...down].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const apart = Math.hypot(before[0] - other[0], before[1] - other[1]);
      const wide = Math.hypot(now[0] - other[0], now[1] - other[1]);
      if (apart > 5 && wide > 5) app.zoom(wide / apart);
    }
    down.set(event.pointerId, now);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (down.size === 1 && moved <= 3) app.choose(app.stage.pick(inCanvas(event)));
    down.delete(event.pointerId);
  });
  canvas.addEventListener("pointercancel", (event) => down.delete(event.pointerId));
  canvas.addEventListener("pointerleave", () => app.setHover(null));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    app.zoom(Math.exp(-event.deltaY * 0.002));
  }, { passive: false });
  return cube;
}
