// What a worker does: hands requests to the module and its answers back. Its text alone is sent to the worker.

function workerBody() {
  const encoder = new TextEncoder();
  const decoder = new TextDecoder();
  let module = null;
  let exports = null;

  // The text and the numbers an answer points to, copied out: the module's memory may move with the next call.
  function read(pointer) {
    const { buffer } = exports.memory;
    const [text, bytes, data, numbers] = new Uint32Array(buffer, pointer >>> 0, 4);
    const json = decoder.decode(new Uint8Array(buffer, text, bytes));
    return { text: json, data: buffer.slice(data, data + 8 * numbers) };
  }

  function answered(request) {
    const bytes = encoder.encode(JSON.stringify(request));
    const start = performance.now();
    const room = exports.room(bytes.length) >>> 0;
    new Uint8Array(exports.memory.buffer, room, bytes.length).set(bytes);
    const pointer = exports.answer(bytes.length);
    const ms = performance.now() - start;
    const { text, data } = read(pointer);
    return { answer: JSON.parse(text), data, ms };
  }

  // What the module says of a failure; its memory is as the failure left it.
  function trouble(error) {
    try {
      return read(exports.trouble()).text || String(error);
    } catch {
      return String(error);
    }
  }

  onmessage = ({ data: message }) => {
    if (message.module) {
      module = message.module;
      return;
    }
    const { id, request } = message;
    try {
      exports ??= new WebAssembly.Instance(module, {}).exports;
      const { answer, data, ms } = answered(request);
      postMessage({ id, answer, data, ms }, [data]);
    } catch (error) {
      postMessage({ id, answer: { failed: trouble(error) }, data: new ArrayBuffer(0), ms: 0 });
      exports = null;
    }
  };
}
