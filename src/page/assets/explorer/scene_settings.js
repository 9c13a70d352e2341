// The settings: a scene file and overridden fields, with a history for undo.

const MAX_UNDO_STEPS = 200;

class SceneSettings {
  constructor({ file, text, set }) {
    this.past = [];
    this.future = [];
    this.load({ file, text, set });
    this.committed = this.copy();
  }

  load({ file, text, set }) {
    this.file = file;
    this.text = text;
    this.set = new Map(set);
  }

  // Returns an independent copy as plain data.
  copy() {
    return { file: this.file, text: this.text, set: [...this.set] };
  }

  // Creates a request for the present settings.
  request(kind, extra = {}) {
    return { ask: kind, scene: { file: this.file, text: this.text }, set: [...this.set], ...extra };
  }

  // Commits the changes as an undo step; returns whether there were any.
  commit() {
    const current = this.copy();
    if (isSameScene(current, this.committed)) return false;
    this.past.push(this.committed);
    if (this.past.length > MAX_UNDO_STEPS) this.past.shift();
    this.future = [];
    this.committed = current;
    return true;
  }

  // Undoes (−1) or redoes (1) a step; returns whether there was one.
  moveInHistory(direction) {
    this.commit();
    const [source, target] = direction < 0 ? [this.past, this.future] : [this.future, this.past];
    if (source.length === 0) return false;
    target.push(this.committed);
    this.committed = source.pop();
    this.load(this.committed);
    return true;
  }
}

const isSameScene = (a, b) => a.file === b.file && a.text === b.text && JSON.stringify(a.set) === JSON.stringify(b.set);
