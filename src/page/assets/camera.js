// The section of the world that the animation shows.

// Margins in pixels for the controls that cover the edges of the canvas.
const VIEW_MARGIN = { left: 10, right: 50, top: 46, bottom: 40 };

// Minimum width of a contact view, as a multiple of the maximum penetration and of the present gap.
const PENETRATIONS_IN_VIEW = 8;
const GAPS_IN_VIEW = 3;

class Camera {
  constructor(playback, canvas) {
    this.playback = playback;
    this.canvas = canvas;
    this.follow = null;
    this.zoom = 1;
    // Whether the view is turned by 180°.
    this.turned = playback.runs[0].isTurned;
    this.reload();
    this.fit();
  }

  // Adopts the present playback. The view is retained; a view that shows everything is widened if bodies would leave
  // it.
  reload() {
    const { runs } = this.playback;
    const bounds = boundingBox(runs);
    if (this.showsAll) this.widenBounds(bounds);
    else this.bounds = bounds;
    this.maxPenetrations = new Map();
    for (const name of new Set(runs.flatMap((run) => run.contacts.map((contact) => contact.name)))) {
      this.maxPenetrations.set(name, findMaxPenetration(runs, name));
    }
    if (this.follow && !this.maxPenetrations.has(this.follow)) this.fit();
  }

  widenBounds([low, high]) {
    const [l, h] = this.bounds;
    this.bounds = [[0, 1].map((k) => Math.min(l[k], low[k])), [0, 1].map((k) => Math.max(h[k], high[k]))];
    this.span = [0, 1].map((k) => this.bounds[1][k] - this.bounds[0][k]);
  }

  // Shows everything.
  fit() {
    this.bounds = boundingBox(this.playback.runs);
    const [[x0, y0], [x1, y1]] = this.bounds;
    this.follow = null;
    this.zoom = 1;
    this.showsAll = true;
    this.centre = [(x0 + x1) / 2, (y0 + y1) / 2];
    this.span = [x1 - x0, y1 - y0];
  }

  // Centres the view on a contact; `null` shows everything.
  followContact(name) {
    if (name === null) return this.fit();
    this.follow = name;
    this.zoom = 1;
    this.showsAll = false;
  }

  // Computes the view for the present contact data; returns the map from world to screen.
  computeView(contactByName) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const contact = this.follow && contactByName(this.follow);
    const [availableWidth, availableHeight] = [width - VIEW_MARGIN.left - VIEW_MARGIN.right, height - VIEW_MARGIN.top - VIEW_MARGIN.bottom];
    this.fitScale = Math.max(1, Math.min(availableWidth / this.span[0], availableHeight / this.span[1]));
    let scale = this.zoom * this.fitScale;
    const sign = this.sign();
    if (this.showsAll) {
      const [[x0, y0], [x1, y1]] = this.bounds;
      this.centre = [(x0 + x1) / 2 + sign * (VIEW_MARGIN.right - VIEW_MARGIN.left) / 2 / scale, (y0 + y1) / 2 - sign * (VIEW_MARGIN.bottom - VIEW_MARGIN.top) / 2 / scale];
    }
    if (contact && Number.isFinite(contact.gap_m)) {
      // The centre of the gap, at a scale at which the gap is visible.
      this.centre = [0, 1].map((k) => contact.point_m[k] - 0.5 * contact.gap_m * contact.normal[k]);
      const viewWidth = Math.max(GAPS_IN_VIEW * Math.abs(contact.gap_m), PENETRATIONS_IN_VIEW * this.maxPenetrations.get(this.follow));
      scale = this.zoom * Math.min(width, height) / Math.min(viewWidth, Math.max(...this.span));
    }
    this.scale = scale;
    this.size = [width, height];
    const [cx, cy] = this.centre;
    return {
      scale,
      width,
      height,
      centre: [cx, cy],
      // Angle of the world on the screen.
      angle: this.turned ? Math.PI : 0,
      toScreen: ([x, y]) => [width / 2 + sign * (x - cx) * scale, height / 2 - sign * (y - cy) * scale],
      directionToScreen: ([x, y]) => [sign * x, -sign * y],
      box: { left: -40, top: -40, right: width + 40, bottom: height + 40 },
    };
  }

  // Sign of the axes on the screen.
  sign() {
    return this.turned ? -1 : 1;
  }

  // Zooms by a factor about a point of the screen.
  zoomBy(factor, x = this.size[0] / 2, y = this.size[1] / 2) {
    const clampedFactor = Math.min(Math.max(this.scale * factor, 1e-3), 1e12) / this.scale;
    this.showsAll = false;
    const scale = this.sign() * this.scale;
    const offset = [(x - this.size[0] / 2) / scale, (this.size[1] / 2 - y) / scale];
    if (!this.follow) for (const k of [0, 1]) this.centre[k] += offset[k] * (1 - 1 / clampedFactor);
    this.zoom *= clampedFactor;
  }

  // Moves the view by pixels; it no longer follows a contact.
  panBy(dx, dy) {
    this.showsAll = false;
    if (this.follow) {
      this.zoom = this.scale / this.fitScale;
      this.follow = null;
    }
    this.centre[0] -= this.sign() * dx / this.scale;
    this.centre[1] += this.sign() * dy / this.scale;
  }
}

// Maximum penetration at a contact over all runs, or a thousandth of the view if the contact never closes.
function findMaxPenetration(runs, name) {
  let maxPenetration = 0;
  for (const run of runs) {
    const contact = run.contacts.find((candidate) => candidate.name === name);
    if (contact) for (const gap of contact.gap_m) if (-gap > maxPenetration) maxPenetration = -gap;
  }
  const [[x0], [x1]] = runs[0].extent;
  return maxPenetration > 0 ? maxPenetration : (x1 - x0) * 1e-3;
}

// Bounding box of all bodies over time, limited to a margin of one extent around the initial extent.
function boundingBox(runs) {
  const [low, high] = runs[0].extent;
  const margin = Math.max(high[0] - low[0], high[1] - low[1]);
  const box = [low[0] - margin, low[1] - margin, high[0] + margin, high[1] + margin];
  let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const run of runs) {
    for (const body of run.bodies) {
      const outline = body.shapes.flatMap(boundingPoints);
      const stride = body.fixed ? run.samples : Math.max(1, Math.floor(run.samples / 400));
      for (let i = 0; i < run.samples; i += stride) {
        for (const corner of outline) {
          const [x, y] = toWorld(corner, body.x_m[i], body.y_m[i], body.angle_rad[i]);
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
