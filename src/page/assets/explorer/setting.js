// What is simulated: a scene file and the fields that are set on top of it, with the way back.

const MOST_STEPS = 200;

class Setting {
  constructor({ file, text, set }) {
    this.past = [];
    this.future = [];
    this.take({ file, text, set });
    this.settled = this.copy();
  }

  take({ file, text, set }) {
    this.file = file;
    this.text = text;
    this.set = new Map(set);
  }

  // As plain data, which nothing changes afterwards.
  copy() {
    return { file: this.file, text: this.text, set: [...this.set] };
  }

  // A request about it.
  asks(ask, more = {}) {
    return { ask, scene: { file: this.file, text: this.text }, set: [...this.set], ...more };
  }

  // What has changed since the last step becomes one that can be undone; whether there was any.
  settle() {
    const now = this.copy();
    if (same(now, this.settled)) return false;
    this.past.push(this.settled);
    if (this.past.length > MOST_STEPS) this.past.shift();
    this.future = [];
    this.settled = now;
    return true;
  }

  // A step back (−1) or forth (1); whether there is one.
  go(way) {
    this.settle();
    const [from, to] = way < 0 ? [this.past, this.future] : [this.future, this.past];
    if (from.length === 0) return false;
    to.push(this.settled);
    this.settled = from.pop();
    this.take(this.settled);
    return true;
  }
}

const same = (a, b) => a.file === b.file && a.text === b.text && JSON.stringify(a.set) === JSON.stringify(b.set);
