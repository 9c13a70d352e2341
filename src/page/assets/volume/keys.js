// Keyboard control, and the list of keys in the help.

const KEY_HELP = [
  [["←", "→", "↑", "↓"], "rotate the volume"],
  [["+", "−", "0"], "zoom in or out, or show everything"],
  [["1", "2", "3", "4"], "view from a corner, or along an axis"],
  [["b", "Shift b"], "next or previous base"],
  [["m", "Shift m"], "next or previous friction"],
  [["c", "Shift c"], "next or previous quantity in colour"],
  [["g"], "coloured region: stable, PFP ≥ 0, form-closed"],
  [["s"], "show or hide other cells"],
  [["l", "Shift l"], "design: longer or shorter l21"],
  [["p", "Shift p"], "design: larger or smaller φ22"],
  [["r", "Shift r"], "design: larger or smaller r_l"],
  [["x", "y", "z"], "show the slice of the design: l21, r_l, φ22"],
  [["a"], "all slices"],
  [["Esc"], "deselect the design"],
  [["d"], "light or dark colours"],
  [["?"], "this help"],
];

function connectKeyboard(app) {
  const dialog = byId("help");
  const openHelp = connectHelp(dialog, KEY_HELP);
  const STEP = 0.0873;
  const actions = {
    ArrowLeft: () => app.turn(-STEP, 0),
    ArrowRight: () => app.turn(STEP, 0),
    ArrowUp: () => app.turn(0, -STEP),
    ArrowDown: () => app.turn(0, STEP),
    "+": () => app.zoom(1.25),
    "=": () => app.zoom(1.25),
    "-": () => app.zoom(0.8),
    "−": () => app.zoom(0.8),
    0: app.fit,
    1: () => app.view("corner"),
    2: () => app.view("front"),
    3: () => app.view("top"),
    4: () => app.view("side"),
    b: () => app.nextBase(1),
    B: () => app.nextBase(-1),
    m: () => app.nextFriction(1),
    M: () => app.nextFriction(-1),
    c: () => app.nextQuantity(1),
    C: () => app.nextQuantity(-1),
    g: app.nextRegion,
    s: () => app.setRest(!app.rest),
    l: () => app.moveDesign(0, 1),
    L: () => app.moveDesign(0, -1),
    p: () => app.moveDesign(1, 1),
    P: () => app.moveDesign(1, -1),
    r: () => app.moveDesign(2, 1),
    R: () => app.moveDesign(2, -1),
    x: () => app.cut(0),
    z: () => app.cut(1),
    y: () => app.cut(2),
    a: app.allSlices,
    Escape: () => app.choose(null),
    d: app.toggleTheme,
    "?": openHelp,
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
    const { tagName, type } = event.target;
    // Elements that use a key themselves take precedence.
    if (tagName === "SELECT") return;
    if (tagName === "INPUT" && type === "range" && /^(Arrow|Home|End|Page)/.test(event.key)) return;
    if (event.target.matches(".grid, .sheet") && event.key.startsWith("Arrow")) return;
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
}
