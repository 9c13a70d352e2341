// The points of a map, computed coarse first and then between them.

const FINEST = 32;
const STRIDES = [4, 2, 1];
// Points are asked for in pieces of about this long, so that other questions need not wait.
const PIECE_MS = 80;
const MOST_POINTS = 66;

class Grid {
  // `setting` is what all points share; two fields with their ranges go along the axes.
  constructor(line, setting, x, y, changed) {
    Object.assign(this, { line, setting, x, y, changed });
    this.points = new Map();
    this.columns = null;
    this.words = [];
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
    let size = 8;
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
    this.columns = answer.columns;
    this.words = Object.keys(answer.words ?? {});
    piece.forEach(([i, j], row) => {
      const numbers = data.subarray(row * answer.columns.length, (row + 1) * answer.columns.length);
      const words = Object.fromEntries(this.words.map((name) => [name, answer.words[name][row]]));
      this.points.set(j * (FINEST + 1) + i, { numbers, words });
    });
    this.done = this.points.size;
    return true;
  }

  // A criterion at a point: a number, a word, or `undefined` while it is not known.
  value(criterion, i, j) {
    const point = this.points.get(j * (FINEST + 1) + i);
    if (!point) return undefined;
    if (this.words.includes(criterion)) return point.words[criterion] ?? null;
    const column = this.columns.indexOf(criterion);
    return column < 0 ? undefined : point.numbers[column];
  }
}
