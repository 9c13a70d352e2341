// The animation: bodies, contact points, force arrows, scale bar.

// Number of decades of force that logarithmic arrows resolve.
const ARROW_DECADES = 6;

class Stage {
  constructor(playback, canvas) {
    this.playback = playback;
    this.canvas = canvas;
    this.camera = new Camera(playback, canvas);
    this.arrowsToScale = false;
    // Whether the symbols are always shown.
    this.showsSymbols = false;
    // The symbol of the field under the pointer, which is highlighted.
    this.highlightedSymbol = null;
    this.pointer = null;
    this.symbols = [];
    // The last drawing, for tests.
    this.drawnRuns = [];
    this.labels = [];
    this.findLargestForce();
  }

  // Adopts the present playback; the view is retained.
  reload() {
    this.findLargestForce();
    this.camera.reload();
  }

  // Finds the largest force, the reference of logarithmic arrows.
  findLargestForce() {
    this.largestForce = 0;
    for (const run of this.playback.runs) {
      for (const contact of run.contacts) {
        for (const force of contact.normal_n) this.largestForce = Math.max(this.largestForce, force);
      }
    }
  }

  draw(time) {
    const { ctx, width, height } = clearCanvas(this.canvas);
    const visibleRuns = this.playback.runs.filter((run) => run.visible);
    const first = visibleRuns[0] ?? this.playback.runs[0];
    const view = this.camera.computeView((name) => contactAt(first, name, locateSample(first, time)));
    this.drawnRuns = [];
    const states = visibleRuns.map((run) => this.runState(run, locateSample(run, time), view));
    this.drawBodies(ctx, view, first, locateSample(first, time), isFixed, 0);
    // Fixed bodies are drawn once if they are equal in all runs.
    const knownBodies = new Set(first.bodies.filter(isFixed).map(signature));
    const other = (body) => isFixed(body) && !knownBodies.has(signature(body));
    states.forEach((state) => state.run !== first && this.drawBodies(ctx, view, state.run, state.position, other, 1));
    for (const { run } of states) for (const other of run.variationRuns ?? []) this.drawBodies(ctx, view, other, locateSample(other, time), isMoving, 2);
    states.forEach((state) => this.drawBodies(ctx, view, state.run, state.position, isMoving, state.run.index));
    if (states.length > 0) this.drawOverlaps(ctx, view, states[0]);
    states.forEach((state) => this.drawContactPoints(ctx, view, state));
    const linkage = this.symbolLinkage(view, states[0]);
    this.labels = [];
    states.forEach((state, index) => this.drawArrows(ctx, view, state, index === 0 && !linkage));
    this.drawScaleBar(ctx, view, width, height);
    this.symbols = linkage ? drawSymbols(ctx, view, linkage, states[0].arrows, VIEW_MARGIN, this.highlightedSymbol) : [];
    this.drawnRuns = states;
  }

  // The linkage of the first visible run if its symbols are to be shown, or null.
  symbolLinkage(view, state) {
    const linkage = state ? findLinkage(state.run, state.bodies) : null;
    this.isHovered = Boolean(linkage && this.pointer && isOverLink(linkage, view, this.pointer));
    return this.showsSymbols || this.isHovered || this.highlightedSymbol ? linkage : null;
  }

  // Bodies, contacts and arrows of a run at a sample position.
  runState(run, position, view) {
    const bodies = run.bodies.map((body) => ({ name: body.name, ...poseAt(body, position) }));
    const contacts = run.contacts.map((contact) => contactAt(run, contact.name, position));
    const arrows = contacts.flatMap((contact) => this.contactArrows(run, contact, view));
    return { run, position, bodies, contacts, arrows };
  }

  // The arrows of a contact, with origin, direction and length on the screen.
  contactArrows(run, contact, view) {
    const { normal, point_m } = contact;
    const tangent = [-normal[1], normal[0]];
    const createArrow = (kind, force, direction) => {
      const length = this.arrowLength(run, force, view);
      const sign = Math.sign(force);
      return { contact: contact.name, kind, force_n: force, from_m: point_m, direction: direction.map((k) => sign * k), length_px: length };
    };
    const arrows = [createArrow("normal", contact.normal_n, normal), createArrow("friction", contact.tangential_n, tangent)];
    return arrows.filter((arrow) => arrow.length_px > 1);
  }

  arrowLength(run, force, view) {
    const magnitude = Math.abs(force);
    if (!(magnitude > 0)) return 0;
    if (this.arrowsToScale) return Math.min(magnitude * run.arrowPerNewton, run.longestArrow) * view.scale;
    const fraction = 1 + Math.log10(magnitude / this.largestForce) / ARROW_DECADES;
    return Math.max(0, fraction) * 0.32 * Math.min(view.width, view.height);
  }

  // Draws the bodies of a run that satisfy a predicate. Style: 0 filled, 1 dashed, 2 thin (a perturbed run).
  drawBodies(ctx, view, run, position, predicate, style) {
    for (const body of run.bodies.filter(predicate)) {
      const { fixed } = body;
      const { x_m: x, y_m: y, angle_rad: angle } = poseAt(body, position);
      const hasSurface = body.shapes.some((shape) => shape.kind === "capsule");
      for (const shape of body.shapes) {
        // The outline of the mass is fainter than the contact surface.
        const isFaint = hasSurface && shape.kind === "polygon";
        tracePath(ctx, shapeOutline(shape, x, y, angle, view), view);
        if (style === 0) {
          ctx.globalAlpha = fixed ? 1 : 0.82;
          ctx.fillStyle = colour(body.part);
          ctx.fill();
          ctx.globalAlpha = 1;
          ctx.setLineDash([]);
          ctx.lineWidth = isFaint ? 0.75 : 1.25;
          ctx.strokeStyle = colour(fixed ? "soft" : "edge");
        } else if (style === 2) {
          ctx.globalAlpha = 0.4;
          ctx.setLineDash([]);
          ctx.lineWidth = 1;
          ctx.strokeStyle = colour("warn");
        } else {
          ctx.globalAlpha = isFaint ? 0.55 : run.isReference ? 0.7 : 1;
          ctx.setLineDash([6, 4]);
          ctx.lineWidth = isFaint ? 1 : 1.75;
          ctx.strokeStyle = colour("edge-b");
        }
        ctx.stroke();
        ctx.globalAlpha = 1;
      }
      if (style === 0 && !fixed) this.drawMarks(ctx, view, body, x, y, angle);
    }
    ctx.setLineDash([]);
  }

  // Draws rings at the marked points of a body, such as pins, and a radius that shows the rotation of a disc.
  drawMarks(ctx, view, body, x, y, angle) {
    ctx.strokeStyle = colour("edge");
    ctx.lineWidth = 1.25;
    if (body.shapes.length === 1 && body.shapes[0].kind === "disc") {
      const rim = view.toScreen(toWorld([body.shapes[0].radius_m, 0], x, y, angle));
      const centre = view.toScreen([x, y]);
      if (Math.hypot(rim[0] - centre[0], rim[1] - centre[1]) > 1e5) return;
      ctx.beginPath();
      ctx.moveTo(...centre);
      ctx.lineTo(...rim);
      ctx.stroke();
    }
    for (const mark of body.marks_m) {
      const [px, py] = view.toScreen(toWorld(mark, x, y, angle));
      if (Math.abs(px) > 1e5 || Math.abs(py) > 1e5) continue;
      ctx.beginPath();
      ctx.arc(px, py, 3, 0, 2 * Math.PI);
      ctx.fillStyle = colour("panel");
      ctx.fill();
      ctx.stroke();
    }
  }

  // Fills the overlap of surfaces: a strip of micrometres that is visible only in a contact view.
  drawOverlaps(ctx, view, { run, position, contacts }) {
    if (!contacts.some((contact) => contact.gap_m < 0)) return;
    const surfaces = run.bodies.map((body) => {
      const { x_m: x, y_m: y, angle_rad: angle } = poseAt(body, position);
      const shapes = body.shapes.filter((shape) => shape.kind !== "polygon");
      return { body, outlines: shapes.map((shape) => shapeOutline(shape, x, y, angle, view)) };
    });
    // Only bodies that can touch each other: links overlap at their joints and cover the palm.
    const isContactBody = ({ body }) => body.part === "object";
    const canTouch = (first, other) => (isContactBody(first) || isContactBody(other)) && !(first.body.fixed && other.body.fixed);
    ctx.fillStyle = colour("force");
    for (const [index, first] of surfaces.entries()) {
      for (const second of surfaces.slice(index + 1).filter((candidate) => canTouch(first, candidate))) {
        for (const firstOutline of first.outlines) {
          for (const secondOutline of second.outlines) {
            ctx.save();
            tracePath(ctx, secondOutline, view);
            ctx.clip();
            tracePath(ctx, firstOutline, view);
            ctx.globalAlpha = 0.45;
            ctx.fill();
            ctx.restore();
          }
        }
      }
    }
  }

  drawContactPoints(ctx, view, { contacts, run }) {
    for (const contact of contacts) {
      if (!(contact.normal_n > 0)) continue;
      const [x, y] = view.toScreen(contact.point_m);
      ctx.beginPath();
      ctx.arc(x, y, 4, 0, 2 * Math.PI);
      ctx.lineWidth = 2;
      ctx.strokeStyle = colour("force");
      ctx.fillStyle = run.index === 0 ? colour("force") : colour("panel");
      ctx.fill();
      ctx.stroke();
    }
  }

  drawArrows(ctx, view, { arrows, run }, showsValues) {
    for (const arrow of arrows) {
      const { origin: [x, y], direction: [dx, dy], tip } = arrowOnScreen(arrow, view);
      if (!isInBox([x, y], view.box)) continue;
      const head = Math.min(run.index === 0 ? 15 : 9, 0.6 * arrow.length_px);
      const kind = colour(arrow.kind === "normal" ? "force" : "friction");
      [ctx.fillStyle, ctx.strokeStyle] = [kind, run.index === 0 ? kind : colour("edge-b")];
      ctx.lineWidth = run.index === 0 ? 4.5 : 1.5;
      ctx.setLineDash(run.index === 0 ? [] : [5, 3]);
      ctx.beginPath();
      ctx.moveTo(x, y);
      ctx.lineTo(tip[0] - dx * head, tip[1] - dy * head);
      ctx.stroke();
      ctx.setLineDash([]);
      ctx.beginPath();
      ctx.moveTo(...tip);
      ctx.lineTo(tip[0] - dx * head - dy * head * 0.45, tip[1] - dy * head + dx * head * 0.45);
      ctx.lineTo(tip[0] - dx * head + dy * head * 0.45, tip[1] - dy * head - dx * head * 0.45);
      ctx.closePath();
      if (run.index === 0) {
        ctx.fill();
      } else {
        ctx.fillStyle = colour("panel");
        ctx.fill();
        ctx.stroke();
      }
    }
    if (showsValues) this.labels = this.drawArrowLabels(ctx, view, arrows);
  }

  // Writes the forces next to the tips of their arrows, the largest first: off the buttons, the arrow and each other, or
  // not at all. Returns the texts with their places.
  drawArrowLabels(ctx, view, arrows) {
    const { left, top } = this.canvas.getBoundingClientRect();
    const buttons = [...this.canvas.parentElement.querySelectorAll("select, button")].map((button) => button.getBoundingClientRect());
    const onButton = (x, y, halfWidth) => buttons.some((box) => Math.abs((box.left + box.right) / 2 - left - x) < box.width / 2 + halfWidth && Math.abs((box.top + box.bottom) / 2 - top - y) < box.height / 2 + 8);
    const labels = [];
    for (const arrow of [...arrows].sort((a, b) => Math.abs(b.force_n) - Math.abs(a.force_n))) {
      const { origin, direction: [dx, dy], tip } = arrowOnScreen(arrow, view);
      if (!isInBox(origin, view.box)) continue;
      const text = formatQuantity(Math.abs(arrow.force_n), "N", 3);
      const halfWidth = ctx.measureText(text).width / 2 + 4;
      for (const [along, across] of [[0, 0], [0, 1], [0, -1], [1, 0], [-1, 1], [-1, -1]]) {
        const [right, down] = [along * dx - across * dy, along * dy + across * dx];
        const x = Math.min(Math.max(tip[0] + dx * (halfWidth + 6) + 2 * halfWidth * right, halfWidth + 4), view.width - halfWidth - 4);
        const y = Math.min(Math.max(tip[1] + dy * 14 + 16 * down, 12), view.height - 12);
        const onArrow = lengthInBox([x - halfWidth, y - 8, x + halfWidth, y + 8], origin, tip) > 0;
        const onLabel = labels.some((other) => Math.abs(other.x - x) < other.halfWidth + halfWidth && Math.abs(other.y - y) < 15);
        if (onArrow || onLabel || onButton(x, y, halfWidth)) continue;
        drawLabel(ctx, text, x, y, arrow.kind === "normal" ? "force" : "friction", "center");
        labels.push({ text, x, y, halfWidth });
        break;
      }
    }
    return labels;
  }

  // Draws a scale bar of a round length at the lower left.
  drawScaleBar(ctx, view, width, height) {
    const targetLength = Math.min(110, width / 4) / view.scale;
    const decade = 10 ** Math.floor(Math.log10(targetLength));
    const length = [5, 2, 1].find((candidate) => candidate * decade <= targetLength) * decade;
    const px = length * view.scale;
    const [x, y] = [14, height - 14];
    ctx.beginPath();
    ctx.moveTo(x, y - 5);
    ctx.lineTo(x, y);
    ctx.lineTo(x + px, y);
    ctx.lineTo(x + px, y - 5);
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = colour("ink");
    ctx.stroke();
    const visibleRuns = displayUnit("m", length);
    drawLabel(ctx, Number((length * visibleRuns.factor).toPrecision(1)) + "\u202f" + visibleRuns.unit, x + px + 8, y - 3);
  }
}

// Origin, direction and tip of an arrow on the screen.
function arrowOnScreen({ from_m, direction: inWorld, length_px }, view) {
  const [origin, direction] = [view.toScreen(from_m), view.directionToScreen(inWorld)];
  return { origin, direction, tip: [0, 1].map((k) => origin[k] + direction[k] * length_px) };
}

const isInBox = ([x, y], { left, right, top, bottom }) => x >= left && x <= right && y >= top && y <= bottom;

const isFixed = (body) => body.fixed;
const isMoving = (body) => !body.fixed;

// Shape and pose of a fixed body, to compare it across runs.
const signature = (body) => JSON.stringify([body.shapes, body.x_m[0], body.y_m[0], body.angle_rad[0]]);

// A contact of a run at a sample position.
function contactAt(run, name, position) {
  const contact = run.contacts.find((candidate) => candidate.name === name);
  if (!contact) return null;
  const value = (key) => interpolate(contact[key], position);
  return {
    name,
    gap_m: interpolate(contact.gap_m, position, contact.gap_rate_m_s),
    normal_n: value("normal_n"),
    tangential_n: value("tangential_n"),
    point_m: [value("point_x_m"), value("point_y_m")],
    normal: [value("normal_x"), value("normal_y")],
  };
}
