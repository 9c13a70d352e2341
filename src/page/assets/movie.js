// The animation as a moving picture: the window of the time axis, as slow at impacts as it plays here.

// Seconds of the reader's between two frames, and the last one's.
const FRAME_S = 0.04;
const LAST_S = 1.5;
// What would be more is sped up.
const MOST_FRAMES = 500;
const WIDEST = 720;
// Frames that the palette is chosen by.
const SEEN = 40;
const CAPTION = 28;

// So many of a list, evenly, with its ends.
const evenly = (list, count) => (list.length <= count ? list : Array.from({ length: count }, (_, k) => list[Math.round(k * (list.length - 1) / (count - 1))]));

// The instants of the frames.
function instantsOf({ clock, range }) {
  const [from, to] = range();
  if (!clock.auto) {
    const count = Math.min(MOST_FRAMES, Math.max(2, Math.ceil((to - from) / (clock.speed * FRAME_S)) + 1));
    return Array.from({ length: count }, (_, k) => from + k * (to - from) / (count - 1));
  }
  const times = [from];
  while (times.at(-1) < to) times.push(Math.min(clock.after(times.at(-1), FRAME_S), to));
  return evenly(times, MOST_FRAMES);
}

// Lets the browser do what else there is to do, in the background too, where timers sleep.
const breath = () => new Promise((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => {
    port1.close();
    resolve();
  };
  port2.postMessage(null);
});

// Draws the animation at an instant, with a line that says which; returns its pixels.
function frameOf(app, ctx, time) {
  const { stage, film } = app;
  const { width, height } = ctx.canvas;
  stage.draw(time);
  ctx.fillStyle = colour("panel");
  ctx.fillRect(0, 0, width, height);
  ctx.drawImage(stage.canvas, 0, CAPTION, width, height - CAPTION);
  const shown = film.runs.filter((run) => run.visible);
  const runs = shown.length > 1 ? `${shown[0].label}, ${shown[1].label} dashed` : shown.map((run) => run.label).join("");
  ctx.textBaseline = "middle";
  ctx.fillStyle = colour("ink");
  ctx.font = FONT.replace("12px", "600 14px");
  ctx.textAlign = "right";
  ctx.fillText(timeText(time, film.unit), width - 10, CAPTION / 2);
  ctx.font = FONT.replace("12px", "14px");
  ctx.textAlign = "left";
  ctx.fillText(`${document.title}: ${runs}`, 10, CAPTION / 2, width - 130);
  return ctx.getImageData(0, 0, width, height);
}

// The moving picture; `tell` hears how much of it is done.
async function movieOf(app, tell) {
  app.pause();
  const { clientWidth, clientHeight } = app.stage.canvas;
  const scale = Math.min(1, WIDEST / clientWidth);
  const size = { width: Math.round(scale * clientWidth), height: Math.round(scale * clientHeight) + CAPTION };
  const ctx = Object.assign(document.createElement("canvas"), size).getContext("2d", { willReadFrequently: true });
  const times = instantsOf(app);
  const palette = new Palette();
  try {
    for (const time of evenly(times, SEEN)) {
      palette.see(frameOf(app, ctx, time));
      await breath();
    }
    palette.choose();
    const gif = new Gif(size.width, size.height, palette);
    for (const [index, time] of times.entries()) {
      tell(index / times.length);
      gif.add(frameOf(app, ctx, time), Math.round(100 * (index < times.length - 1 ? FRAME_S : LAST_S)));
      await breath();
    }
    return gif.blob();
  } finally {
    app.changed();
  }
}
