// Sliders and inputs for all fields of a scene: design variables first, the others in collapsed sections. The parts of a
// mechanism, such as its bodies, are collapsed sections within those of their kinds.

// Steps of a slider per key press with shift.
const COARSE_STEPS = 10;
// Maximum length of a value that fits next to its name.
const MAX_SHORT_TEXT = 11;
// Characters per line of a list.
const LIST_LINE_LENGTH = 30;

class FieldList {
  // `setField(path, text)` sets a field; `null` restores the value of the scene. `onHover(key)` receives the field
  // under the pointer or with focus.
  constructor(container, { setField, onHover }) {
    Object.assign(this, { container, setField, onHover });
    this.rows = new Map();
    this.ranges = new Map();
    this.groups = [];
    // The sections that contain other sections, by their name.
    this.kinds = new Map();
    this.filter = "";
    this.changedOnly = false;
  }

  // Shows the fields; `base` contains the fields of the scene alone, `set` the overrides.
  show({ fields, design }, base, set) {
    const layoutKey = JSON.stringify([design, fields.map(({ path, kind }) => [path, kind])]);
    if (layoutKey !== this.layoutKey) this.build(fields, design);
    this.layoutKey = layoutKey;
    this.baseFields = new Map(base.fields.map((field) => [field.path, field]));
    for (const field of fields) this.update(this.rows.get(field.path), field, set);
    this.applyFilter();
  }

  // Discards the ranges for a new scene.
  reset() {
    this.ranges.clear();
    this.layoutKey = null;
  }

  build(fields, design) {
    const openGroups = new Set([...this.groups, ...this.kinds.values()].filter(({ box }) => box.open).map(({ name }) => name));
    this.rows.clear();
    this.container.replaceChildren();
    const fieldsByPath = new Map(fields.map((field) => [field.path, field]));
    const designFields = design.map((path) => fieldsByPath.get(path)).filter(Boolean);
    const sections = new Map(designFields.length > 0 ? [["Design variables", designFields]] : []);
    for (const field of fields) {
      if (design.includes(field.path)) continue;
      const name = field.group.join(".") || field.section || "scene";
      if (!sections.has(name)) sections.set(name, []);
      sections.get(name).push(field);
    }
    this.kinds.clear();
    const section = (name, title, isOpen) => {
      const count = element("span", { class: "count soft" });
      const box = element("details", { class: "group" }, element("summary", {}, element("span", {}, title), count));
      box.open = isOpen || openGroups.has(name);
      return { name, box, count };
    };
    this.groups = [...sections].map(([name, members], index) => {
      const [kind, part] = index > 0 ? members[0].group : [];
      const group = section(name, part ?? sectionTitle(name), index === 0);
      // Design variables include two torques, so their names contain the section.
      group.rows = members.map((field) => this.row(field, index === 0 ? fieldName(field) : nameInGroup(field)));
      group.box.append(...group.rows.map((row) => row.box));
      this.containerOf(kind, section).append(group.box);
      return { ...group, kind };
    });
  }

  // The element with the sections of one kind, or of those without a kind.
  containerOf(kind, section) {
    if (!kind) return this.container;
    if (!this.kinds.has(kind)) {
      const group = section(kind, sectionTitle(kind), false);
      this.kinds.set(kind, group);
      this.container.append(group.box);
    }
    return this.kinds.get(kind).box;
  }

  // Creates the row of a field with the given name.
  row(field, displayName) {
    const { path, key, about } = field;
    const id = `field-${path}`;
    const name = element("label", { for: id, title: `${path}${about ? `: ${about}` : ""}` }, ...breakAfterUnderscores(displayName));
    const description = element("span", { class: "about soft" }, about ?? "");
    const reset = element("button", { type: "button", class: "reset", "aria-label": `Restore ${path}`, title: "Restore the value of the scene" }, "↺");
    const problem = element("p", { class: "problem", id: `${id}-problem`, hidden: "" });
    const row = { path, problem, reset, field };
    row.entry = this.entry(row, field, id);
    row.entry.setAttribute("aria-describedby", problem.id);
    row.box = element("div", { class: "field", "data-path": path }, name, row.entry, reset, problem, description);
    reset.addEventListener("click", () => {
      this.ranges.delete(path);
      this.setField(path, null);
    });
    const notifyHover = (key) => () => this.onHover(key);
    row.box.addEventListener("pointerenter", notifyHover(key));
    row.box.addEventListener("pointerleave", notifyHover(null));
    row.box.addEventListener("focusin", notifyHover(key));
    row.box.addEventListener("focusout", notifyHover(null));
    this.rows.set(path, row);
    return row;
  }

  // Creates the input element of a field.
  entry(row, field, id) {
    const { path, kind } = field;
    const setField = (text) => this.setField(path, text);
    if (kind === "word") {
      const words = field.words ?? [];
      const select = element("select", { id }, ...words.map((word) => element("option", { value: word }, word)));
      select.addEventListener("change", () => setField(select.value));
      return select;
    }
    if (kind === "flag") {
      const box = element("input", { type: "checkbox", id });
      box.addEventListener("change", () => setField(String(box.checked)));
      return box;
    }
    const input = element(kind === "list" ? "textarea" : "input", { type: "text", id, autocomplete: "off", spellcheck: "false", enterkeyhint: "go", placeholder: "not set" });
    // An input that is being edited is not overwritten.
    input.addEventListener("input", () => { row.isEditing = true; });
    const apply = () => {
      const text = input.value.trim();
      row.isEditing = false;
      if (text === "" || text === row.text) {
        input.value = row.text;
        return;
      }
      // A number without a unit has the present unit.
      const isBareNumber = row.field.unit && /^[-+−]?[\d.]+(e[-+]?\d+)?$/i.test(text);
      row.text = isBareNumber ? formatValue(text.replace("−", "-"), row.field.unit) : text;
      setField(row.text);
    };
    input.addEventListener("change", apply);
    input.addEventListener("keydown", (event) => {
      if (event.key === "Enter") {
        event.preventDefault();
        apply();
      }
      if (event.key !== "Escape") return;
      input.value = row.text;
      row.isEditing = false;
    });
    return input;
  }

  slider(row) {
    const { path } = row;
    const slider = element("input", { type: "range", step: "any", "data-keys": "own", "aria-label": path });
    const applyValue = (value) => {
      const range = this.ranges.get(path);
      const text = formatValue(roundToStep(range, value), range.unit);
      slider.setAttribute("aria-valuetext", text);
      row.entry.value = row.text = text;
      this.setField(path, text);
    };
    slider.addEventListener("input", () => applyValue(Number(slider.value)));
    slider.addEventListener("dblclick", () => row.reset.click());
    slider.addEventListener("pointerdown", () => { row.isDragging = true; });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) slider.addEventListener(end, () => { row.isDragging = false; });
    slider.addEventListener("keydown", (event) => {
      const direction = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -COARSE_STEPS, PageUp: COARSE_STEPS }[event.key];
      const range = this.ranges.get(path);
      if (event.ctrlKey || event.metaKey || event.altKey || !range) return;
      const end = { Home: range.from, End: range.to }[event.key];
      if (direction === undefined && end === undefined) return;
      event.preventDefault();
      const increment = (direction ?? 0) * (event.shiftKey ? COARSE_STEPS : 1) * range.step;
      // Relative to the slider, because keys repeat faster than fields are updated.
      slider.value = end ?? Math.min(Math.max(roundToStep(range, Number(slider.value)) + increment, range.from), range.to);
      applyValue(Number(slider.value));
    });
    return slider;
  }

  update(row, field, set) {
    row.field = field;
    const { path, value, unit } = field;
    const base = this.baseFields.get(path);
    const isChanged = set.has(path) && set.get(path) !== base?.text;
    row.isChanged = isChanged;
    row.box.classList.toggle("changed", isChanged);
    row.reset.disabled = !set.has(path);
    row.text = set.get(path) ?? field.text ?? "";
    // The layout does not change while the slider is dragged.
    if (!row.isDragging) row.box.classList.toggle("long", field.kind === "list" || row.text.length > MAX_SHORT_TEXT);
    if (field.kind === "list") row.entry.rows = Math.ceil(row.text.length / LIST_LINE_LENGTH);
    if (field.kind === "flag") row.entry.checked = value === 1 || value === true || field.text === "true";
    else if (field.kind === "word") selectOption(row.entry, field.text);
    else if (!row.isEditing) row.entry.value = row.text;
    if (row.slider) row.slider.hidden = !isNumeric(field);
    if (!isNumeric(field)) return;
    if (!row.slider) {
      row.slider = this.slider(row);
      row.problem.before(row.slider);
    }
    const range = this.ranges.get(path);
    if (!range || range.unit !== unit || value < range.from || value > range.to) {
      const centredRange = base && base.unit === unit && Number.isFinite(base.value) ? sliderRange(field, base.value) : null;
      this.ranges.set(path, centredRange && value >= centredRange.from && value <= centredRange.to ? centredRange : sliderRange(field));
    }
    const { from, to: applyValue } = this.ranges.get(path);
    Object.assign(row.slider, { min: from, max: applyValue });
    if (!row.isDragging) row.slider.value = value;
    row.slider.setAttribute("aria-valuetext", row.text);
  }

  // Whether the scene has parts with names, as a mechanism has.
  hasParts() {
    return this.kinds.size > 0;
  }

  // Whether a field is visible, possibly after scrolling.
  isVisible(path) {
    const box = this.rows.get(path)?.box;
    return Boolean(box && box.offsetWidth > 0 && !box.closest("details:not([open])"));
  }

  // Marks the invalid field, if any, and shows the problem there unless it is shown elsewhere.
  markInvalid(path, problem) {
    for (const row of this.rows.values()) {
      const isInvalid = row.path === path;
      row.problem.hidden = !isInvalid || !problem;
      row.problem.textContent = isInvalid && problem ? [problem.message, problem.help].filter(Boolean).join(": ") : "";
      row.entry.toggleAttribute("aria-invalid", isInvalid);
    }
  }

  // Shows the fields that match the filter, and their number per section.
  applyFilter() {
    const words = this.filter.toLowerCase().split(/\s+/).filter(Boolean);
    const isFiltered = words.length > 0 || this.changedOnly;
    const showCounts = ({ box, count }, [shown, changed, total]) => {
      box.hidden = shown === 0;
      if (isFiltered && shown > 0) box.open = true;
      const all = shown < total ? `${shown} of ${total}` : String(total);
      count.textContent = changed > 0 ? `${all}, ${changed} changed` : all;
    };
    const countsOfKinds = new Map([...this.kinds.keys()].map((kind) => [kind, [0, 0, 0]]));
    for (const group of this.groups) {
      const { rows } = group;
      let [shown, changed] = [0, 0];
      for (const row of rows) {
        const text = `${row.path} ${row.field.about ?? ""}`.toLowerCase();
        row.box.hidden = !words.every((word) => text.includes(word)) || this.changedOnly && !row.isChanged;
        shown += row.box.hidden ? 0 : 1;
        changed += row.isChanged ? 1 : 0;
      }
      const counts = [shown, changed, rows.length];
      showCounts(group, counts);
      countsOfKinds.get(group.kind)?.forEach((count, index, all) => { all[index] = count + counts[index]; });
    }
    for (const [kind, counts] of countsOfKinds) showCounts(this.kinds.get(kind), counts);
  }

  // The fields available as axes of the map: `{ path, name, kind, range }`, design variables first. `kind` is that of the
  // part of a mechanism.
  numericFields() {
    const rows = [...this.rows.values()].filter(({ slider, field }) => slider && isNumeric(field));
    return rows.map(({ path, field }) => ({ path, name: fieldName(field), kind: field.group[0], range: this.ranges.get(path) }));
  }
}

// A name that may be wrapped after each "_".
const breakAfterUnderscores = (name) => name.split(/(?<=_)/).flatMap((part, index) => (index > 0 ? [element("wbr"), part] : [part]));

// Selects an option; adds it if it does not exist.
function selectOption(select, word) {
  if (word !== undefined && ![...select.options].some((option) => option.value === word)) select.append(element("option", { value: word }, word));
  select.value = word;
}

// "design.base" → "base", "motor.torque" → "motor torque", "contact.friction.mu_static" → "friction mu_static". Parameters
// are named like the variables of a design.
const shortName = (path) => path.replace(/^(design|parameters)\./, "").split(".").slice(-2).join(" ");

// The name of a field next to others of its part: "bodies.tip.outlines.pad.size[0]" → "pad size[0]".
const nameInGroup = ({ path, group, key }) => (group.length > 0 ? path.slice(group.join(".").length + 1).replace(/^outlines\./, "").replaceAll(".", " ") : key);

// The name of a field next to any others.
const fieldName = (field) => (field.group.length > 0 ? `${field.group[1]} ${nameInGroup(field)}` : shortName(field.path));

// "contact.friction" → "Contact: friction".
function sectionTitle(section) {
  const text = section.replaceAll("_", " ").replaceAll(".", ": ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}
