// Sliders and texts for everything a scene has: the design variables first, the rest folded by section.

// A slider moves by so many of its steps with shift.
const COARSE = 10;
// Characters for which an entry beside its name has room.
const SHORT = 11;
// Characters of a list for which a line of its own has room.
const LINE = 30;

class Fields {
  // `put(path, text)` sets a field, `null` as the scene has it; `hint(key)` hears which one is under a hand.
  constructor(holder, { put, hint }) {
    Object.assign(this, { holder, put, hint });
    this.rows = new Map();
    this.ranges = new Map();
    this.groups = [];
    this.filter = "";
    this.changedOnly = false;
  }

  // Takes the fields as they are; `base` is those of the scene alone, `set` what is set on top.
  show({ fields, design }, base, set) {
    const form = JSON.stringify([design, fields.map(({ path, kind }) => [path, kind])]);
    if (form !== this.form) this.build(fields, design);
    this.form = form;
    this.base = new Map(base.fields.map((field) => [field.path, field]));
    for (const field of fields) this.update(this.rows.get(field.path), field, set);
    this.sift();
  }

  // Another scene: ranges are chosen anew.
  forget() {
    this.ranges.clear();
    this.form = null;
  }

  build(fields, design) {
    const open = new Set(this.groups.filter(({ box }) => box.open).map(({ name }) => name));
    this.rows.clear();
    this.holder.replaceChildren();
    const known = new Map(fields.map((field) => [field.path, field]));
    const first = design.map((path) => known.get(path)).filter(Boolean);
    const sections = new Map(first.length > 0 ? [["Design variables", first]] : []);
    for (const field of fields) {
      if (design.includes(field.path)) continue;
      const name = field.section || "scene";
      if (!sections.has(name)) sections.set(name, []);
      sections.get(name).push(field);
    }
    this.groups = [...sections].map(([name, members], index) => {
      const count = element("span", { class: "count soft" });
      const box = element("details", { class: "group" }, element("summary", {}, element("span", {}, titled(name)), count));
      box.open = index === 0 || open.has(name);
      // Among design variables there are two torques.
      const rows = members.map((field) => this.row(field, index === 0 ? calledShort(field.path) : field.key));
      box.append(...rows.map((row) => row.box));
      this.holder.append(box);
      return { name, box, count, rows };
    });
  }

  // `called` is how the field is called where it stands.
  row(field, called) {
    const { path, key, about } = field;
    const id = `field-${path}`;
    const name = element("label", { for: id, title: `${path}${about ? `: ${about}` : ""}` }, ...breakable(called));
    const what = element("span", { class: "about soft" }, about ?? "");
    const reset = element("button", { type: "button", class: "reset", "aria-label": `${path} as in the scene`, title: "As in the scene" }, "↺");
    const problem = element("p", { class: "problem", id: `${id}-problem`, hidden: "" });
    const row = { path, problem, reset, field };
    row.entry = this.entry(row, field, id);
    row.entry.setAttribute("aria-describedby", problem.id);
    row.box = element("div", { class: "field", "data-path": path }, name, row.entry, reset, problem, what);
    reset.addEventListener("click", () => {
      this.ranges.delete(path);
      this.put(path, null);
    });
    const hinted = (key) => () => this.hint(key);
    row.box.addEventListener("pointerenter", hinted(key));
    row.box.addEventListener("pointerleave", hinted(null));
    row.box.addEventListener("focusin", hinted(key));
    row.box.addEventListener("focusout", hinted(null));
    this.rows.set(path, row);
    return row;
  }

  // What a value is typed into, or chosen from.
  entry(row, field, id) {
    const { path, kind } = field;
    const put = (text) => this.put(path, text);
    if (kind === "word") {
      const words = field.words ?? [];
      const select = element("select", { id }, ...words.map((word) => element("option", { value: word }, word)));
      select.addEventListener("change", () => put(select.value));
      return select;
    }
    if (kind === "flag") {
      const box = element("input", { type: "checkbox", id });
      box.addEventListener("change", () => put(String(box.checked)));
      return box;
    }
    const input = element(kind === "list" ? "textarea" : "input", { type: "text", id, autocomplete: "off", spellcheck: "false", enterkeyhint: "go", placeholder: "not set" });
    // What is being typed is not overwritten by what comes from elsewhere.
    input.addEventListener("input", () => { row.typed = true; });
    const apply = () => {
      const text = input.value.trim();
      row.typed = false;
      if (text === "" || text === row.text) {
        input.value = row.text;
        return;
      }
      // A bare number is in the unit that stood there.
      const bare = row.field.unit && /^[-+−]?[\d.]+(e[-+]?\d+)?$/i.test(text);
      row.text = bare ? asText(text.replace("−", "-"), row.field.unit) : text;
      put(row.text);
    };
    input.addEventListener("change", apply);
    input.addEventListener("keydown", (event) => {
      if (event.key === "Enter") {
        event.preventDefault();
        apply();
      }
      if (event.key !== "Escape") return;
      input.value = row.text;
      row.typed = false;
    });
    return input;
  }

  slider(row) {
    const { path } = row;
    const slider = element("input", { type: "range", step: "any", "data-keys": "own", "aria-label": path });
    const to = (value) => {
      const range = this.ranges.get(path);
      const text = asText(rounded(range, value), range.unit);
      slider.setAttribute("aria-valuetext", text);
      row.entry.value = row.text = text;
      this.put(path, text);
    };
    slider.addEventListener("input", () => to(Number(slider.value)));
    slider.addEventListener("dblclick", () => row.reset.click());
    slider.addEventListener("pointerdown", () => { row.held = true; });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) slider.addEventListener(end, () => { row.held = false; });
    slider.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -COARSE, PageUp: COARSE }[event.key];
      const range = this.ranges.get(path);
      if (event.ctrlKey || event.metaKey || event.altKey || !range) return;
      const end = { Home: range.from, End: range.to }[event.key];
      if (way === undefined && end === undefined) return;
      event.preventDefault();
      const by = (way ?? 0) * (event.shiftKey ? COARSE : 1) * range.step;
      // Next to where the slider stands, as often as a key repeats.
      slider.value = end ?? Math.min(Math.max(rounded(range, Number(slider.value)) + by, range.from), range.to);
      to(Number(slider.value));
    });
    return slider;
  }

  update(row, field, set) {
    row.field = field;
    const { path, value, unit } = field;
    const base = this.base.get(path);
    const changed = set.has(path) && set.get(path) !== base?.text;
    row.changed = changed;
    row.box.classList.toggle("changed", changed);
    row.reset.disabled = !set.has(path);
    row.text = set.get(path) ?? field.text ?? "";
    // Nothing moves under a hand.
    if (!row.held) row.box.classList.toggle("long", field.kind === "list" || row.text.length > SHORT);
    if (field.kind === "list") row.entry.rows = Math.ceil(row.text.length / LINE);
    if (field.kind === "flag") row.entry.checked = value === 1 || value === true || field.text === "true";
    else if (field.kind === "word") choose(row.entry, field.text);
    else if (!row.typed) row.entry.value = row.text;
    if (row.slider) row.slider.hidden = !isNumeric(field);
    if (!isNumeric(field)) return;
    if (!row.slider) {
      row.slider = this.slider(row);
      row.problem.before(row.slider);
    }
    const range = this.ranges.get(path);
    if (!range || range.unit !== unit || value < range.from || value > range.to) {
      const about = base && base.unit === unit && Number.isFinite(base.value) ? rangeOf(field, base.value) : null;
      this.ranges.set(path, about && value >= about.from && value <= about.to ? about : rangeOf(field));
    }
    const { from, to } = this.ranges.get(path);
    Object.assign(row.slider, { min: from, max: to });
    if (!row.held) row.slider.value = value;
    row.slider.setAttribute("aria-valuetext", row.text);
  }

  // Whether a field is in sight, or would be if it were scrolled to.
  isSeen(path) {
    const box = this.rows.get(path)?.box;
    return Boolean(box && box.offsetWidth > 0 && box.parentElement.open);
  }

  // Marks the field that is wrong, if any, and says there why unless that is said elsewhere.
  wrong(path, problem) {
    for (const row of this.rows.values()) {
      const here = row.path === path;
      row.problem.hidden = !here || !problem;
      row.problem.textContent = here && problem ? [problem.message, problem.help].filter(Boolean).join(": ") : "";
      row.entry.toggleAttribute("aria-invalid", here);
    }
  }

  // Shows what is looked for, and how many there are.
  sift() {
    const words = this.filter.toLowerCase().split(/\s+/).filter(Boolean);
    for (const { box, count, rows } of this.groups) {
      let [shown, changed] = [0, 0];
      for (const row of rows) {
        const text = `${row.path} ${row.field.about ?? ""}`.toLowerCase();
        row.box.hidden = !words.every((word) => text.includes(word)) || this.changedOnly && !row.changed;
        shown += row.box.hidden ? 0 : 1;
        changed += row.changed ? 1 : 0;
      }
      box.hidden = shown === 0;
      if ((words.length > 0 || this.changedOnly) && shown > 0) box.open = true;
      const all = shown < rows.length ? `${shown} of ${rows.length}` : String(rows.length);
      count.textContent = changed > 0 ? `${all}, ${changed} changed` : all;
    }
  }

  // The fields a map may go over: `{ path, range }`, design variables first.
  numeric() {
    return [...this.rows.values()].filter(({ slider, field }) => slider && isNumeric(field)).map(({ path }) => ({ path, range: this.ranges.get(path) }));
  }
}

// A name that may go on in another line behind each "_".
const breakable = (name) => name.split(/(?<=_)/).flatMap((part, index) => (index > 0 ? [element("wbr"), part] : [part]));

// Chooses a word; one that is not among those known is added.
function choose(select, word) {
  if (word !== undefined && ![...select.options].some((option) => option.value === word)) select.append(element("option", { value: word }, word));
  select.value = word;
}

// "design.base" → "base", "motor.torque" → "motor torque", "contact.friction.mu_static" → "friction mu_static".
const calledShort = (path) => path.replace(/^design\./, "").split(".").slice(-2).join(" ");

// "contact.friction" → "Contact: friction".
function titled(section) {
  const text = section.replaceAll("_", " ").replaceAll(".", ": ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}
