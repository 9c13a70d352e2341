// One design in words: what is under the pointer, or what was chosen.

// A value in the unit people use, in four digits.
function fact(value, factor, unit) {
  const shown = value * factor;
  const digits = Math.max(0, 3 - Math.floor(Math.log10(Math.max(Math.abs(shown), 1e-3))));
  return `${minus(shown.toFixed(Math.min(digits, 4)))}\u202f${unit}`;
}

// A base as it was asked for, without needless zeros.
const baseText = (base) => `${Number((base.base_m * 1e3).toPrecision(7))}\u202fmm`;

function rows(facts) {
  const body = element("tbody");
  for (const [name, text] of facts) body.append(element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, text)));
  return element("table", { class: "facts" }, body);
}

// What is known of a design: at one base everything, of the intersection the value of each base.
function designFacts(app, cell) {
  const { data, friction, quantity } = app;
  const n = data.index(cell);
  const [l21, phi22, arm] = data.axes.map((axis, k) => axisText(axis, axis.values[cell[k]]));
  const place = [["l21 fraction", l21], ["φ22", phi22], ["r_l", arm]];
  const base = data.bases[app.base];
  if (!base) {
    const each = data.bases.map((own) => {
      const name = `at ${baseText(own)}`;
      if (own.reason[n]) return [name, "no finger"];
      const flags = own.frictions[friction].flags[n];
      if (!(flags & STABLE)) return [name, "not stable"];
      if (quantity.flag) return [name, flags & CLOSED ? "closed" : "not closed"];
      return [name, fact(columnOf(own, friction, quantity.column)[n], quantity.factor, quantity.unit)];
    });
    return { place, each, flags: app.volume.flags[n], finger: app.volume.finger[n] === 1 };
  }
  if (base.reason[n]) return { place, reason: base.reasons[base.reason[n] - 1] };
  const value = (name, factor, unit) => fact(columnOf(base, friction, name)[n], factor, unit);
  return {
    place,
    finger: true,
    flags: base.frictions[friction].flags[n],
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
  const cell = app.hover ?? app.at;
  const key = JSON.stringify([cell, app.base, app.friction, app.quantity.key]);
  if (box.dataset.shown === key) return;
  box.dataset.shown = key;
  if (!cell) {
    box.replaceChildren(element("p", { class: "soft" }, "Point at a cell of the volume, or press l, p or r to choose one by keyboard."));
    return;
  }
  const facts = designFacts(app, cell);
  if (facts.reason !== undefined) {
    box.replaceChildren(rows(facts.place), element("p", {}, `There is no such finger: ${facts.reason}`));
    return;
  }
  const verdict = element("p", { class: "verdict" });
  const say = (yes, good, bad) => verdict.append(element("span", yes ? {} : { class: "no" }, yes ? good : bad));
  if (facts.finger) {
    say(facts.flags & STABLE, "stable", "not stable");
    say(facts.flags & PALM, "PFP ≥ 0", "PFP < 0");
    say(facts.flags & CLOSED, "form-closed", "not form-closed");
  } else {
    say(false, "", "no finger at every base");
  }
  const tables = facts.each ? [rows(facts.place), rows(facts.each)] : [rows([...facts.place, ...facts.forces]), rows(facts.lengths)];
  const pair = element("div", { class: "facts-pair" }, ...tables);
  box.replaceChildren(verdict, pair);
}
