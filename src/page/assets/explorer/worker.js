// Code of the worker, which passes requests to the module and returns the responses. The function is sent as source
// text.

function workerBody() {
  const encoder = new TextEncoder();
  const decoder = new TextDecoder();
  let module = null;
  let exports = null;

  // Copies the text and numbers of a response, because the next call may move the memory of the module.
  function readOutput(pointer) {
    const { buffer } = exports.memory;
    const [text, textLength, data, numberCount] = new Uint32Array(buffer, pointer >>> 0, 4);
    const json = decoder.decode(new Uint8Array(buffer, text, textLength));
    return { text: json, data: buffer.slice(data, data + 8 * numberCount) };
  }

  function handleRequest(request) {
    const bytes = encoder.encode(JSON.stringify(request));
    const start = performance.now();
    const requestPointer = exports.alloc(bytes.length) >>> 0;
    new Uint8Array(exports.memory.buffer, requestPointer, bytes.length).set(bytes);
    const pointer = exports.response(bytes.length);
    const ms = performance.now() - start;
    const { text, data } = readOutput(pointer);
    return { response: JSON.parse(text), data, ms };
  }

  // The panic message of the module, if it can be read.
  function failureMessage(error) {
    try {
      return readOutput(exports.error()).text || String(error);
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
      const { response, data, ms } = handleRequest(request);
      postMessage({ id, response, data, ms }, [data]);
    } catch (error) {
      postMessage({ id, response: { failed: failureMessage(error) }, data: new ArrayBuffer(0), ms: 0 });
      exports = null;
    }
  };
}
