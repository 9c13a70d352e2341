// The verdict of the check on the reliability of a run.

const VERDICT_TEXTS = {
  sure: "checked",
  uncertain: "uncertain",
  chaotic: "chaotic",
  unknown: "not checked",
  wrong: "not simulated",
};

// Shows a verdict; `null` means that the check is running. The elements always exist, so that the layout does not
// change.
function showVerdict(verdict) {
  const kind = verdict?.verdict ?? "waiting";
  const badge = byId("verdict");
  badge.dataset.kind = kind;
  setText("verdict", verdict ? VERDICT_TEXTS[kind] ?? kind : "…");
  badge.title = verdict ? verdictText(verdict) : "This run is being checked.";
  const isDoubtful = kind === "uncertain" || kind === "chaotic";
  byId("doubt").hidden = !isDoubtful;
  if (isDoubtful) showDoubt(verdict, "");
}

// `sinceText` states the time from which the run is unreliable.
const showDoubt = (verdict, sinceText) => setText("doubt", `This run is ${verdict.verdict}${sinceText}: ${verdictText(verdict)}`);

// Shows the warnings of the run.
function updateWarnings(warnings) {
  const box = byId("warnings");
  const paragraphs = warnings.map((warning) => element("p", {}, warning));
  if (box.hidden && warnings.length > 0) box.open = matchMedia("(min-width: 1100px)").matches;
  box.hidden = warnings.length === 0;
  box.replaceChildren(element("summary", {}, `${warnings.length} ${warnings.length === 1 ? "warning" : "warnings"} of this run`), ...paragraphs);
}

// The text of the check without its heading and without advice for the command line.
const verdictText = ({ text }) => text.trim().replace(/^(check\s+|[A-Z ]{4,}:\s*)/, "").replace(/;?\s*\n\s*/g, "; ").replace(/; increase the accuracy with .*$/, "");

// The time up to which a run is reliable, or `undefined` if all of it is.
function trustedUntil(verdict, start) {
  return verdict?.verdict === "uncertain" || verdict?.verdict === "chaotic" ? verdict.from_s ?? start : undefined;
}
