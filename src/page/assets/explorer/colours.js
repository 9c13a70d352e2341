// Colours of results: a scale for numbers, one colour per class.

// Viridis: its luminance increases monotonically, so it is readable with colour blindness and in greyscale.
const COLOUR_SCALE = ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"];
// Names of results, from good to bad, with their colours; defined by the program.
const resultColours = new Map();
const resultColour = (name) => resultColours.get(name) ?? "s5";

const parseHex = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// The colour at a position from 0 to 1.
function colourAt(fraction) {
  const position = Math.min(Math.max(fraction, 0), 1) * (COLOUR_SCALE.length - 1);
  const k = Math.min(Math.floor(position), COLOUR_SCALE.length - 2);
  const [from, to] = [parseHex(COLOUR_SCALE[k]), parseHex(COLOUR_SCALE[k + 1])];
  return `rgb(${from.map((channel, i) => Math.round(channel + (position - k) * (to[i] - channel))).join(" ")})`;
}
