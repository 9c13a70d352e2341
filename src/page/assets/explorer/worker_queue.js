// A worker and its queue of requests.

// A superseded request is terminated after this time.
const SUPERSEDED_LIMIT_MS = 700;

// Compiles the module embedded in the page: gzip in base64.
async function compileModule({ module }) {
  const bytes = Uint8Array.from(atob(module), (char) => char.charCodeAt(0));
  const decompressed = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  // Compilation overlaps with decompression.
  return WebAssembly.compileStreaming(new Response(decompressed, { headers: { "content-type": "application/wasm" } }));
}

// A worker and its queue. A new request replaces a pending one of its kind, which resolves to `null`.
class WorkerQueue {
  constructor(module) {
    this.module = module;
    this.workerUrl = URL.createObjectURL(new Blob([`(${workerBody})();`], { type: "text/javascript" }));
    this.pending = [];
    this.current = null;
    this.nextId = 0;
    this.start();
  }

  async start() {
    const worker = new Worker(this.workerUrl);
    this.worker = worker;
    worker.onmessage = ({ data }) => this.onReply(data);
    worker.onerror = (event) => this.onReply({ id: this.current?.id, response: { failed: event.message || "the worker has failed" }, data: new ArrayBuffer(0), ms: 0 });
    worker.postMessage({ module: await this.module });
    if (worker !== this.worker) return;
    this.ready = true;
    this.startNext();
  }

  // Resolves to `{ response, data, ms }`, or to `null` if superseded. Requests with the lowest `priority` number run
  // first.
  request(kind, request, priority = 0) {
    return new Promise((resolve) => {
      const supersededIndex = this.pending.findIndex((entry) => entry.kind === kind);
      if (supersededIndex >= 0) this.pending.splice(supersededIndex, 1)[0].resolve(null);
      this.pending.push({ id: this.nextId++, kind, request, priority, resolve });
      this.pending.sort((a, b) => a.priority - b.priority || a.id - b.id);
      if (this.current?.kind === kind) this.terminateIfSlow();
      this.startNext();
    });
  }

  // Cancels the pending requests of a kind, and the current one if it takes too long.
  cancel(kind) {
    for (const entry of this.pending.filter((entry) => entry.kind === kind)) entry.resolve(null);
    this.pending = this.pending.filter((entry) => entry.kind !== kind);
    if (this.current?.kind === kind) this.terminateIfSlow();
  }

  // The current request is superseded: restarts the worker unless it finishes within the limit.
  terminateIfSlow() {
    const { current } = this;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (this.current !== current) return;
      this.worker.terminate();
      this.current = null;
      this.ready = false;
      current.resolve(null);
      this.start();
    }, Math.max(0, current.startedAt + SUPERSEDED_LIMIT_MS - performance.now()));
  }

  startNext() {
    if (!this.ready || this.current || this.pending.length === 0) return;
    this.current = this.pending.shift();
    this.current.startedAt = performance.now();
    const { id, request } = this.current;
    this.worker.postMessage({ id, request });
  }

  onReply({ id, response, data, ms }) {
    const { current } = this;
    if (!current || current.id !== id) return;
    this.current = null;
    clearTimeout(this.timer);
    current.resolve({ response, data: new Float64Array(data), ms });
    this.startNext();
  }
}
