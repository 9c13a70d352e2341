// Exports the animation as a GIF: the window of the time axis at the speed of the playback.

// Duration of a frame and of the last frame, s.
const FRAME_S = 0.04;
const LAST_FRAME_S = 1.5;
// A longer animation is accelerated.
const MAX_FRAMES = 500;
const MAX_WIDTH = 720;
// Number of frames from which the palette is chosen.
const PALETTE_FRAMES = 40;
const CAPTION_HEIGHT = 28;

// Selects `count` evenly spaced items of a list, including both ends.
const subsample = (list, count) => (list.length <= count ? list : Array.from({ length: count }, (_, k) => list[Math.round(k * (list.length - 1) / (count - 1))]));

// The times of the frames.
function frameTimes({ clock, range }) {
  const [from, to] = range();
  if (!clock.auto) {
    const count = Math.min(MAX_FRAMES, Math.max(2, Math.ceil((to - from) / (clock.speed * FRAME_S)) + 1));
    return Array.from({ length: count }, (_, k) => from + k * (to - from) / (count - 1));
  }
  const times = [from];
  while (times.at(-1) < to) times.push(Math.min(clock.timeAfter(times.at(-1), FRAME_S), to));
  return subsample(times, MAX_FRAMES);
}

// Yields to the browser; unlike timers, a message is not throttled in a background tab.
const yieldToBrowser = () => new Promise((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => {
    port1.close();
    resolve();
  };
  port2.postMessage(null);
});

// Draws the animation at a time with a caption; returns the pixels.
function drawFrame(app, ctx, time) {
  const { stage, playback } = app;
  const { width, height } = ctx.canvas;
  stage.draw(time);
  ctx.fillStyle = colour("panel");
  ctx.fillRect(0, 0, width, height);
  ctx.drawImage(stage.canvas, 0, CAPTION_HEIGHT, width, height - CAPTION_HEIGHT);
  const shown = playback.runs.filter((run) => run.visible);
  const runs = shown.length > 1 ? `${shown[0].label}, ${shown[1].label} dashed` : shown.map((run) => run.label).join("");
  ctx.textBaseline = "middle";
  ctx.fillStyle = colour("ink");
  ctx.font = FONT.replace("12px", "600 14px");
  ctx.textAlign = "right";
  ctx.fillText(formatTime(time, playback.timeFormat), width - 10, CAPTION_HEIGHT / 2);
  ctx.font = FONT.replace("12px", "14px");
  ctx.textAlign = "left";
  ctx.fillText(`${document.title}: ${runs}`, 10, CAPTION_HEIGHT / 2, width - 130);
  return ctx.getImageData(0, 0, width, height);
}

// Renders the GIF; `onProgress` receives the completed fraction.
async function renderGif(app, onProgress) {
  app.pause();
  const { clientWidth, clientHeight } = app.stage.canvas;
  const scale = Math.min(1, MAX_WIDTH / clientWidth);
  const size = { width: Math.round(scale * clientWidth), height: Math.round(scale * clientHeight) + CAPTION_HEIGHT };
  const ctx = Object.assign(document.createElement("canvas"), size).getContext("2d", { willReadFrequently: true });
  const times = frameTimes(app);
  const palette = new Palette();
  try {
    for (const time of subsample(times, PALETTE_FRAMES)) {
      palette.addPicture(drawFrame(app, ctx, time));
      await yieldToBrowser();
    }
    palette.build();
    const gif = new Gif(size.width, size.height, palette);
    for (const [index, time] of times.entries()) {
      onProgress(index / times.length);
      gif.add(drawFrame(app, ctx, time), Math.round(100 * (index < times.length - 1 ? FRAME_S : LAST_FRAME_S)));
      await yieldToBrowser();
    }
    return gif.blob();
  } finally {
    app.requestRedraw();
  }
}
