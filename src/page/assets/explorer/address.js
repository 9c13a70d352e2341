// Encodes the state of the page in its address, and decodes it.

// Encodes bytes as base64url.
function encodeBase64Url(bytes) {
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

const decodeBase64Url = (text) => Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (char) => char.charCodeAt(0));

const pipeThroughStream = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
const compressText = async (text) => encodeBase64Url(await pipeThroughStream(new TextEncoder().encode(text), new CompressionStream("deflate-raw")));

// Input is decompressed in small slices with a limit on the output, because a kilobyte can expand to a megabyte.
const SLICE_BYTES = 1024;
const tooLongMessage = (name, { largest_scene_bytes: maxBytes }) => `The scene in ${name} is longer than the limit of ${maxBytes / 1024} KiB and was not opened.`;

async function decompressText(text, page) {
  const bytes = decodeBase64Url(text);
  let offset = 0;
  const slices = new ReadableStream({
    pull(stream) {
      if (offset >= bytes.length) stream.close();
      else stream.enqueue(bytes.subarray(offset, offset += SLICE_BYTES));
    },
  });
  const decoder = new TextDecoder();
  let [result, length] = ["", 0];
  for (const reader = slices.pipeThrough(new DecompressionStream("deflate-raw")).getReader(); ;) {
    const { done, value } = await reader.read();
    if (done) return result + decoder.decode();
    length += value.length;
    if (length > page.largest_scene_bytes) {
      reader.cancel();
      throw new Error(tooLongMessage("this address", page));
    }
    result += decoder.decode(value, { stream: true });
  }
}

// Writes a scene to a query: the name of a preset, otherwise also its full text.
async function writeScene(query, prefix, { file, text, set }, presets) {
  const preset = presets.find((candidate) => candidate.text === text);
  query.set(`${prefix}scene`, preset?.file ?? file);
  if (!preset) query.set(`${prefix}text`, await compressText(text));
  for (const [path, value] of set) query.append(`${prefix}set`, `${path}=${value}`);
}

async function readScene(query, prefix, page) {
  const file = query.get(`${prefix}scene`);
  if (file === null) return null;
  const compressed = query.get(`${prefix}text`);
  const text = compressed !== null ? await decompressText(compressed, page) : page.presets.find((candidate) => candidate.file === file)?.text;
  if (text === undefined) return null;
  const set = query.getAll(`${prefix}set`).map((pair) => [pair.slice(0, pair.indexOf("=")), pair.slice(pair.indexOf("=") + 1)]);
  return { file, text, set };
}

/** Encodes the fragment: scene, fields, reference run A, time, and axes of the map. */
async function encodeFragment({ scene, reference, time_s, map }, presets) {
  const query = new URLSearchParams();
  await writeScene(query, "", scene, presets);
  if (reference) await writeScene(query, "a.", reference, presets);
  if (Number.isFinite(time_s)) query.set("t", String(time_s));
  if (map) query.set("map", map.join(","));
  return `#${query}`;
}

/** Decodes a fragment; missing parts are `null`. `error` is set if the fragment is invalid. */
async function decodeFragment(fragment, page) {
  try {
    const query = new URLSearchParams(fragment.replace(/^#/, ""));
    const time = query.get("t");
    return {
      scene: await readScene(query, "", page),
      reference: await readScene(query, "a.", page),
      time_s: time === null || !Number.isFinite(Number(time)) ? null : Number(time),
      map: query.get("map")?.split(",") ?? null,
    };
  } catch (error) {
    // An invalid fragment is ignored. Errors of the decoder are replaced by one message.
    const message = error instanceof TypeError || error instanceof DOMException ? "The scene in this address cannot be read. The address may be truncated." : error.message;
    return { scene: null, reference: null, time_s: null, map: null, error: message };
  }
}
