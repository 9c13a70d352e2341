// Colours of results: of numbers along a scale, of words one each.

// Viridis, whose brightness grows evenly: it is read without telling colours apart, and in print.
const SCALE = ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
// Words that are results, from good to bad, with the colour that each always has; the page has them from the program.
const inks = new Map();
const inkOf = (word) => inks.get(word) ?? "s5";

const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// The colour of a place from 0 to 1.
function scaleColour(part) {
  const at = Math.min(Math.max(part, 0), 1) * (SCALE.length - 1);
  const k = Math.min(Math.floor(at), SCALE.length - 2);
  const [from, to] = [channels(SCALE[k]), channels(SCALE[k + 1])];
  return `rgb(${from.map((each, i) => Math.round(each + (at - k) * (to[i] - each))).join(" ")})`;
}
