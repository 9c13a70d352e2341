// Workers and the requests that wait for them.

// A request that has taken so long is dropped for a newer one of its kind.
const PATIENCE_MS = 700;

// The module out of the page: a compressed file in base85.
async function moduleOf({ module, module_bytes: length }) {
  const bytes = bytesOf(module, length);
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  // What has come is compiled while the rest is unpacked.
  return WebAssembly.compileStreaming(new Response(plain, { headers: { "content-type": "application/wasm" } }));
}

// One worker and its queue. Of requests of one kind only the newest waits; who asked for an older one hears `null`.
class Line {
  constructor(module) {
    this.module = module;
    this.address = URL.createObjectURL(new Blob([`(${workerBody})();`], { type: "text/javascript" }));
    this.waiting = [];
    this.current = null;
    this.count = 0;
    this.start();
  }

  async start() {
    const worker = new Worker(this.address);
    this.worker = worker;
    worker.onmessage = ({ data }) => this.heard(data);
    worker.onerror = (event) => this.heard({ id: this.current?.id, answer: { failed: event.message || "the worker has failed" }, data: new ArrayBuffer(0), ms: 0 });
    worker.postMessage({ module: await this.module });
    if (worker !== this.worker) return;
    this.ready = true;
    this.next();
  }

  // The answer to a request: `{ answer, data, ms }`. The least urgent have the highest `rank`.
  ask(kind, request, rank = 0) {
    return new Promise((resolve) => {
      const before = this.waiting.findIndex((each) => each.kind === kind);
      if (before >= 0) this.waiting.splice(before, 1)[0].resolve(null);
      this.waiting.push({ id: this.count++, kind, request, rank, resolve });
      this.waiting.sort((a, b) => a.rank - b.rank || a.id - b.id);
      if (this.current?.kind === kind) this.hurry();
      this.next();
    });
  }

  // Forgets what waits of a kind, and what is under way if it takes too long.
  drop(kind) {
    for (const each of this.waiting.filter((one) => one.kind === kind)) each.resolve(null);
    this.waiting = this.waiting.filter((one) => one.kind !== kind);
    if (this.current?.kind === kind) this.hurry();
  }

  // Nobody wants what is under way any more: it may finish soon, or not at all.
  hurry() {
    const { current } = this;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (this.current !== current) return;
      this.worker.terminate();
      this.current = null;
      this.ready = false;
      current.resolve(null);
      this.start();
    }, Math.max(0, current.since + PATIENCE_MS - performance.now()));
  }

  next() {
    if (!this.ready || this.current || this.waiting.length === 0) return;
    this.current = this.waiting.shift();
    this.current.since = performance.now();
    const { id, request } = this.current;
    this.worker.postMessage({ id, request });
  }

  heard({ id, answer, data, ms }) {
    const { current } = this;
    if (!current || current.id !== id) return;
    this.current = null;
    clearTimeout(this.timer);
    current.resolve({ answer, data: new Float64Array(data), ms });
    this.next();
  }
}
