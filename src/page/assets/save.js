// Export of files, and links to a time.

// The animation and the plots at the cursor as one SVG, in the present colours.
function renderSvg(app) {
  const { playback, stage, plots, clock } = app;
  const elements = [];
  let [y, width] = [0, 0];
  const textElement = (text, x, ink, weight = 400) => `<text x="${x}" y="${y + 18}" style="font:${weight} 14px system-ui, sans-serif" fill="${escapeXml(colour(ink))}">${escapeXml(text)}</text>`;
  const append = (svgContext) => {
    const id = `view-${elements.length}`;
    elements.push(`<clipPath id="${id}"><rect width="${svgContext.width}" height="${svgContext.height}"/></clipPath>`);
    elements.push(`<g transform="translate(0 ${y})"><g clip-path="${"url"}(#${id})">${svgContext.group(0, 0)}</g></g>`);
    y += svgContext.height;
    width = Math.max(width, svgContext.width);
  };
  const visibleRuns = playback.runs.filter((run) => run.visible);
  const first = visibleRuns[0]?.isReference === false ? "solid" : "wide and pale";
  const legend = visibleRuns.length > 1 ? `: ${visibleRuns[0].label} ${first}, ${visibleRuns[1].label} dashed` : visibleRuns.map((run) => `: ${run.label}`).join("");
  elements.push(textElement(`${document.title}, ${formatTime(clock.time, playback.timeFormat)}${legend}`, 8, "ink", 600));
  y += 28;
  append(recordSvg("stage", stage.canvas, () => stage.draw(clock.time)));
  for (const [index, panel] of plots.panels.filter(({ canvas }) => canvas.clientWidth > 0).entries()) {
    y += 8;
    elements.push(textElement(`${panel.title} ${panel.unitText.textContent}`, 8, "ink", 600));
    const ruler = new SvgContext("ruler", 0, 0);
    ruler.font = "600 14px system-ui, sans-serif";
    let x = 26 + ruler.measureText(`${panel.title} ${panel.unitText.textContent}`).width;
    for (const series of panel.series.filter((item) => item.visible)) {
      elements.push(textElement(series.name, x, seriesColour(series.index)));
      x += ruler.measureText(series.name).width + 12;
    }
    y += 26;
    width = Math.max(width, x);
    append(recordSvg(`plot-${index}`, panel.canvas, () => plots.drawPanel(panel, clock.time)));
  }
  const height = y + 8;
  app.requestRedraw();
  return {
    width,
    height,
    text: `<svg xmlns="${SVG_NAMESPACE}" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"><rect width="${width}" height="${height}" fill="${escapeXml(colour("panel"))}"/>\n${elements.join("\n")}\n</svg>\n`,
  };
}

// A CSV cell. A quote is prepended to a text that a spreadsheet would read as a formula.
const csvCell = (text) => `"${(/^[=+\-@\t\r]/.test(text) ? `'${text}` : text).replaceAll('"', '""')}"`;

// All samples of the visible runs: every plotted quantity with its SI unit.
function renderCsv(app) {
  const { playback, plots } = app;
  const columns = plots.panels.flatMap((panel) => panel.series.map((series) => ({ series, name: `${panel.title}: ${series.name} (${panel.unit})` })));
  const lines = [["run", "time_s", ...columns.map(({ name }) => name)].map(csvCell).join(",")];
  for (const run of playback.runs.filter((item) => item.visible)) {
    for (let i = 0; i < run.samples; i++) {
      const values = columns.map(({ series }) => series.runs[run.index]?.[i]);
      lines.push([csvCell(run.label), run.time[i], ...values.map((value) => (Number.isFinite(value) ? value : ""))].join(","));
    }
  }
  return lines.join("\n") + "\n";
}

// Renders an SVG as PNG at twice the resolution of a standard screen.
async function rasterise({ text, width, height }) {
  const image = new Image();
  image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(text);
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width: 2 * width, height: 2 * height });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

// Saves a file of the given kind; `onProgress` receives the completed fraction.
async function saveFile(app, kind, onProgress) {
  // A page may provide additional exporters.
  const exporter = app.exporters?.[kind];
  const name = (app.name ?? document.title).replace(/[^\p{L}\p{N}._-]+/gu, "-").replace(/^[-.]+/, "") || "run";
  const blob = exporter ? await exporter(onProgress) : kind === "csv" ? new Blob([renderCsv(app)], { type: "text/csv" })
    : kind === "svg" ? new Blob([renderSvg(app).text], { type: "image/svg+xml" })
    : kind === "gif" ? await renderGif(app, onProgress)
    : await rasterise(renderSvg(app));
  // The exporter has already reported the error.
  if (!blob) return;
  const address = URL.createObjectURL(blob);
  element("a", { href: address, download: `${name}.${kind}` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

// Parses the time in the address: "#t=0.0045" in seconds, or "#t=4.5ms" with a unit.
function parseTimeFragment(hash) {
  const [, number, unit] = decodeURIComponent(hash).match(/^#t=([\d.]+(?:e-?\d+)?)(s|ms|us|µs)?$/) ?? [];
  const time = Number(number) * { s: 1, ms: 1e-3, us: 1e-6, µs: 1e-6 }[unit ?? "s"];
  return Number.isFinite(time) ? time : null;
}

// Seeks to the time in the address; writes the time of the cursor to the address while paused.
function linkTimeToAddress(app) {
  const seekToAddress = () => {
    const time = parseTimeFragment(location.hash);
    if (time === null) return;
    app.pause();
    app.seek(time);
  };
  addEventListener("hashchange", seekToAddress);
  seekToAddress();
  let [linkedTime, timer] = [app.clock.time, null];
  return () => {
    if (app.clock.playing || app.clock.time === linkedTime) return;
    linkedTime = app.clock.time;
    clearTimeout(timer);
    // Browsers reject frequent changes of the address, and some any change for local files.
    timer = setTimeout(() => {
      try {
        history.replaceState(null, "", `#t=${linkedTime}`);
      } catch {
        // The page works without the link.
      }
    }, 250);
  };
}
