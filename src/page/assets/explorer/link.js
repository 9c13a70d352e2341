// The state of the page in its address, and back.

// Bytes as text that an address takes as it is.
function addressed(bytes) {
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

const unaddressed = (text) => Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (char) => char.charCodeAt(0));

const through = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
const packed = async (text) => addressed(await through(new TextEncoder().encode(text), new CompressionStream("deflate-raw")));

// Texts are no longer than a scene file may be. Little is unpacked at a time, for a kilobyte may stand for a megabyte.
const SLICE = 1024;
const tooLong = (name, { largest_scene_bytes: most }) => `The scene in ${name} is longer than the ${most / 1024} KiB that a scene may have; this page does not open it.`;

async function unpacked(text, page) {
  const bytes = unaddressed(text);
  let at = 0;
  const slices = new ReadableStream({
    pull(stream) {
      if (at >= bytes.length) stream.close();
      else stream.enqueue(bytes.subarray(at, at += SLICE));
    },
  });
  const decoder = new TextDecoder();
  let [whole, length] = ["", 0];
  for (const reader = slices.pipeThrough(new DecompressionStream("deflate-raw")).getReader(); ;) {
    const { done, value } = await reader.read();
    if (done) return whole + decoder.decode();
    length += value.length;
    if (length > page.largest_scene_bytes) {
      reader.cancel();
      throw new Error(tooLong("this address", page));
    }
    whole += decoder.decode(value, { stream: true });
  }
}

// A scene within an address: the name of one of the page's own, else its whole text.
async function sceneInto(query, prefix, { file, text, set }, presets) {
  const own = presets.find((each) => each.text === text);
  query.set(`${prefix}scene`, own?.file ?? file);
  if (!own) query.set(`${prefix}text`, await packed(text));
  for (const [path, value] of set) query.append(`${prefix}set`, `${path}=${value}`);
}

async function sceneOutOf(query, prefix, page) {
  const file = query.get(`${prefix}scene`);
  if (file === null) return null;
  const whole = query.get(`${prefix}text`);
  const text = whole !== null ? await unpacked(whole, page) : page.presets.find((each) => each.file === file)?.text;
  if (text === undefined) return null;
  const set = query.getAll(`${prefix}set`).map((pair) => [pair.slice(0, pair.indexOf("=")), pair.slice(pair.indexOf("=") + 1)]);
  return { file, text, set };
}

/** The fragment that says all: scene, fields, what is kept as A, the instant, and the axes of the map. */
async function fragmentOf({ scene, kept, time_s, map }, presets) {
  const query = new URLSearchParams();
  await sceneInto(query, "", scene, presets);
  if (kept) await sceneInto(query, "a.", kept, presets);
  if (Number.isFinite(time_s)) query.set("t", String(time_s));
  if (map) query.set("map", map.join(","));
  return `#${query}`;
}

/** What a fragment says, `null` of what is not in it; of one that cannot be read, why. */
async function stateOf(fragment, page) {
  try {
    const query = new URLSearchParams(fragment.replace(/^#/, ""));
    const time = query.get("t");
    return {
      scene: await sceneOutOf(query, "", page),
      kept: await sceneOutOf(query, "a.", page),
      time_s: time === null || !Number.isFinite(Number(time)) ? null : Number(time),
      map: query.get("map")?.split(",") ?? null,
    };
  } catch (error) {
    // The page stays as it would be without; one cut short on its way here has no message of its own.
    const refused = error instanceof TypeError || error instanceof DOMException ? "The scene in this address cannot be read: it may have been cut short." : error.message;
    return { scene: null, kept: null, time_s: null, map: null, refused };
  }
}
