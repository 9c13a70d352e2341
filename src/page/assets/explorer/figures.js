// Results of a run: a strip of the most important figures with a fixed layout, and a table of all figures.

const STRIP_COUNT = 8;

class Figures {
  constructor(strip, table) {
    Object.assign(this, { strip, table });
    this.layoutKey = null;
    this.shownFigures = { now: [], reference: null };
  }

  // `reference` contains the figures of the reference run A, or is `null`.
  show(now, reference) {
    this.shownFigures = { now, reference };
    const layoutKey = JSON.stringify([now.map(({ key }) => key), Boolean(reference)]);
    if (layoutKey !== this.layoutKey) this.build(now, reference);
    this.layoutKey = layoutKey;
    const referenceByKey = new Map((reference ?? []).map((figure) => [figure.key, figure]));
    now.forEach((figure, index) => {
      const referenceFigure = referenceByKey.get(figure.key);
      const change = referenceFigure ? difference(figure, referenceFigure) : "";
      for (const cells of [this.cells[index], this.rows[index]]) {
        if (!cells) continue;
        setCellText(cells.now, figure.text);
        if (cells.reference) setCellText(cells.reference, referenceFigure?.text ?? "–");
        if (cells.difference) setCellText(cells.difference, change);
      }
      const cell = this.cells[index];
      if (!cell) return;
      cell.now.classList.toggle("word", isText(figure));
      cell.now.style.setProperty("--word", `var(--${resultColour(figure.text)})`);
    });
  }

  build(now, reference) {
    this.cells = now.slice(0, STRIP_COUNT).map(({ label }) => {
      const cells = { now: element("output", { "aria-live": "off" }), difference: element("span", { class: "difference soft" }) };
      return { ...cells, box: element("div", { class: "figure" }, element("span", { class: "label soft", title: label }, label), cells.now, cells.difference) };
    });
    this.strip.replaceChildren(...this.cells.map(({ box }) => box));
    const heads = reference ? ["", "A", "B", "B − A"] : ["", "now"];
    const body = element("tbody");
    this.rows = now.map(({ label, key }) => {
      const [first, second, third] = [element("td"), element("td"), element("td")];
      body.append(element("tr", {}, element("th", { scope: "row", title: key }, label), ...(reference ? [first, second, third] : [second])));
      return { now: second, reference: first, difference: third };
    });
    const head = element("thead", {}, element("tr", {}, ...heads.map((head) => element("th", { scope: "col" }, head || element("span", { class: "hidden" }, "Figure")))));
    this.table.replaceChildren(element("table", { class: "figures" }, head, body));
  }
}

// Whether a figure is a text, such as the class of a run.
const isText = ({ value, text }) => !Number.isFinite(value) && text !== "–";

function setCellText(cell, content) {
  if (cell.textContent === content) return;
  cell.textContent = content;
  cell.title = content;
}

// Difference of a figure from the reference: in its unit, and in per cent where meaningful.
function difference({ value, text: now, unit }, { value: referenceByKey, text: beforeText }) {
  if (!Number.isFinite(value) || !Number.isFinite(referenceByKey)) return now === beforeText ? "=" : `A: ${beforeText}`;
  const change = value - referenceByKey;
  if (change === 0) return "=";
  const percentText = referenceByKey !== 0 && Math.abs(change / referenceByKey) < 10 ? ` (${formatSigned(100 * change / Math.abs(referenceByKey), 1)}\u202f%)` : "";
  // Counts and percentages have no SI prefix.
  const changeText = unit && unit !== "%" ? formatQuantity(change, unit, 3) : `${formatNumber(change, 3)}${unit === "%" ? "\u202f%" : ""}`;
  return `${change > 0 ? "+" : ""}${changeText}${percentText}`;
}

const formatSigned = (value, decimals) => (value > 0 ? "+" : "") + withMinusSign(value.toFixed(Math.abs(value) >= 100 ? 0 : decimals));
