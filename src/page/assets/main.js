// Starts the page of a playback.

const INTERPOLATION_NOTE = "Between two samples, gaps, angles and poses are interpolated with a cubic of their values and rates, all other quantities linearly, on both scales.";

function main() {
  const playback = loadPlayback();
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  if (playback.runs.length === 0) {
    document.documentElement.dataset.theme = dark.matches ? "dark" : "light";
    for (const id of ["playback", "theme", "help-open"]) byId(id).hidden = true;
    byId("warning").hidden = false;
    setText("warning", "This run has no samples to draw.");
    return;
  }
  const app = createViewer(playback, connectKeyboard);
  showSampleNotes(playback);
  app.afterRender.push(linkTimeToAddress(app));
  window.phalanx = createTestHooks(app);
}

// Describes the samples, the interpolation and the line styles.
function showSampleNotes(playback) {
  const notes = playback.runs.map((run) => (run.samples < run.recorded
    ? `${run.label}: ${run.samples} of ${run.recorded} samples, reduced for this page; extremes, peaks and the samples around events are retained.`
    : `${run.label}: all ${run.samples} samples.`));
  setText("source", [...notes, INTERPOLATION_NOTE].join(" "));
  const comparisonNote = playback.runs[1] ? ` ${playback.runs[0].label} is filled and its curves are wide and pale; ${playback.runs[1].label} is dashed.` : "";
  setText("legend-help", "Force arrows act on the phalanx or disc, from the contact point. Their length grows with the logarithm of the force; to scale, it is proportional to the force and limited." + comparisonNote);
}

main();
