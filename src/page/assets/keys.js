// Keyboard control, and the list of keys in the help.

const KEY_HELP = [
  [["Space"], "play or pause"],
  [["←", "→"], "one sample backward or forward"],
  [["Shift ←", "Shift →"], "a fiftieth of the time axis backward or forward"],
  [["p", "n"], "previous or next event"],
  [["Home", "End"], "start or end"],
  [["+", "−"], "faster or slower"],
  [["s"], "slow at impacts, or constant speed"],
  [["c"], "view: everything, then each contact in turn"],
  [["i", "o", "0"], "zoom the animation in or out, or show everything"],
  [["t"], "turn the animation by 180°"],
  [["l"], "symbols of the linkage"],
  [["z", "Shift z"], "zoom the time axis in or out"],
  [["e", "a"], "time axis: nearest impact, or whole run"],
  [["1", "2"], "show or hide a run"],
  [["d"], "light or dark colours"],
  [["?"], "this help"],
];

// `extra` adds keys of a page: their lines in the help and their actions.
function connectKeyboard(app, extra = { keys: [], actions: {} }) {
  const dialog = byId("help");
  const openHelp = connectHelp(dialog, [...KEY_HELP, ...extra.keys]);

  const coarseStep = () => {
    const [from, to] = app.range();
    return (to - from) / 50;
  };
  const actions = {
    " ": app.toggle,
    ArrowLeft: () => app.step(-1),
    ArrowRight: () => app.step(1),
    "shift ArrowLeft": () => app.seek(app.clock.time - coarseStep()),
    "shift ArrowRight": () => app.seek(app.clock.time + coarseStep()),
    p: () => app.jump(-1),
    n: () => app.jump(1),
    Home: () => app.seek(app.playback.start),
    End: () => app.seek(app.playback.end),
    "+": () => app.changeSpeed(1),
    "=": () => app.changeSpeed(1),
    "-": () => app.changeSpeed(-1),
    "−": () => app.changeSpeed(-1),
    s: () => app.setAuto(!app.clock.auto),
    c: app.nextView,
    i: () => app.zoom(1.5),
    o: () => app.zoom(1 / 1.5),
    0: app.fit,
    t: app.turn,
    l: app.toggleSymbols,
    z: () => app.zoomTime(0.5),
    "shift Z": () => app.zoomTime(2),
    e: app.showNearestImpact,
    a: () => app.setWindow(app.playback.start, app.playback.end),
    1: () => app.show(0, !app.playback.runs[0].visible),
    2: () => app.playback.runs[1] && app.show(1, !app.playback.runs[1].visible),
    d: app.toggleTheme,
    "?": openHelp,
    ...extra.actions,
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
    const target = event.target;
    const tag = target.tagName;
    // Elements that use a key themselves take precedence.
    if (tag === "SELECT") return;
    if ((tag === "BUTTON" || tag === "INPUT" && target.type === "checkbox") && event.key === " ") return;
    if (target.id === "speed" && event.key.startsWith("Arrow")) return;
    if (target.matches(".grid, .sheet") && event.key.startsWith("Arrow")) return;
    if (target.matches("textarea, input:not([type='range'], [type='checkbox'])")) return;
    if (target.matches("[data-keys='own']") && /^(Arrow|Home|End|Page|Enter)/.test(event.key)) return;
    // Many keyboards require shift for + and ?.
    const action = (event.shiftKey && actions["shift " + event.key]) || actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
