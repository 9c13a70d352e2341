// The list of events.

class EventList {
  constructor(playback, container, seek) {
    Object.assign(this, { playback, container, seek });
    this.reload();
  }

  // Lists the events of the present playback.
  reload() {
    const { playback, container, seek } = this;
    container.replaceChildren();
    this.rows = playback.events.map((event) => {
      const valueText = event.figure === null ? "" : formatQuantity(event.figure, event.unit, 4);
      const row = element(
        "button",
        { type: "button", class: "event" },
        strokeSample(event.run),
        element("span", {}, formatTime(event.time_s, playback.timeFormat)),
        element("span", { class: "event-name" }, `${event.place}: ${event.kind}`),
        element("span", { class: "figure soft" }, valueText),
      );
      row.title = [...(playback.runs.length > 1 ? [event.run.label] : []), ...(event.point ? [event.point] : [])].join(": ");
      row.setAttribute("aria-label", `${event.run.label}, ${formatTime(event.time_s, playback.timeFormat)}, ${event.place}: ${event.kind} ${valueText}`);
      row.addEventListener("click", () => seek(event.time_s));
      container.append(row);
      return row;
    });
    if (playback.events.length === 0) container.append(element("p", { class: "none soft" }, "There is no contact in this run."));
    this.current = -1;
  }

  // The next event of a visible run, forward (1) or backward (−1), or `null`.
  next(time, direction) {
    const visibleEvents = this.playback.events.filter((event) => event.run.visible);
    const found = direction > 0 ? visibleEvents.find((event) => event.time_s > time) : visibleEvents.findLast((event) => event.time_s < time);
    return found ?? null;
  }

  nearest(time) {
    let nearest = null;
    for (const event of this.playback.events) {
      if (event.run.visible && (nearest === null || Math.abs(event.time_s - time) < Math.abs(nearest.time_s - time))) nearest = event;
    }
    return nearest;
  }

  // Marks the last event up to the given time and scrolls the list to it.
  show(time) {
    const events = this.playback.events;
    let current = -1;
    while (current + 1 < events.length && events[current + 1].time_s <= time) current++;
    if (current === this.current) return;
    this.rows[this.current]?.removeAttribute("aria-current");
    this.current = current;
    const row = this.rows[current];
    if (!row) return;
    row.setAttribute("aria-current", "true");
    const [top, bottom] = [row.offsetTop, row.offsetTop + row.offsetHeight];
    const list = this.container;
    if (top < list.scrollTop) list.scrollTop = top;
    else if (bottom > list.scrollTop + list.clientHeight) list.scrollTop = bottom - list.clientHeight;
  }
}
