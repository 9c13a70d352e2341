// Everything by keyboard, and the help that says so.

const KEYS = [
  [["Space"], "play or pause"],
  [["←", "→"], "one sample back or forth"],
  [["Shift ←", "Shift →"], "a fiftieth of the time axis back or forth"],
  [["p", "n"], "previous or next event"],
  [["Home", "End"], "start or end"],
  [["+", "−"], "faster or slower"],
  [["s"], "slow at impacts, or one speed"],
  [["c"], "view: whole, or at one contact after the other"],
  [["i", "o", "0"], "zoom the animation in or out, or show everything"],
  [["l"], "letters of the linkage"],
  [["z", "Shift z"], "zoom the time axis in or out"],
  [["e", "a"], "time axis: the nearest event, or all"],
  [["1", "2"], "show or hide a run"],
  [["d"], "light or dark"],
  [["?"], "this help"],
];

// `more` has keys of a page's own: their lines of the help, and their actions.
function keyboard(app, more = { keys: [], actions: {} }) {
  const help = byId("help");
  const open = keyHelp(help, [...KEYS, ...more.keys]);

  const wide = () => {
    const [from, to] = app.range();
    return (to - from) / 50;
  };
  const actions = {
    " ": app.toggle,
    ArrowLeft: () => app.step(-1),
    ArrowRight: () => app.step(1),
    "shift ArrowLeft": () => app.seek(app.clock.time - wide()),
    "shift ArrowRight": () => app.seek(app.clock.time + wide()),
    p: () => app.jump(-1),
    n: () => app.jump(1),
    Home: () => app.seek(app.film.start),
    End: () => app.seek(app.film.end),
    "+": () => app.faster(1),
    "=": () => app.faster(1),
    "-": () => app.faster(-1),
    "−": () => app.faster(-1),
    s: () => app.setAuto(!app.clock.auto),
    c: app.nextView,
    i: () => app.zoom(1.5),
    o: () => app.zoom(1 / 1.5),
    0: app.fit,
    l: app.toggleLetters,
    z: () => app.zoomTime(0.5),
    "shift Z": () => app.zoomTime(2),
    e: app.windowEvent,
    a: () => app.window(app.film.start, app.film.end),
    1: () => app.show(0, !app.film.runs[0].visible),
    2: () => app.film.runs[1] && app.show(1, !app.film.runs[1].visible),
    d: app.toggleTheme,
    "?": open,
    ...more.actions,
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || help.open) return;
    const target = event.target;
    const tag = target.tagName;
    // Where an element has a use of its own for a key, it keeps it.
    if (tag === "SELECT") return;
    if ((tag === "BUTTON" || tag === "INPUT" && target.type === "checkbox") && event.key === " ") return;
    if (target.id === "speed" && event.key.startsWith("Arrow")) return;
    if (target.matches(".grid, .sheet") && event.key.startsWith("Arrow")) return;
    if (target.matches("textarea, input:not([type='range'], [type='checkbox'])")) return;
    if (target.matches("[data-keys='own']") && /^(Arrow|Home|End|Page|Enter)/.test(event.key)) return;
    // On many keyboards + and ? are typed with shift.
    const action = (event.shiftKey && actions["shift " + event.key]) || actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
