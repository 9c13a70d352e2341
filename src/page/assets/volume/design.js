// The facts of the design that is under the pointer or selected.

// Formats a value with four digits.
function formatFact(value, factor, unit) {
  const displayed = value * factor;
  const digits = Math.max(0, 3 - Math.floor(Math.log10(Math.max(Math.abs(displayed), 1e-3))));
  return `${withMinusSign(displayed.toFixed(Math.min(digits, 4)))}\u202f${unit}`;
}

// Formats a base without trailing zeros.
const baseText = (base) => `${Number((base.base_m * 1e3).toPrecision(7))}\u202fmm`;

function factTable(facts) {
  const body = element("tbody");
  for (const [name, text] of facts) body.append(element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, text)));
  return element("table", { class: "facts" }, body);
}

// The facts of a design: all quantities for one base, the selected quantity of each base for the intersection.
function designFacts(app, cell) {
  const { data, friction, quantity } = app;
  const point = data.index(cell);
  const [l21, phi22, arm] = data.axes.map((axis, k) => formatAxisValue(axis, axis.values[cell[k]]));
  const position = [["l21 fraction", l21], ["φ22", phi22], ["r_l", arm]];
  const base = data.bases[app.base];
  if (!base) {
    const valueByBase = data.bases.map((otherBase) => {
      const name = `at ${baseText(otherBase)}`;
      if (otherBase.reason[point]) return [name, "no finger"];
      const flags = otherBase.frictions[friction].flags[point];
      if (!(flags & STABLE)) return [name, "not stable"];
      if (quantity.flag) return [name, flags & CLOSED ? "closed" : "not closed"];
      return [name, formatFact(getColumn(otherBase, friction, quantity.column)[point], quantity.factor, quantity.unit)];
    });
    return { position, valueByBase, flags: app.volume.flags[point], hasFinger: app.volume.hasFinger[point] === 1 };
  }
  if (base.reason[point]) return { position, reason: base.reasons[base.reason[point] - 1] };
  const value = (name, factor, unit) => formatFact(getColumn(base, friction, name)[point], factor, unit);
  return {
    position,
    hasFinger: true,
    flags: base.frictions[friction].flags[point],
    lengths: [
      ["l11", value("l11_m", 1e3, "mm")],
      ["l12", value("l12_m", 1e3, "mm")],
      ["l21", value("l21_m", 1e3, "mm")],
      ["l22", value("l22_m", 1e3, "mm")],
      ["t22", value("t22_m", 1e3, "mm")],
      ["mass", value("mass_kg", 1e3, "g")],
    ],
    forces: [
      ["motor τ11", value("motor_n_m", 1e3, "N·mm")],
      ["spring k_s", value("spring_n_m", 1e3, "N·mm")],
      ["force F21", value("static_f21_n", 1, "N")],
      ["force F22", value("static_f22_n", 1, "N")],
      ["palm PFP", value("static_pfp_n", 1, "N")],
    ],
  };
}

function showDesign(app, box) {
  const cell = app.hover ?? app.selectedCell;
  const key = JSON.stringify([cell, app.base, app.friction, app.quantity.key]);
  if (box.dataset.shown === key) return;
  box.dataset.shown = key;
  if (!cell) {
    box.replaceChildren(element("p", { class: "soft" }, "Point at a cell of the volume, or press l, p or r to select one."));
    return;
  }
  const facts = designFacts(app, cell);
  if (facts.reason !== undefined) {
    box.replaceChildren(factTable(facts.position), element("p", {}, `There is no such finger: ${facts.reason}`));
    return;
  }
  const verdict = element("p", { class: "verdict" });
  const addVerdict = (isGood, goodText, badText) => verdict.append(element("span", isGood ? {} : { class: "no" }, isGood ? goodText : badText));
  if (facts.hasFinger) {
    addVerdict(facts.flags & STABLE, "stable", "not stable");
    addVerdict(facts.flags & PALM, "PFP ≥ 0", "PFP < 0");
    addVerdict(facts.flags & CLOSED, "form-closed", "not form-closed");
  } else {
    addVerdict(false, "", "no finger at every base");
  }
  const tables = facts.valueByBase ? [factTable(facts.position), factTable(facts.valueByBase)] : [factTable([...facts.position, ...facts.forces]), factTable(facts.lengths)];
  const pair = element("div", { class: "facts-pair" }, ...tables);
  box.replaceChildren(verdict, pair);
}
