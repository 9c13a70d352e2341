// The playback viewer: clock, animation, plots, events and controls, redrawn on changes.

// `connectKeys` connects the keyboard.
function createViewer(playback, connectKeys) {
  const app = { playback, dirty: true };
  let span = [playback.start, playback.end];

  app.range = () => span;
  app.requestRedraw = () => { app.dirty = true; };
  app.clock = new Clock(playback, () => {
    keepInWindow();
    app.requestRedraw();
  });
  app.stage = new Stage(playback, byId("stage"));

  // Moves the window of the time axis with the cursor.
  function keepInWindow() {
    const [from, to] = span;
    const { time } = app.clock;
    if (time >= from && time <= to) return;
    const width = to - from;
    app.setWindow(time < from ? time - 0.1 * width : time - 0.9 * width, time < from ? time + 0.9 * width : time + 0.1 * width);
  }

  app.setWindow = (from, to) => {
    const minWidth = 1e-7 * (playback.end - playback.start);
    const width = Math.min(Math.max(to - from, minWidth), playback.end - playback.start);
    const start = Math.min(Math.max(from, playback.start), playback.end - width);
    span = [start, start + width];
    app.requestRedraw();
  };
  app.zoomTime = (factor, centre = app.clock.time) => {
    const [from, to] = span;
    const anchor = Math.min(Math.max(centre, from), to);
    app.setWindow(anchor - (anchor - from) * factor, anchor + (to - anchor) * factor);
  };
  app.moveTime = (fraction) => {
    const [from, to] = span;
    const shift = fraction * (to - from);
    app.setWindow(from + shift, to + shift);
  };
  // Replaces the playback; retains the view, the window of the time axis and the elapsed fraction of the run.
  app.replacePlayback = (next) => {
    const showsAll = span[0] <= playback.start && span[1] >= playback.end;
    Object.assign(playback, next);
    for (const component of [app.clock, app.stage, app.plots]) component.reload();
    if (showsAll) app.setWindow(playback.start, playback.end);
    else app.setWindow(...span);
    updateChoices(app);
    showStates(playback);
  };
  app.showNearestImpact = () => {
    const moment = app.clock.nearest(app.events.nearest(app.clock.time));
    if (!moment) return;
    const { time, duration } = moment;
    app.setWindow(time - 0.6 * duration, time + 2.4 * duration);
    app.seek(time);
  };

  app.seek = (time) => app.clock.seek(time);
  app.pause = () => app.clock.pause();
  app.toggle = () => (app.clock.playing ? app.clock.pause() : app.clock.play());
  app.step = (direction) => {
    app.pause();
    app.seek(nextSampleTime(playback.runs, app.clock.time, direction));
  };
  app.jump = (direction) => {
    const event = app.events.next(app.clock.time, direction);
    app.pause();
    app.seek(event ? event.time_s : direction > 0 ? playback.end : playback.start);
  };
  app.setNotch = (notch) => {
    app.clock.notch = Math.min(Math.max(Math.round(notch), 0), NOTCH_COUNT - 1);
    app.clock.auto = false;
    app.requestRedraw();
  };
  app.changeSpeed = (by) => app.setNotch((app.clock.auto ? Math.round(3 * Math.log10(app.clock.speed / MIN_SPEED)) : app.clock.notch) + by);
  app.setAuto = (auto) => {
    app.clock.auto = auto;
    app.requestRedraw();
  };
  app.show = (index, visible) => {
    playback.runs[index].visible = visible;
    app.requestRedraw();
  };
  app.follow = (name) => {
    app.stage.camera.followContact(name);
    app.requestRedraw();
  };
  app.nextView = () => {
    const views = [null, ...app.stage.camera.maxPenetrations.keys()];
    app.follow(views[(views.indexOf(app.stage.camera.follow) + 1) % views.length]);
  };
  app.zoom = (factor) => {
    app.stage.camera.zoomBy(factor);
    app.requestRedraw();
  };
  app.fit = () => {
    app.stage.camera.fit();
    app.requestRedraw();
  };
  app.turn = () => {
    app.stage.camera.turned = !app.stage.camera.turned;
    app.requestRedraw();
  };
  app.toggleSymbols = () => {
    app.stage.showsSymbols = !app.stage.showsSymbols;
    app.requestRedraw();
  };
  app.setArrows = (kind) => {
    app.stage.arrowsToScale = kind === "linear";
    app.requestRedraw();
  };

  app.setTheme = (name) => {
    document.documentElement.dataset.theme = name;
    byId("theme").setAttribute("aria-pressed", name === "dark");
    clearColourCache();
    app.requestRedraw();
  };
  app.toggleTheme = () => app.setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  app.setTheme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => app.setTheme(dark.matches ? "dark" : "light"));

  app.plots = new Plots(playback, byId("plots"), app);
  app.plots.zoomTime = app.zoomTime;
  app.plots.moveTime = app.moveTime;
  app.events = new EventList(playback, byId("events"), app.seek);
  const refreshControls = connectControls(app);
  connectKeys(app);
  showStates(playback);
  // Callbacks after each drawing.
  app.afterRender = [];

  app.render = () => {
    if (!app.dirty) return;
    app.dirty = false;
    const { time } = app.clock;
    app.stage.draw(time);
    app.plots.draw(time);
    app.readings = app.plots.updateReadings(time);
    app.events.show(time);
    refreshControls();
    app.afterRender.forEach((callback) => callback(app));
  };
  new ResizeObserver(app.requestRedraw).observe(document.body);
  new ResizeObserver(app.requestRedraw).observe(app.stage.canvas);
  // On a phone, the controls cover other content; they are hidden when the animation is out of view.
  const onStageVisibility = ([entry]) => document.body.classList.toggle("past", !entry.isIntersecting);
  new IntersectionObserver(onStageVisibility, { rootMargin: "0px 0px -60% 0px" }).observe(byId("playback"));
  let previousFrame = null;
  const frame = (now) => {
    // The limit avoids a jump after the tab was in the background.
    if (previousFrame !== null) app.clock.advance(Math.min((now - previousFrame) / 1000, 0.1));
    previousFrame = now;
    app.render();
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  return app;
}
