// The letters of scenes and results on the linkage, where it is pointed at or they are asked for.

const LETTER_FONT = "600 14px system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";
const LETTER_HEIGHT = 16;
// Distances of a letter from what it names that are tried, in pixels.
const LETTER_REACH = [4, 8, 13, 20, 29, 40, 54, 70];
const LETTER_WAYS = 32;
const LETTER_ROOM = 3;
// A pointer so near to a link points at it.
const POINTED_PX = 14;
// Of a gripper it is the right finger that is named: it is the one a scene describes, the other mirrors it.
const FORCES = new Map([["proximal", "F21"], ["distal", "F22"], ["right proximal", "F21"], ["right distal", "F22"]]);
const SIDES = ["", "right_"];

// The joints of the finger at the poses of its bodies, and the end of its tip; null where a run has no finger.
function linkageOf(run, bodies) {
  const side = SIDES.find((each) => bodies.some(({ name }) => name === `${each}l22`));
  if (side === undefined) return null;
  const pose = (name) => bodies.find((body) => body.name === side + name);
  const shapes = (name) => run.bodies.find((body) => body.name === side + name)?.shapes ?? [];
  const [l11, l12, l21, l22] = ["l11", "l12", "l21", "l22"].map(pose);
  const capsule = (name) => shapes(name).findLast((shape) => shape.kind === "capsule");
  const bar = shapes("l12").find((shape) => shape.kind === "polygon");
  if (!l11 || !l12 || !l21 || !l22 || !bar || !capsule("l21") || !capsule("l22")) return null;
  const along = bar.corners_m.map((corner) => corner[0]);
  const tip = capsule("l22").to_m;
  // A finger's base is counted from its object, a gripper's from the middle of its palm.
  const middle = run.bodies.findIndex((body) => body.part === (side ? "palm" : "object"));
  const object = bodies[middle];
  return {
    o: [l11.x_m, l11.y_m],
    a12: [l12.x_m, l12.y_m],
    a22: [l22.x_m, l22.y_m],
    a13: placed([Math.min(...along) + Math.max(...along), 0], l12.x_m, l12.y_m, l12.angle_rad),
    tip: placed(tip, l22.x_m, l22.y_m, l22.angle_rad),
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

const linksOf = (m) => [["l11", m.o, m.a12], ["l12", m.a12, m.a13], ["l21", m.o, m.a22], ["l22", m.a22, m.a13], ["t22", m.a22, m.tip]];

// Whether a place on the screen is on a link.
function pointsAt(linkage, view, [x, y]) {
  const near = Math.max(POINTED_PX, linkage.w * view.scale);
  return linksOf(linkage).some(([, from, to]) => {
    const [[ax, ay], [bx, by]] = [view.to(from), view.to(to)];
    const [dx, dy] = [bx - ax, by - ay];
    const part = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / Math.max(dx * dx + dy * dy, 1e-12)));
    return Math.hypot(x - ax - part * dx, y - ay - part * dy) < near;
  });
}

// What is named: a place on the screen, the way its letter goes from there, a text, and the lines that show it.
function lettersOf(m, view, forces) {
  const unit = (x, y) => [x / (Math.hypot(x, y) || 1), y / (Math.hypot(x, y) || 1)];
  const mid = (a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  const lines = [];
  const letters = [];
  const name = (text, ink, at, way) => letters.push({ text, ink, at, way });
  const inside = view.to(mid(mid(m.o, m.a12), mid(m.a13, m.a22)));
  for (const { text, ink, at, way, shaft } of forces) {
    lines.push(shaft);
    name(text, ink, at, way);
  }
  for (const [text, from, to] of linksOf(m)) {
    const [a, b] = [view.to(from), view.to(to)];
    lines.push({ kind: "link", points: [a, b] });
    const at = mid(a, b);
    const [nx, ny] = unit(a[1] - b[1], b[0] - a[0]);
    const side = Math.sign((at[0] - inside[0]) * nx + (at[1] - inside[1]) * ny) || 1;
    name(text, "ink", at, [side * nx, side * ny]);
  }
  const l21 = Math.hypot(m.a22[0] - m.o[0], m.a22[1] - m.o[1]);
  const edge = (part) => [m.o[0] + part * Math.cos(m.q21) * l21, m.o[1] + part * Math.sin(m.q21) * l21];
  const out = [Math.sin(m.q21), -Math.cos(m.q21)];
  const [centre, rim] = [edge(0.8), edge(0.8).map((k, i) => k + m.w * out[i])];
  lines.push({ kind: "dimension", points: [view.to(centre), view.to(rim)] });
  name("w", "ink", view.to(rim), [out[0], -out[1]]);
  if (m.object) {
    const [a, b] = [view.to([m.object[0], m.o[1]]), view.to(m.o)].map(([x, y]) => [x, y + 22]);
    lines.push({ kind: "dimension", points: [a, b] });
    name("base", "ink", mid(a, b), [0, 1]);
  }
  for (const [text, at, from, turn, radius, part] of [
    ["q11", m.o, 0, m.q11, 56, 0.5],
    ["q21", m.o, 0, m.q21, 38, 0.5],
    ["q12", m.a12, m.q11, m.q12, 26, 0.5],
    ["q22", m.a22, m.q21, m.q22, 36, 0.5],
    ["φ22", m.a22, m.arm, m.phi22, 22, 0.75],
  ]) {
    const [x, y] = view.to(at);
    const on = (angle, r) => [x + r * Math.cos(angle), y - r * Math.sin(angle)];
    if (text !== "φ22" && text !== "q21") lines.push({ kind: "reference", points: [[x, y], on(from, radius + 18)] });
    const pieces = Math.max(2, Math.ceil(Math.abs(turn) / 0.08));
    lines.push({ kind: "angle", points: Array.from({ length: pieces + 1 }, (_, k) => on(from + turn * k / pieces, radius)) });
    const named = from + part * turn;
    name(text, "accent", on(named, radius), [Math.cos(named), -Math.sin(named)]);
  }
  return { lines, letters };
}

// How much of a line lies under a box, in pixels (Liang and Barsky).
function under([x0, y0, x1, y1], [ax, ay], [bx, by]) {
  let [low, high] = [0, 1];
  for (const [p, q] of [[ax - bx, ax - x0], [bx - ax, x1 - ax], [ay - by, ay - y0], [by - ay, y1 - ay]]) {
    if (p === 0 && q < 0) return 0;
    if (p < 0) low = Math.max(low, q / p);
    else if (p > 0) high = Math.min(high, q / p);
  }
  return Math.max(0, high - low) * Math.hypot(bx - ax, by - ay);
}

// Boxes for letters, one after the other: near what they name, off the lines, never over each other while there is room.
function boxesFor(letters, lines, { left, top, right, bottom }) {
  const taken = [];
  const pieces = lines.flatMap(({ points }) => points.slice(1).map((point, k) => [points[k], point]));
  for (const letter of letters) {
    let best = null;
    const start = Math.atan2(letter.way[1], letter.way[0]);
    for (const reach of LETTER_REACH) {
      for (let k = 0; k < LETTER_WAYS; k++) {
        const turn = Math.ceil(k / 2) * (k % 2 ? -1 : 1);
        const angle = start + turn * 2 * Math.PI / LETTER_WAYS;
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        const r = reach + Math.max(letter.width / 2 * Math.abs(c), LETTER_HEIGHT / 2 * Math.abs(s));
        const [x, y] = [letter.at[0] + r * c, letter.at[1] + r * s];
        const box = [x - letter.width / 2, y - LETTER_HEIGHT / 2, x + letter.width / 2, y + LETTER_HEIGHT / 2];
        let cost = reach + 56 * Math.abs(turn) / LETTER_WAYS;
        if (best && cost >= best.cost) continue;
        if (box[0] < left || box[1] < top || box[2] > right || box[3] > bottom) cost += 1e6;
        const over = (other) => box[0] - LETTER_ROOM < other[2] && other[0] < box[2] + LETTER_ROOM && box[1] - LETTER_ROOM < other[3] && other[1] < box[3] + LETTER_ROOM;
        cost += 1e5 * taken.filter(over).length;
        for (const [a, b] of pieces) {
          if (best && cost >= best.cost) break;
          cost += 4 * under(box, a, b);
        }
        if (!best || cost < best.cost) best = { cost, x, y, box };
      }
    }
    taken.push(best.box);
    Object.assign(letter, best);
  }
  return letters;
}

// The tips of the force arrows, with what stands there.
function forceLetters(view, arrows) {
  return arrows.map((arrow) => {
    const [x, y] = view.to(arrow.from_m);
    const way = [arrow.way[0], -arrow.way[1]];
    const tip = [x + way[0] * arrow.length_px, y + way[1] * arrow.length_px];
    const figure = withUnit(Math.abs(arrow.force_n), "N", 3);
    const normal = arrow.kind === "normal";
    const letter = normal ? FORCES.get(arrow.contact) : undefined;
    const text = letter ? `${letter} ${figure}` : figure;
    return { text, ink: normal ? "force" : "friction", at: tip, way, shaft: { kind: "force", points: [[x, y], tip] } };
  });
}

// Draws them; returns what was drawn and where. `room` is that at the edges which has buttons over it, `lit` the letter that stands out.
function drawLetters(ctx, view, linkage, arrows, room, lit = null) {
  const { lines, letters } = lettersOf(linkage, view, forceLetters(view, arrows));
  ctx.font = LETTER_FONT;
  for (const letter of letters) letter.width = ctx.measureText(letter.text).width + 2;
  const frame = { left: 4, top: room.top, right: view.width - room.right, bottom: view.height - room.bottom };
  const shown = letters.filter(({ at: [x, y] }) => x > 0 && y > 0 && x < view.width && y < view.height);
  boxesFor(shown, lines, frame);
  // The arrows of forces are there already.
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
  for (const { text, ink, x, y, at, box } of shown) {
    if (Math.hypot(at[0] - x, at[1] - y) > 26 + (box[2] - box[0]) / 2) {
      // From the edge of the letter, not through it.
      const part = Math.min((box[2] - x) / Math.max(Math.abs(at[0] - x), 1e-9), (box[3] - y) / Math.max(Math.abs(at[1] - y), 1e-9), 1);
      ctx.beginPath();
      ctx.moveTo(x + part * (at[0] - x), y + part * (at[1] - y));
      ctx.lineTo(...at);
      ctx.lineWidth = 1;
      ctx.strokeStyle = colour("soft");
      ctx.stroke();
    }
    if (text !== lit) {
      label(ctx, text, x, y, ink, "center");
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
  return shown.map(({ text, box }) => ({ text, box }));
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
