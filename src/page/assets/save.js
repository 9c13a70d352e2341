// Files of what the page shows, and a link to an instant.

// The animation and the plots at the cursor as one SVG, in the colours of the scheme.
function pictureOf(app) {
  const { film, stage, plots, clock } = app;
  const parts = [];
  let [y, width] = [0, 0];
  const words = (text, x, ink, weight = 400) => `<text x="${x}" y="${y + 18}" style="font:${weight} 14px system-ui, sans-serif" fill="${marked(colour(ink))}">${marked(text)}</text>`;
  const put = (recorder) => {
    const id = `view-${parts.length}`;
    parts.push(`<clipPath id="${id}"><rect width="${recorder.width}" height="${recorder.height}"/></clipPath>`);
    parts.push(`<g transform="translate(0 ${y})"><g clip-path="${"url"}(#${id})">${recorder.group(0, 0)}</g></g>`);
    y += recorder.height;
    width = Math.max(width, recorder.width);
  };
  const shown = film.runs.filter((run) => run.visible);
  const first = shown[0]?.kept === false ? "solid" : "wide and pale";
  const how = shown.length > 1 ? `: ${shown[0].label} ${first}, ${shown[1].label} dashed` : shown.map((run) => `: ${run.label}`).join("");
  parts.push(words(`${document.title}, ${timeText(clock.time, film.unit)}${how}`, 8, "ink", 600));
  y += 28;
  put(recorded("stage", stage.canvas, () => stage.draw(clock.time)));
  for (const [index, panel] of plots.panels.filter(({ canvas }) => canvas.clientWidth > 0).entries()) {
    y += 8;
    parts.push(words(`${panel.title} ${panel.unitText.textContent}`, 8, "ink", 600));
    const ruler = new SvgContext("ruler", 0, 0);
    ruler.font = "600 14px system-ui, sans-serif";
    let x = 26 + ruler.measureText(`${panel.title} ${panel.unitText.textContent}`).width;
    for (const series of panel.series.filter((each) => each.visible)) {
      parts.push(words(series.name, x, seriesColour(series.index)));
      x += ruler.measureText(series.name).width + 12;
    }
    y += 26;
    width = Math.max(width, x);
    put(recorded(`plot-${index}`, panel.canvas, () => plots.drawPanel(panel, clock.time)));
  }
  const height = y + 8;
  app.changed();
  return {
    width,
    height,
    text: `<svg xmlns="${SVG_SPACE}" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"><rect width="${width}" height="${height}" fill="${marked(colour("panel"))}"/>\n${parts.join("\n")}\n</svg>\n`,
  };
}

// A cell of a table. What a spreadsheet would take for a formula gets a quote before it.
const cell = (text) => `"${(/^[=+\-@\t\r]/.test(text) ? `'${text}` : text).replaceAll('"', '""')}"`;

// All samples of the runs that are shown, every plotted quantity with its SI unit.
function tableOf(app) {
  const { film, plots } = app;
  const columns = plots.panels.flatMap((panel) => panel.series.map((series) => ({ series, name: `${panel.title}: ${series.name} (${panel.unit})` })));
  const lines = [["run", "time_s", ...columns.map(({ name }) => name)].map(cell).join(",")];
  for (const run of film.runs.filter((each) => each.visible)) {
    for (let i = 0; i < run.samples; i++) {
      const values = columns.map(({ series }) => series.runs[run.index]?.[i]);
      lines.push([cell(run.label), run.time[i], ...values.map((value) => (Number.isFinite(value) ? value : ""))].join(","));
    }
  }
  return lines.join("\n") + "\n";
}

// A picture of points, twice as fine as a usual screen.
async function pointsOf({ text, width, height }) {
  const image = new Image();
  image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(text);
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width: 2 * width, height: 2 * height });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

// Saves a kind of file; `tell` hears how much of what takes long is done.
async function saveAs(app, kind, tell) {
  // Another page may have files of its own.
  const own = app.files?.[kind];
  const name = (app.name ?? document.title).replace(/[^\p{L}\p{N}._-]+/gu, "-").replace(/^[-.]+/, "") || "run";
  const blob = own ? await own(tell) : kind === "csv" ? new Blob([tableOf(app)], { type: "text/csv" })
    : kind === "svg" ? new Blob([pictureOf(app).text], { type: "image/svg+xml" })
    : kind === "gif" ? await movieOf(app, tell)
    : await pointsOf(pictureOf(app));
  // Why there is none has been said.
  if (!blob) return;
  const address = URL.createObjectURL(blob);
  element("a", { href: address, download: `${name}.${kind}` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

// The instant in the address: "#t=0.0045", in seconds, or with a unit as in "#t=4.5ms".
function instantOf(hash) {
  const [, number, unit] = decodeURIComponent(hash).match(/^#t=([\d.]+(?:e-?\d+)?)(s|ms|us|µs)?$/) ?? [];
  const time = Number(number) * { s: 1, ms: 1e-3, us: 1e-6, µs: 1e-6 }[unit ?? "s"];
  return Number.isFinite(time) ? time : null;
}

// Goes where the address says, and keeps it at the cursor while nothing plays.
function linked(app) {
  const go = () => {
    const time = instantOf(location.hash);
    if (time === null) return;
    app.pause();
    app.seek(time);
  };
  addEventListener("hashchange", go);
  go();
  let [said, waiting] = [app.clock.time, null];
  return () => {
    if (app.clock.playing || app.clock.time === said) return;
    said = app.clock.time;
    clearTimeout(waiting);
    // Browsers refuse addresses that change all the time, and some any change in a file.
    waiting = setTimeout(() => {
      try {
        history.replaceState(null, "", `#t=${said}`);
      } catch {
        // The link is a convenience: the page is whole without it.
      }
    }, 250);
  };
}
