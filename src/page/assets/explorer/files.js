// Files of what is explored: the scene and its samples from the module, the animation as a film of the browser's own.

const VIDEO = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];
const BITS_PER_SECOND = 6e6;

const videoType = () => (typeof MediaRecorder === "undefined" || !HTMLCanvasElement.prototype.captureStream ? null : VIDEO.find((type) => MediaRecorder.isTypeSupported(type)) ?? null);
const slept = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

// The frames of the moving picture as they go by, recorded as a video.
async function videoOf(app, type, tell) {
  app.pause();
  const { clientWidth, clientHeight } = app.stage.canvas;
  const scale = Math.min(1, WIDEST / clientWidth);
  // Even sizes: some codecs halve the colours.
  const even = (length) => 2 * Math.round(length / 2);
  const size = { width: even(scale * clientWidth), height: even(scale * clientHeight) + CAPTION };
  const canvas = Object.assign(document.createElement("canvas"), size);
  const ctx = canvas.getContext("2d", { willReadFrequently: true });
  const times = instantsOf(app);
  frameOf(app, ctx, times[0]);
  const recorder = new MediaRecorder(canvas.captureStream(1 / FRAME_S), { mimeType: type, videoBitsPerSecond: BITS_PER_SECOND });
  const parts = [];
  const ended = new Promise((resolve) => { recorder.onstop = resolve; });
  recorder.ondataavailable = ({ data }) => parts.push(data);
  recorder.start();
  try {
    for (const [index, time] of times.entries()) {
      tell(index / times.length);
      frameOf(app, ctx, time);
      await slept(index < times.length - 1 ? FRAME_S : LAST_S);
    }
  } finally {
    recorder.stop();
    app.changed();
  }
  await ended;
  return new Blob(parts, { type: "video/webm" });
}

// The files a page like this one has beside those of any page: by their endings.
function filesOf(app, ask) {
  const textOf = (kind, type) => async () => {
    const heard = await ask(kind);
    if (heard?.answer.text) return new Blob([heard.answer.text], { type });
    warn(heard?.answer.problems ?? [{ message: heard?.answer.failed ?? "There is no answer." }]);
    return null;
  };
  const files = { toml: textOf("toml", "application/toml"), csv: textOf("csv", "text/csv") };
  const video = videoType();
  if (video) files.webm = (tell) => videoOf(app, video, tell);
  return files;
}
