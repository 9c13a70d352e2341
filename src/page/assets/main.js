// Puts the page together and draws it when something has changed.

const STATEMENT = "Between two samples the page draws gaps, angles and poses by their values and rates (a cubic), all else as a straight line, on every scale.";

function main() {
  const film = loaded();
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  if (film.runs.length === 0) {
    document.documentElement.dataset.theme = dark.matches ? "dark" : "light";
    for (const id of ["film", "theme", "help-open"]) byId(id).hidden = true;
    byId("warning").hidden = false;
    put("warning", "This run has no samples to draw.");
    return;
  }
  const app = viewer(film, keyboard);
  about(film);
  app.drawn.push(linked(app));
  window.phalanx = forTests(app);
}

// How samples became what is seen.
function about(film) {
  const parts = film.runs.map((run) => (run.samples < run.recorded
    ? `${run.label}: ${run.samples} of ${run.recorded} samples, thinned out to fit a page; extremes, peaks and the surroundings of events were kept.`
    : `${run.label}: all ${run.samples} samples.`));
  put("source", [...parts, STATEMENT].join(" "));
  const second = film.runs[1] ? ` ${film.runs[0].label} is filled and its curves are wide and pale; ${film.runs[1].label} is dashed.` : "";
  put("legend-help", "Force arrows act on the phalanx or disc, from the contact point. Their length grows with the logarithm of the force unless the arrows are to scale; then the longest are cut off." + second);
}

main();
