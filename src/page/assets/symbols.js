// Symbols of scenes and results on the linkage, shown on hover or on request.

const SYMBOL_FONT = "600 14px system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";
const SYMBOL_HEIGHT = 16;
// Candidate distances between a symbol and its anchor, px.
const SYMBOL_DISTANCES = [4, 8, 13, 20, 29, 40, 54, 70];
const SYMBOL_DIRECTIONS = 32;
const SYMBOL_SPACING = 3;
// A pointer within this distance of a link hovers over it, px.
const HOVER_DISTANCE_PX = 14;
// A gripper has symbols at its right finger, which the scene describes; the left finger is its mirror image.
const FORCE_SYMBOLS = new Map([["proximal", "F21"], ["distal", "F22"], ["right proximal", "F21"], ["right distal", "F22"]]);
const SIDE_PREFIXES = ["", "right_"];

// Joints, tip and angles of the finger for the poses of its bodies, or null if the run has no finger.
function findLinkage(run, bodies) {
  const side = SIDE_PREFIXES.find((prefix) => bodies.some(({ name }) => name === `${prefix}l22`));
  if (side === undefined) return null;
  const pose = (name) => bodies.find((body) => body.name === side + name);
  const shapes = (name) => run.bodies.find((body) => body.name === side + name)?.shapes ?? [];
  const [l11, l12, l21, l22] = ["l11", "l12", "l21", "l22"].map(pose);
  const capsule = (name) => shapes(name).findLast((shape) => shape.kind === "capsule");
  const couplerShape = shapes("l12").find((shape) => shape.kind === "polygon");
  if (!l11 || !l12 || !l21 || !l22 || !couplerShape || !capsule("l21") || !capsule("l22")) return null;
  const xCoordinates = couplerShape.corners_m.map((corner) => corner[0]);
  const tip = capsule("l22").to_m;
  // The base is measured from the object for a finger, and from the centre of the palm for a gripper.
  const objectIndex = run.bodies.findIndex((body) => body.part === (side ? "palm" : "object"));
  const object = bodies[objectIndex];
  return {
    o: [l11.x_m, l11.y_m],
    a12: [l12.x_m, l12.y_m],
    a22: [l22.x_m, l22.y_m],
    a13: toWorld([Math.min(...xCoordinates) + Math.max(...xCoordinates), 0], l12.x_m, l12.y_m, l12.angle_rad),
    tip: toWorld(tip, l22.x_m, l22.y_m, l22.angle_rad),
    q11: l11.angle_rad,
    q12: l12.angle_rad - l11.angle_rad,
    q21: l21.angle_rad,
    q22: l22.angle_rad - l21.angle_rad,
    arm: l22.angle_rad,
    phi22: Math.atan2(tip[1], tip[0]),
    w: capsule("l21").radius_m,
    object: object && [object.x_m, object.y_m],
  };
}

const linkSegments = (linkage) => [["l11", linkage.o, linkage.a12], ["l12", linkage.a12, linkage.a13], ["l21", linkage.o, linkage.a22], ["l22", linkage.a22, linkage.a13], ["t22", linkage.a22, linkage.tip]];

// Whether a point of the screen is on a link.
function isOverLink(linkage, view, [x, y]) {
  const maxDistance = Math.max(HOVER_DISTANCE_PX, linkage.w * view.scale);
  return linkSegments(linkage).some(([, from, to]) => {
    const [[ax, ay], [bx, by]] = [view.toScreen(from), view.toScreen(to)];
    const [dx, dy] = [bx - ax, by - ay];
    const fraction = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / Math.max(dx * dx + dy * dy, 1e-12)));
    return Math.hypot(x - ax - fraction * dx, y - ay - fraction * dy) < maxDistance;
  });
}

// Symbols with their anchor on the screen, preferred direction and text, and the dimension lines that belong to them.
function layoutSymbols(linkage, view, forces) {
  const unit = (x, y) => [x / (Math.hypot(x, y) || 1), y / (Math.hypot(x, y) || 1)];
  const midpoint = (a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  const lines = [];
  const symbols = [];
  const addSymbol = (text, ink, at, direction) => symbols.push({ text, ink, at, direction });
  const centrePoint = view.toScreen(midpoint(midpoint(linkage.o, linkage.a12), midpoint(linkage.a13, linkage.a22)));
  for (const { text, ink, at, direction, shaft } of forces) {
    lines.push(shaft);
    addSymbol(text, ink, at, direction);
  }
  for (const [text, from, to] of linkSegments(linkage)) {
    const [a, b] = [view.toScreen(from), view.toScreen(to)];
    lines.push({ kind: "link", points: [a, b] });
    const at = midpoint(a, b);
    const [nx, ny] = unit(a[1] - b[1], b[0] - a[0]);
    const side = Math.sign((at[0] - centrePoint[0]) * nx + (at[1] - centrePoint[1]) * ny) || 1;
    addSymbol(text, "ink", at, [side * nx, side * ny]);
  }
  const l21 = Math.hypot(linkage.a22[0] - linkage.o[0], linkage.a22[1] - linkage.o[1]);
  const pointOnL21 = (fraction) => [linkage.o[0] + fraction * Math.cos(linkage.q21) * l21, linkage.o[1] + fraction * Math.sin(linkage.q21) * l21];
  const outward = [Math.sin(linkage.q21), -Math.cos(linkage.q21)];
  const [centre, rim] = [pointOnL21(0.8), pointOnL21(0.8).map((k, i) => k + linkage.w * outward[i])];
  lines.push({ kind: "dimension", points: [view.toScreen(centre), view.toScreen(rim)] });
  addSymbol("w", "ink", view.toScreen(rim), view.directionToScreen(outward));
  if (linkage.object) {
    const [a, b] = [view.toScreen([linkage.object[0], linkage.o[1]]), view.toScreen(linkage.o)].map(([x, y]) => [x, y + 22]);
    lines.push({ kind: "dimension", points: [a, b] });
    addSymbol("base", "ink", midpoint(a, b), [0, 1]);
  }
  for (const [text, at, fromInWorld, sweep, radius, fraction] of [
    ["q11", linkage.o, 0, linkage.q11, 56, 0.5],
    ["q21", linkage.o, 0, linkage.q21, 38, 0.5],
    ["q12", linkage.a12, linkage.q11, linkage.q12, 26, 0.5],
    ["q22", linkage.a22, linkage.q21, linkage.q22, 36, 0.5],
    ["φ22", linkage.a22, linkage.arm, linkage.phi22, 22, 0.75],
  ]) {
    const from = fromInWorld + view.angle;
    const [x, y] = view.toScreen(at);
    const pointOnArc = (angle, r) => [x + r * Math.cos(angle), y - r * Math.sin(angle)];
    if (text !== "φ22" && text !== "q21") lines.push({ kind: "reference", points: [[x, y], pointOnArc(from, radius + 18)] });
    const arcSegments = Math.max(2, Math.ceil(Math.abs(sweep) / 0.08));
    lines.push({ kind: "angle", points: Array.from({ length: arcSegments + 1 }, (_, k) => pointOnArc(from + sweep * k / arcSegments, radius)) });
    const symbolAngle = from + fraction * sweep;
    addSymbol(text, "accent", pointOnArc(symbolAngle, radius), [Math.cos(symbolAngle), -Math.sin(symbolAngle)]);
  }
  return { lines, symbols };
}

// Length of a line within a box, px (Liang and Barsky).
function lengthInBox([x0, y0, x1, y1], [ax, ay], [bx, by]) {
  let [low, high] = [0, 1];
  for (const [p, q] of [[ax - bx, ax - x0], [bx - ax, x1 - ax], [ay - by, ay - y0], [by - ay, y1 - ay]]) {
    if (p === 0 && q < 0) return 0;
    if (p < 0) low = Math.max(low, q / p);
    else if (p > 0) high = Math.min(high, q / p);
  }
  return Math.max(0, high - low) * Math.hypot(bx - ax, by - ay);
}

// Places the symbols one by one: near their anchor, off the lines, and without overlap if there is enough space.
function placeSymbols(symbols, lines, { left, top, right, bottom }) {
  const occupied = [];
  const segments = lines.flatMap(({ points }) => points.slice(1).map((point, k) => [points[k], point]));
  for (const symbol of symbols) {
    let best = null;
    const start = Math.atan2(symbol.direction[1], symbol.direction[0]);
    for (const distance of SYMBOL_DISTANCES) {
      for (let k = 0; k < SYMBOL_DIRECTIONS; k++) {
        const turn = Math.ceil(k / 2) * (k % 2 ? -1 : 1);
        const angle = start + turn * 2 * Math.PI / SYMBOL_DIRECTIONS;
        const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
        const r = distance + Math.max(symbol.width / 2 * Math.abs(cosine), SYMBOL_HEIGHT / 2 * Math.abs(sine));
        const [x, y] = [symbol.at[0] + r * cosine, symbol.at[1] + r * sine];
        const box = [x - symbol.width / 2, y - SYMBOL_HEIGHT / 2, x + symbol.width / 2, y + SYMBOL_HEIGHT / 2];
        let cost = distance + 56 * Math.abs(turn) / SYMBOL_DIRECTIONS;
        if (best && cost >= best.cost) continue;
        if (box[0] < left || box[1] < top || box[2] > right || box[3] > bottom) cost += 1e6;
        const overlaps = (other) => box[0] - SYMBOL_SPACING < other[2] && other[0] < box[2] + SYMBOL_SPACING && box[1] - SYMBOL_SPACING < other[3] && other[1] < box[3] + SYMBOL_SPACING;
        cost += 1e5 * occupied.filter(overlaps).length;
        for (const [a, b] of segments) {
          if (best && cost >= best.cost) break;
          cost += 4 * lengthInBox(box, a, b);
        }
        if (!best || cost < best.cost) best = { cost, x, y, box };
      }
    }
    occupied.push(best.box);
    Object.assign(symbol, best);
  }
  return symbols;
}

// Symbols with the forces at the tips of the arrows.
function forceSymbols(view, arrows) {
  return arrows.map((arrow) => {
    const { origin, direction, tip } = arrowOnScreen(arrow, view);
    const forceText = formatQuantity(Math.abs(arrow.force_n), "N", 3);
    const normal = arrow.kind === "normal";
    const symbol = normal ? FORCE_SYMBOLS.get(arrow.contact) : undefined;
    const text = symbol ? `${symbol} ${forceText}` : forceText;
    return { text, ink: normal ? "force" : "friction", at: tip, direction, shaft: { kind: "force", points: [origin, tip] } };
  });
}

// Draws the symbols; returns their texts and boxes. `margin` is covered by buttons; `highlighted` is the text of a
// highlighted symbol.
function drawSymbols(ctx, view, linkage, arrows, margin, highlighted = null) {
  const { lines, symbols } = layoutSymbols(linkage, view, forceSymbols(view, arrows));
  ctx.font = SYMBOL_FONT;
  for (const symbol of symbols) symbol.width = ctx.measureText(symbol.text).width + 2;
  const frame = { left: 4, top: margin.top, right: view.width - margin.right, bottom: view.height - margin.bottom };
  const visibleSymbols = symbols.filter(({ at: [x, y] }) => x > 0 && y > 0 && x < view.width && y < view.height);
  placeSymbols(visibleSymbols, lines, frame);
  // The force arrows are already drawn.
  for (const { kind, points } of lines.filter((line) => line.kind !== "force")) {
    ctx.beginPath();
    points.forEach((point, k) => (k ? ctx.lineTo(...point) : ctx.moveTo(...point)));
    ctx.strokeStyle = colour({ link: "ink", dimension: "ink", reference: "soft", angle: "accent" }[kind]);
    ctx.lineWidth = kind === "angle" ? 1.75 : 1.25;
    ctx.setLineDash({ link: [9, 3, 2, 3], reference: [3, 3] }[kind] ?? []);
    ctx.stroke();
    ctx.setLineDash([]);
    const ends = kind === "angle" ? [[points.at(-2), points.at(-1)]] : kind === "dimension" ? [points, [points[1], points[0]]] : [];
    for (const [from, to] of ends) arrowHead(ctx, from, to, 7);
  }
  for (const { text, ink, x, y, at, box } of visibleSymbols) {
    if (Math.hypot(at[0] - x, at[1] - y) > 26 + (box[2] - box[0]) / 2) {
      // A leader line starts at the edge of the symbol.
      const edgeFraction = Math.min((box[2] - x) / Math.max(Math.abs(at[0] - x), 1e-9), (box[3] - y) / Math.max(Math.abs(at[1] - y), 1e-9), 1);
      ctx.beginPath();
      ctx.moveTo(x + edgeFraction * (at[0] - x), y + edgeFraction * (at[1] - y));
      ctx.lineTo(...at);
      ctx.lineWidth = 1;
      ctx.strokeStyle = colour("soft");
      ctx.stroke();
    }
    if (text !== highlighted) {
      drawLabel(ctx, text, x, y, ink, "center");
      continue;
    }
    ctx.fillStyle = colour("accent");
    ctx.fillRect(box[0] - 4, box[1] - 1, box[2] - box[0] + 8, box[3] - box[1] + 2);
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.fillStyle = colour("on-accent");
    ctx.fillText(text, x, y);
  }
  ctx.font = FONT;
  return visibleSymbols.map(({ text, box }) => ({ text, box }));
}

function arrowHead(ctx, [ax, ay], [bx, by], size) {
  const length = Math.hypot(bx - ax, by - ay);
  if (!(length > 0)) return;
  const [dx, dy] = [(bx - ax) / length, (by - ay) / length];
  ctx.beginPath();
  ctx.moveTo(bx, by);
  ctx.lineTo(bx - size * dx - 0.4 * size * dy, by - size * dy + 0.4 * size * dx);
  ctx.lineTo(bx - size * dx + 0.4 * size * dy, by - size * dy - 0.4 * size * dx);
  ctx.closePath();
  ctx.fillStyle = ctx.strokeStyle;
  ctx.fill();
}
