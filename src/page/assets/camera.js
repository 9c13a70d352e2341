// Which part of the world the animation shows.

// Room in pixels for what lies over the edges of the canvas.
const ROOM = { left: 10, right: 50, top: 46, bottom: 40 };

// A view of a contact is at least so many times as wide as its deepest penetration, and so many times its gap.
const DEPTHS = 8;
const GAPS = 3;

class Camera {
  constructor(film, canvas) {
    this.film = film;
    this.canvas = canvas;
    this.follow = null;
    this.zoom = 1;
    this.renew();
    this.fit();
  }

  // Takes the film as it is now and keeps the view: while it shows everything it may widen, so that nothing leaves it.
  renew() {
    const { runs } = this.film;
    const whole = wholeOf(runs);
    if (this.wholeInView) this.widen(whole);
    else this.whole = whole;
    this.deepest = new Map();
    for (const name of new Set(runs.flatMap((run) => run.contacts.map((contact) => contact.name)))) {
      this.deepest.set(name, deepestOf(runs, name));
    }
    if (this.follow && !this.deepest.has(this.follow)) this.fit();
  }

  widen([low, high]) {
    const [l, h] = this.whole;
    this.whole = [[0, 1].map((k) => Math.min(l[k], low[k])), [0, 1].map((k) => Math.max(h[k], high[k]))];
    this.span = [0, 1].map((k) => this.whole[1][k] - this.whole[0][k]);
  }

  // Everything in view.
  fit() {
    this.whole = wholeOf(this.film.runs);
    const [[x0, y0], [x1, y1]] = this.whole;
    this.follow = null;
    this.zoom = 1;
    this.wholeInView = true;
    this.centre = [(x0 + x1) / 2, (y0 + y1) / 2];
    this.span = [x1 - x0, y1 - y0];
  }

  // The contact with a name in the middle, or `null`: the view stays where it is.
  followContact(name) {
    if (name === null) return this.fit();
    this.follow = name;
    this.zoom = 1;
    this.wholeInView = false;
  }

  // Places the view for a time; returns the maps between world and screen.
  at(reading) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const contact = this.follow && reading(this.follow);
    const [wideRoom, highRoom] = [width - ROOM.left - ROOM.right, height - ROOM.top - ROOM.bottom];
    this.fitted = Math.max(1, Math.min(wideRoom / this.span[0], highRoom / this.span[1]));
    let scale = this.zoom * this.fitted;
    if (this.wholeInView) {
      const [[x0, y0], [x1, y1]] = this.whole;
      this.centre = [(x0 + x1) / 2 + (ROOM.right - ROOM.left) / 2 / scale, (y0 + y1) / 2 - (ROOM.bottom - ROOM.top) / 2 / scale];
    }
    if (contact && Number.isFinite(contact.gap_m)) {
      // The middle of the gap, and the gap large in it.
      this.centre = [0, 1].map((k) => contact.point_m[k] - 0.5 * contact.gap_m * contact.normal[k]);
      const wide = Math.max(GAPS * Math.abs(contact.gap_m), DEPTHS * this.deepest.get(this.follow));
      scale = this.zoom * Math.min(width, height) / Math.min(wide, Math.max(...this.span));
    }
    this.scale = scale;
    this.size = [width, height];
    const [cx, cy] = this.centre;
    return {
      scale,
      width,
      height,
      centre: [cx, cy],
      to: ([x, y]) => [width / 2 + (x - cx) * scale, height / 2 - (y - cy) * scale],
      box: { left: -40, top: -40, right: width + 40, bottom: height + 40 },
    };
  }

  // Nearer by a factor, the world under a point of the screen staying there.
  zoomBy(factor, x = this.size[0] / 2, y = this.size[1] / 2) {
    const limited = Math.min(Math.max(this.scale * factor, 1e-3), 1e12) / this.scale;
    this.wholeInView = false;
    const away = [(x - this.size[0] / 2) / this.scale, (this.size[1] / 2 - y) / this.scale];
    if (!this.follow) for (const k of [0, 1]) this.centre[k] += away[k] * (1 - 1 / limited);
    this.zoom *= limited;
  }

  // Moves the world by pixels; a view that follows a contact is let go.
  panBy(dx, dy) {
    this.wholeInView = false;
    if (this.follow) {
      this.zoom = this.scale / this.fitted;
      this.follow = null;
    }
    this.centre[0] -= dx / this.scale;
    this.centre[1] += dy / this.scale;
  }
}

// Largest penetration at a contact in any run, or a thousandth of the view where it never touches.
function deepestOf(runs, name) {
  let deepest = 0;
  for (const run of runs) {
    const contact = run.contacts.find((each) => each.name === name);
    if (contact) for (const gap of contact.gap_m) if (-gap > deepest) deepest = -gap;
  }
  const [[x0], [x1]] = runs[0].extent;
  return deepest > 0 ? deepest : (x1 - x0) * 1e-3;
}

// All bodies, and where they go as far as that is not much further.
function wholeOf(runs) {
  const [low, high] = runs[0].extent;
  const most = Math.max(high[0] - low[0], high[1] - low[1]);
  const box = [low[0] - most, low[1] - most, high[0] + most, high[1] + most];
  let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const run of runs) {
    for (const body of run.bodies) {
      const outline = body.shapes.flatMap(corners);
      const stride = body.fixed ? run.samples : Math.max(1, Math.floor(run.samples / 400));
      for (let i = 0; i < run.samples; i += stride) {
        for (const corner of outline) {
          const [x, y] = placed(corner, body.x_m[i], body.y_m[i], body.angle_rad[i]);
          x0 = Math.max(Math.min(x0, x), box[0]);
          y0 = Math.max(Math.min(y0, y), box[1]);
          x1 = Math.min(Math.max(x1, x), box[2]);
          y1 = Math.min(Math.max(y1, y), box[3]);
        }
      }
    }
  }
  return x0 < x1 && y0 < y1 ? [[x0, y0], [x1, y1]] : runs[0].extent;
}
