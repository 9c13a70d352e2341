// The animation: bodies, contact points, force arrows, scale.

// Forces over so many decades have arrows of a length that tells them apart.
const DECADES = 6;

class Stage {
  constructor(film, canvas) {
    this.film = film;
    this.canvas = canvas;
    this.camera = new Camera(film, canvas);
    this.arrowsToScale = false;
    // Whether letters were asked for, and where a pointer is.
    this.named = false;
    // The letter of a variable that is under someone's hand: it stands out.
    this.hinted = null;
    this.pointer = null;
    this.letters = [];
    // What was last drawn, for whoever checks it.
    this.drawn = [];
    this.measure();
  }

  // Takes the film as it is now; the view stays.
  renew() {
    this.measure();
    this.camera.renew();
  }

  // The largest force, of which all arrows are parts.
  measure() {
    this.largest = 0;
    for (const run of this.film.runs) {
      for (const contact of run.contacts) {
        for (const force of contact.normal_n) this.largest = Math.max(this.largest, force);
      }
    }
  }

  draw(time) {
    const { ctx, width, height } = cleared(this.canvas);
    const shown = this.film.runs.filter((run) => run.visible);
    const first = shown[0] ?? this.film.runs[0];
    const view = this.camera.at((name) => contactAt(first, name, placeAt(first, time)));
    this.drawn = [];
    const states = shown.map((run) => this.state(run, placeAt(run, time), view));
    this.bodies(ctx, view, first, placeAt(first, time), fixed, 0);
    // What stays where it is is drawn once, unless another run has something else there.
    const known = new Set(first.bodies.filter(fixed).map(signature));
    const other = (body) => fixed(body) && !known.has(signature(body));
    states.forEach((state) => state.run !== first && this.bodies(ctx, view, state.run, state.place, other, 1));
    for (const { run } of states) for (const other of run.cloud ?? []) this.bodies(ctx, view, other, placeAt(other, time), moving, 2);
    states.forEach((state) => this.bodies(ctx, view, state.run, state.place, moving, state.run.index));
    if (states.length > 0) this.overlaps(ctx, view, states[0]);
    states.forEach((state) => this.contactPoints(ctx, view, state));
    const linkage = this.namedLinkage(view, states[0]);
    states.forEach((state, index) => this.arrows(ctx, view, state, index === 0 && !linkage));
    this.ruler(ctx, view, width, height);
    this.letters = linkage ? drawLetters(ctx, view, linkage, states[0].arrows, ROOM, this.hinted) : [];
    this.drawn = states;
  }

  // The linkage of the first run that is shown, if its letters are wanted.
  namedLinkage(view, state) {
    const linkage = state ? linkageOf(state.run, state.bodies) : null;
    this.pointed = Boolean(linkage && this.pointer && pointsAt(linkage, view, this.pointer));
    return this.named || this.pointed || this.hinted ? linkage : null;
  }

  // Everything of a run that is drawn at a place among its samples.
  state(run, place, view) {
    const bodies = run.bodies.map((body) => ({ name: body.name, ...poseAt(body, place) }));
    const contacts = run.contacts.map((contact) => contactAt(run, contact.name, place));
    const arrows = contacts.flatMap((contact) => this.arrowsOf(run, contact, view));
    return { run, place, bodies, contacts, arrows };
  }

  // The arrows of a contact: from its point, along the force, with their length on the screen.
  arrowsOf(run, contact, view) {
    const { normal, point_m } = contact;
    const tangent = [-normal[1], normal[0]];
    const of = (kind, force, way) => {
      const length = this.arrowLength(run, force, view);
      const sign = Math.sign(force);
      return { contact: contact.name, kind, force_n: force, from_m: point_m, way: way.map((k) => sign * k), length_px: length };
    };
    const both = [of("normal", contact.normal_n, normal), of("friction", contact.tangential_n, tangent)];
    return both.filter((arrow) => arrow.length_px > 1);
  }

  arrowLength(run, force, view) {
    const size = Math.abs(force);
    if (!(size > 0)) return 0;
    if (this.arrowsToScale) return Math.min(size * run.arrowPerNewton, run.longestArrow) * view.scale;
    const part = 1 + Math.log10(size / this.largest) / DECADES;
    return Math.max(0, part) * 0.32 * Math.min(view.width, view.height);
  }

  // Some bodies of a run, in one of three styles: 0 filled, 1 dashed, 2 thin as one of many.
  bodies(ctx, view, run, place, which, style) {
    for (const body of run.bodies.filter(which)) {
      const { fixed } = body;
      const { x_m: x, y_m: y, angle_rad: angle } = poseAt(body, place);
      const surface = body.shapes.some((shape) => shape.kind === "capsule");
      for (const shape of body.shapes) {
        // Where a body has a surface that touches, the outline of its mass is drawn weaker.
        const weak = surface && shape.kind === "polygon";
        trace(ctx, outline(shape, x, y, angle, view), view);
        if (style === 0) {
          ctx.globalAlpha = fixed ? 1 : 0.82;
          ctx.fillStyle = colour(body.part);
          ctx.fill();
          ctx.globalAlpha = 1;
          ctx.setLineDash([]);
          ctx.lineWidth = weak ? 0.75 : 1.25;
          ctx.strokeStyle = colour(fixed ? "soft" : "edge");
        } else if (style === 2) {
          ctx.globalAlpha = 0.4;
          ctx.setLineDash([]);
          ctx.lineWidth = 1;
          ctx.strokeStyle = colour("warn");
        } else {
          ctx.globalAlpha = weak ? 0.55 : run.kept ? 0.7 : 1;
          ctx.setLineDash([6, 4]);
          ctx.lineWidth = weak ? 1 : 1.75;
          ctx.strokeStyle = colour("edge-b");
        }
        ctx.stroke();
        ctx.globalAlpha = 1;
      }
      if (style === 0 && !fixed && body.part !== "palm") this.joints(ctx, view, body, x, y, angle);
    }
    ctx.setLineDash([]);
  }

  // Rings where links turn; on a disc, a line that shows how it has turned.
  joints(ctx, view, body, x, y, angle) {
    ctx.strokeStyle = colour("edge");
    ctx.lineWidth = 1.25;
    if (body.part === "disc") {
      const rim = view.to(placed([body.shapes[0].radius_m, 0], x, y, angle));
      const centre = view.to([x, y]);
      if (Math.hypot(rim[0] - centre[0], rim[1] - centre[1]) > 1e5) return;
      ctx.beginPath();
      ctx.moveTo(...centre);
      ctx.lineTo(...rim);
      ctx.stroke();
      return;
    }
    const ends = [[0, 0]];
    const bar = body.shapes[0];
    // A bar reaches as far beyond its second joint as beyond its first.
    if (body.part === "coupler" && bar.kind === "polygon") {
      const along = bar.corners_m.map((corner) => corner[0]);
      ends.push([Math.min(...along) + Math.max(...along), 0]);
    }
    for (const end of ends) {
      const [px, py] = view.to(placed(end, x, y, angle));
      if (Math.abs(px) > 1e5 || Math.abs(py) > 1e5) continue;
      ctx.beginPath();
      ctx.arc(px, py, 3, 0, 2 * Math.PI);
      ctx.fillStyle = colour("panel");
      ctx.fill();
      ctx.stroke();
    }
  }

  // Where surfaces are in each other: a strip of micrometres that only a contact view shows.
  overlaps(ctx, view, { run, place, contacts }) {
    if (!contacts.some((contact) => contact.gap_m < 0)) return;
    const surfaces = run.bodies.map((body) => {
      const { x_m: x, y_m: y, angle_rad: angle } = poseAt(body, place);
      const shapes = body.shapes.filter((shape) => shape.kind !== "polygon");
      return { body, outlines: shapes.map((shape) => outline(shape, x, y, angle, view)) };
    });
    // Links overlap at their joints, and are drawn over the palm: only what may touch counts.
    const touches = ({ body }) => body.part === "object" || body.part === "disc";
    const meet = (one, other) => (touches(one) || touches(other)) && !(one.body.fixed && other.body.fixed);
    ctx.fillStyle = colour("force");
    for (const [index, one] of surfaces.entries()) {
      for (const other of surfaces.slice(index + 1).filter((each) => meet(one, each))) {
        for (const inner of one.outlines) {
          for (const outer of other.outlines) {
            ctx.save();
            trace(ctx, outer, view);
            ctx.clip();
            trace(ctx, inner, view);
            ctx.globalAlpha = 0.45;
            ctx.fill();
            ctx.restore();
          }
        }
      }
    }
  }

  contactPoints(ctx, view, { contacts, run }) {
    for (const contact of contacts) {
      if (!(contact.normal_n > 0)) continue;
      const [x, y] = view.to(contact.point_m);
      ctx.beginPath();
      ctx.arc(x, y, 4, 0, 2 * Math.PI);
      ctx.lineWidth = 2;
      ctx.strokeStyle = colour("force");
      ctx.fillStyle = run.index === 0 ? colour("force") : colour("panel");
      ctx.fill();
      ctx.stroke();
    }
  }

  arrows(ctx, view, { arrows, run }, named) {
    for (const arrow of arrows) {
      const [x, y] = view.to(arrow.from_m);
      const { left, right, top, bottom } = view.box;
      if (x < left || x > right || y < top || y > bottom) continue;
      const [dx, dy] = [arrow.way[0], -arrow.way[1]];
      const tip = [x + dx * arrow.length_px, y + dy * arrow.length_px];
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
      if (named) this.arrowName(ctx, view, arrow, tip, [dx, dy]);
    }
  }

  // The force beside the tip of its arrow, within the view.
  arrowName(ctx, view, arrow, tip, [dx, dy]) {
    const text = withUnit(Math.abs(arrow.force_n), "N", 3);
    const half = ctx.measureText(text).width / 2 + 4;
    const x = Math.min(Math.max(tip[0] + dx * (half + 6), half + 4), view.width - half - 4);
    const y = Math.min(Math.max(tip[1] + dy * 14, 12), view.height - 12);
    label(ctx, text, x, y, arrow.kind === "normal" ? "force" : "friction", "center");
  }

  // A length that is easy to read, at the lower left.
  ruler(ctx, view, width, height) {
    const target = Math.min(110, width / 4) / view.scale;
    const power = 10 ** Math.floor(Math.log10(target));
    const length = [5, 2, 1].find((each) => each * power <= target) * power;
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
    const shown = shownUnit("m", length);
    label(ctx, Number((length * shown.factor).toPrecision(1)) + "\u202f" + shown.unit, x + px + 8, y - 3);
  }
}

const fixed = (body) => body.fixed;
const moving = (body) => !body.fixed;

// What a fixed body looks like, to find it again in another run.
const signature = (body) => JSON.stringify([body.shapes, body.x_m[0], body.y_m[0], body.angle_rad[0]]);

// A contact of a run at a place among its samples.
function contactAt(run, name, place) {
  const contact = run.contacts.find((each) => each.name === name);
  if (!contact) return null;
  const value = (key) => valueAt(contact[key], place);
  return {
    name,
    gap_m: valueAt(contact.gap_m, place, contact.gap_rate_m_s),
    normal_n: value("normal_n"),
    tangential_n: value("tangential_n"),
    point_m: [value("point_x_m"), value("point_y_m")],
    normal: [value("normal_x"), value("normal_y")],
  };
}
