// What a run came to: a strip of the figures that matter most, which stays in its place, and a table of all.

const HEADLINE = 8;

class Figures {
  constructor(strip, table) {
    Object.assign(this, { strip, table });
    this.form = null;
    this.shown = { now: [], kept: null };
  }

  // `kept` is the figures that were kept to be compared with, or `null`.
  show(now, kept) {
    this.shown = { now, kept };
    const form = JSON.stringify([now.map(({ key }) => key), Boolean(kept)]);
    if (form !== this.form) this.build(now, kept);
    this.form = form;
    const before = new Map((kept ?? []).map((figure) => [figure.key, figure]));
    now.forEach((figure, index) => {
      const old = before.get(figure.key);
      const apart = old ? difference(figure, old) : "";
      for (const cells of [this.cells[index], this.rows[index]]) {
        if (!cells) continue;
        text(cells.now, figure.text);
        if (cells.kept) text(cells.kept, old?.text ?? "–");
        if (cells.apart) text(cells.apart, apart);
      }
      const cell = this.cells[index];
      if (!cell) return;
      cell.now.classList.toggle("word", isWord(figure));
      cell.now.style.setProperty("--word", `var(--${inkOf(figure.text)})`);
    });
  }

  build(now, kept) {
    this.cells = now.slice(0, HEADLINE).map(({ label }) => {
      const cells = { now: element("output", { "aria-live": "off" }), apart: element("span", { class: "apart soft" }) };
      return { ...cells, box: element("div", { class: "figure" }, element("span", { class: "label soft", title: label }, label), cells.now, cells.apart) };
    });
    this.strip.replaceChildren(...this.cells.map(({ box }) => box));
    const heads = kept ? ["", "A", "B", "B − A"] : ["", "now"];
    const body = element("tbody");
    this.rows = now.map(({ label, key }) => {
      const [first, second, third] = [element("td"), element("td"), element("td")];
      body.append(element("tr", {}, element("th", { scope: "row", title: key }, label), ...(kept ? [first, second, third] : [second])));
      return { now: second, kept: first, apart: third };
    });
    const head = element("thead", {}, element("tr", {}, ...heads.map((each) => element("th", { scope: "col" }, each || element("span", { class: "hidden" }, "Figure")))));
    this.table.replaceChildren(element("table", { class: "figures" }, head, body));
  }
}

// What is said of a run in a word, as its class.
const isWord = ({ value, text }) => !Number.isFinite(value) && text !== "–";

function text(cell, words) {
  if (cell.textContent === words) return;
  cell.textContent = words;
  cell.title = words;
}

// How much a figure has grown: in its unit, and in per cent where that says something.
function difference({ value, text: now, unit }, { value: before, text: then }) {
  if (!Number.isFinite(value) || !Number.isFinite(before)) return now === then ? "=" : `A: ${then}`;
  const apart = value - before;
  if (apart === 0) return "=";
  const part = before !== 0 && Math.abs(apart / before) < 10 ? ` (${signed(100 * apart / Math.abs(before), 1)}\u202f%)` : "";
  // Counts and shares have no prefixes.
  const size = unit && unit !== "%" ? withUnit(apart, unit, 3) : `${plain(apart, 3)}${unit === "%" ? "\u202f%" : ""}`;
  return `${apart > 0 ? "+" : ""}${size}${part}`;
}

const signed = (value, decimals) => (value > 0 ? "+" : "") + minus(value.toFixed(Math.abs(value) >= 100 ? 0 : decimals));
