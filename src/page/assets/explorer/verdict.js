// Whether a run can be trusted, as the check says.

const VERDICTS = {
  sure: "checked",
  uncertain: "uncertain",
  chaotic: "chaotic",
  unknown: "not checked",
  wrong: "not simulated",
};

// Shows a verdict, or with `null` that there is none yet. The places are always there, so that nothing moves.
function showVerdict(verdict) {
  const kind = verdict?.verdict ?? "waiting";
  const badge = byId("verdict");
  badge.dataset.kind = kind;
  put("verdict", verdict ? VERDICTS[kind] ?? kind : "…");
  badge.title = verdict ? verdictWords(verdict) : "The check of this run is under way.";
  const doubtful = kind === "uncertain" || kind === "chaotic";
  byId("doubt").hidden = !doubtful;
  if (doubtful) sayDoubt(verdict, "");
}

// `since` says from when on.
const sayDoubt = (verdict, since) => put("doubt", `This run is ${verdict.verdict}${since}: ${verdictWords(verdict)}`);

// What the run itself warns of.
function showWarnings(said) {
  const box = byId("warnings");
  const all = said.map((each) => element("p", {}, each));
  if (box.hidden && said.length > 0) box.open = matchMedia("(min-width: 1100px)").matches;
  box.hidden = said.length === 0;
  box.replaceChildren(element("summary", {}, `${said.length} ${said.length === 1 ? "warning" : "warnings"} of this run`), ...all);
}

// What the check says, without the head of its table and what it advises to do at a terminal.
const verdictWords = ({ text }) => text.trim().replace(/^(check\s+|[A-Z ]{4,}:\s*)/, "").replace(/;?\s*\n\s*/g, "; ").replace(/; ask for .*$/, "");

// The time up to which a run is what it says, `undefined` where all of it is.
function trustedUntil(verdict, start) {
  return verdict?.verdict === "uncertain" || verdict?.verdict === "chaotic" ? verdict.from_s ?? start : undefined;
}
