// The points of a map, computed coarse first and then between them.

const FINEST = 32;
const STRIDES = [4, 2, 1];
// Points are asked for in pieces of about this long, so that other questions need not wait.
const PIECE_MS = 80;
const MOST_POINTS = 66;
const FIRST = 2;

class Grid {
  // `setting` is what all points share; two fields with their ranges go along the axes.
  constructor(line, setting, x, y, changed) {
    Object.assign(this, { line, setting, x, y, changed });
    this.points = new Map();
    // Names of numbers and of words, as far as any point has them: where nothing holds there is nothing to tell.
    this.columns = new Set();
    this.words = new Set();
    this.failed = null;
    this.stopped = false;
    this.done = 0;
    this.total = (FINEST + 1) ** 2;
  }

  // The text of a field's value at a place of its axis.
  textAt({ range }, k) {
    const value = range.from + (range.to - range.from) * k / FINEST;
    return asText(Number(value.toPrecision(10)), range.unit);
  }

  stop() {
    this.stopped = true;
    this.line.drop("map");
  }

  // Computes all points; resolves when they are there or nobody wants them any more.
  async fill() {
    let size = FIRST;
    for (const stride of STRIDES) {
      const wanted = [];
      for (let j = 0; j <= FINEST; j += stride) {
        for (let i = 0; i <= FINEST; i += stride) if (!this.points.has(j * (FINEST + 1) + i)) wanted.push([i, j]);
      }
      while (wanted.length > 0) {
        const piece = wanted.splice(0, size);
        const heard = await this.line.ask("map", this.setting.request({
          fields: [this.x.path, this.y.path],
          points: piece.map(([i, j]) => [this.textAt(this.x, i), this.textAt(this.y, j)]),
        }), 2);
        if (this.stopped || !heard) return false;
        if (!this.take(piece, heard)) return false;
        size = Math.max(1, Math.min(MOST_POINTS, Math.round(size * PIECE_MS / Math.max(heard.ms, 1))));
        this.changed();
      }
      this.stride = stride;
      this.changed();
    }
    return true;
  }

  take(piece, { answer, data }) {
    if (!answer.columns) {
      this.failed = answer.problems?.map(({ message }) => message).join(" ") || answer.failed || "No answer.";
      this.changed();
      return false;
    }
    const { columns, words = {}, refused = [] } = answer;
    columns.forEach((name) => this.columns.add(name));
    Object.keys(words).forEach((name) => this.words.add(name));
    piece.forEach(([i, j], row) => {
      const found = new Map(columns.map((name, k) => [name, data[row * columns.length + k]]));
      for (const name of Object.keys(words)) found.set(name, words[name][row]);
      this.points.set(j * (FINEST + 1) + i, { found, refused: refused[row] ?? null });
    });
    this.done = this.points.size;
    return true;
  }

  point(i, j) {
    return this.points.get(j * (FINEST + 1) + i);
  }

  // A criterion at a point: a number, a word, `null` where there is none, `undefined` while it is not known.
  value(criterion, i, j) {
    const point = this.point(i, j);
    if (!point) return undefined;
    const value = point.found.get(criterion);
    return value === undefined || Number.isNaN(value) ? null : value;
  }

  // All values of a criterion.
  values(criterion) {
    return [...this.points.values()].map(({ found }) => found.get(criterion)).filter((value) => value !== undefined && value !== null);
  }
}
