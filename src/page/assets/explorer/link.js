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
const unpacked = async (text) => new TextDecoder().decode(await through(unaddressed(text), new DecompressionStream("deflate-raw")));

// A scene within an address: the name of one of the page's own, else its whole text.
async function sceneInto(query, prefix, { file, text, set }, presets) {
  const own = presets.find((each) => each.text === text);
  query.set(`${prefix}scene`, own?.file ?? file);
  if (!own) query.set(`${prefix}text`, await packed(text));
  for (const [path, value] of set) query.append(`${prefix}set`, `${path}=${value}`);
}

async function sceneOutOf(query, prefix, presets) {
  const file = query.get(`${prefix}scene`);
  if (file === null) return null;
  const whole = query.get(`${prefix}text`);
  const text = whole !== null ? await unpacked(whole) : presets.find((each) => each.file === file)?.text;
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

/** What a fragment says; `null` of what is not in it, or cannot be read. */
async function stateOf(fragment, presets) {
  try {
    const query = new URLSearchParams(fragment.replace(/^#/, ""));
    const time = query.get("t");
    return {
      scene: await sceneOutOf(query, "", presets),
      kept: await sceneOutOf(query, "a.", presets),
      time_s: time === null || !Number.isFinite(Number(time)) ? null : Number(time),
      map: query.get("map")?.split(",") ?? null,
    };
  } catch {
    // Cut short on its way here: the page opens as it would without.
    return { scene: null, kept: null, time_s: null, map: null };
  }
}
