// The points of a map, computed on successively finer grids.

const GRID_INTERVALS = 32;
const STRIDES = [4, 2, 1];
// Target duration of a batch of points, so that other requests are not delayed.
const BATCH_MS = 80;
const MAX_BATCH = 66;
const FIRST_BATCH = 2;

class Grid {
  // `settings` are common to all points; `x` and `y` are the fields of the axes with their ranges.
  constructor(queue, settings, x, y, onProgress) {
    Object.assign(this, { queue, settings, x, y, onProgress });
    this.points = new Map();
    // Names of the numeric and textual results that at least one point has.
    this.columns = new Set();
    this.words = new Set();
    this.failed = null;
    this.stopped = false;
    this.done = 0;
    this.total = (GRID_INTERVALS + 1) ** 2;
  }

  // The value of a field at a grid index, as text.
  textAt({ range }, k) {
    const value = range.from + (range.to - range.from) * k / GRID_INTERVALS;
    return formatValue(Number(value.toPrecision(10)), range.unit);
  }

  stop() {
    this.stopped = true;
    this.queue.cancel("map");
  }

  // Computes all points; returns whether all are complete.
  async fill() {
    let size = FIRST_BATCH;
    for (const stride of STRIDES) {
      const missing = [];
      for (let j = 0; j <= GRID_INTERVALS; j += stride) {
        for (let i = 0; i <= GRID_INTERVALS; i += stride) if (!this.points.has(j * (GRID_INTERVALS + 1) + i)) missing.push([i, j]);
      }
      while (missing.length > 0) {
        const batch = missing.splice(0, size);
        const reply = await this.queue.request("map", this.settings.request({
          fields: [this.x.path, this.y.path],
          points: batch.map(([i, j]) => [this.textAt(this.x, i), this.textAt(this.y, j)]),
        }), 2);
        if (this.stopped || !reply) return false;
        if (!this.storeBatch(batch, reply)) return false;
        size = Math.max(1, Math.min(MAX_BATCH, Math.round(size * BATCH_MS / Math.max(reply.ms, 1))));
        this.onProgress();
      }
      this.stride = stride;
      this.onProgress();
    }
    return true;
  }

  storeBatch(batch, { response, data }) {
    if (!response.columns) {
      this.failed = response.problems?.map(({ message }) => message).join(" ") || response.failed || "The simulator has not responded.";
      this.onProgress();
      return false;
    }
    const { columns, words = {}, refused = [] } = response;
    columns.forEach((name) => this.columns.add(name));
    Object.keys(words).forEach((name) => this.words.add(name));
    batch.forEach(([i, j], row) => {
      const values = new Map(columns.map((name, k) => [name, data[row * columns.length + k]]));
      // A figure may be a number at some points and a word at others.
      for (const name of Object.keys(words)) if (words[name][row] !== null || !values.has(name)) values.set(name, words[name][row]);
      this.points.set(j * (GRID_INTERVALS + 1) + i, { values, refused: refused[row] ?? null });
    });
    this.done = this.points.size;
    return true;
  }

  point(i, j) {
    return this.points.get(j * (GRID_INTERVALS + 1) + i);
  }

  // A criterion at a point: a number or text, `null` if it has no value, `undefined` if not computed yet.
  value(criterion, i, j) {
    const point = this.point(i, j);
    if (!point) return undefined;
    const value = point.values.get(criterion);
    return value === undefined || Number.isNaN(value) ? null : value;
  }

  // All values of a criterion computed so far.
  values(criterion) {
    return [...this.points.values()].map(({ values }) => values.get(criterion)).filter((value) => value !== undefined && value !== null);
  }
}
