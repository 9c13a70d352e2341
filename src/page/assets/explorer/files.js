// Exporters: scene and samples from the module, animation as a video recorded by the browser.

const VIDEO_TYPES = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];
const BITS_PER_SECOND = 6e6;

const videoType = () => (typeof MediaRecorder === "undefined" || !HTMLCanvasElement.prototype.captureStream ? null : VIDEO_TYPES.find((type) => MediaRecorder.isTypeSupported(type)) ?? null);
const sleep = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

// Records the frames of the animation as a video in real time.
async function recordVideo(app, type, onProgress) {
  app.pause();
  const { clientWidth, clientHeight } = app.stage.canvas;
  const scale = Math.min(1, MAX_WIDTH / clientWidth);
  // Some codecs subsample the colours by two, so sizes are even.
  const even = (length) => 2 * Math.round(length / 2);
  const size = { width: even(scale * clientWidth), height: even(scale * clientHeight) + CAPTION_HEIGHT };
  const canvas = Object.assign(document.createElement("canvas"), size);
  const ctx = canvas.getContext("2d", { willReadFrequently: true });
  const times = frameTimes(app);
  drawFrame(app, ctx, times[0]);
  const recorder = new MediaRecorder(canvas.captureStream(1 / FRAME_S), { mimeType: type, videoBitsPerSecond: BITS_PER_SECOND });
  const chunks = [];
  const stopped = new Promise((resolve) => { recorder.onstop = resolve; });
  recorder.ondataavailable = ({ data }) => chunks.push(data);
  recorder.start();
  try {
    for (const [index, time] of times.entries()) {
      onProgress(index / times.length);
      drawFrame(app, ctx, time);
      await sleep(index < times.length - 1 ? FRAME_S : LAST_FRAME_S);
    }
  } finally {
    recorder.stop();
    app.requestRedraw();
  }
  await stopped;
  return new Blob(chunks, { type: "video/webm" });
}

// Additional exporters of the explorer, by file extension.
function createExporters(app, requestFile) {
  const exportText = (kind, type) => async () => {
    const reply = await requestFile(kind);
    if (reply?.response.text) return new Blob([reply.response.text], { type });
    showWarning(reply?.response.problems ?? [{ message: reply?.response.failed ?? "The simulator has not responded." }]);
    return null;
  };
  const exporters = { toml: exportText("toml", "application/toml"), csv: exportText("csv", "text/csv") };
  const video = videoType();
  if (video) exporters.webm = (onProgress) => recordVideo(app, video, onProgress);
  return exporters;
}
