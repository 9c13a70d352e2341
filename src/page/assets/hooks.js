// Interface for tests: the state of the page, and the controls as functions.
function createTestHooks(app) {
  const { clock, stage, playback } = app;
  const state = () => {
    app.render();
    const [from, to] = app.range();
    return {
      time_s: clock.time,
      playing: clock.playing,
      auto: clock.auto,
      speed: clock.speed,
      window_s: [from, to],
      symbols: stage.symbols,
      labels: stage.labels,
      view: { centre_m: [...stage.camera.centre], px_per_m: stage.camera.scale, follow: stage.camera.follow, turned: stage.camera.turned },
      runs: stage.drawnRuns.map(({ run, position, bodies, contacts, arrows }) => ({
        label: run.label,
        sample: position.i,
        bodies,
        contacts,
        arrows,
        readings: app.readings[run.index],
      })),
    };
  };
  return Object.freeze({
    state,
    span_s: Object.freeze([playback.start, playback.end]),
    play: () => clock.play(),
    pause: app.pause,
    seek: app.seek,
    step: app.step,
    jump: app.jump,
    setSpeed: (speed) => app.setNotch(Math.round(3 * Math.log10(speed / MIN_SPEED))),
    setAuto: app.setAuto,
    setArrows: app.setArrows,
    toggleSymbols: app.toggleSymbols,
    show: app.show,
    follow: app.follow,
    zoom: app.zoom,
    fit: app.fit,
    setWindow: app.setWindow,
    setTheme: app.setTheme,
  });
}
