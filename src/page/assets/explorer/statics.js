// The statics report of the program: texts and pictures.

class Statics {
  constructor(queue, container, { settings, isVisible }) {
    Object.assign(this, { queue, container, settings, isVisible });
    this.key = null;
  }

  // Requests the report if it is visible and the settings have changed.
  async reload() {
    if (!this.isVisible()) return;
    const settings = this.settings();
    const key = JSON.stringify(settings.copy());
    if (key === this.key) return;
    this.key = key;
    this.container.classList.add("stale");
    const reply = await this.queue.request("statics", settings.request("statics"), 1);
    if (key !== this.key) return;
    if (!reply) {
      this.key = null;
      return;
    }
    this.container.classList.remove("stale");
    const { response } = reply;
    const problemText = response.problems?.map(({ message, help }) => [message, help].filter(Boolean).join(": ")).join(" ") ?? response.failed;
    if (problemText) {
      this.container.replaceChildren(element("p", { class: "soft" }, problemText));
      return;
    }
    // The module has escaped all input.
    const sections = (response.sections ?? []).map(({ title, html }) => {
      const section = element("section", { class: "text" }, element("h2", {}, title));
      section.insertAdjacentHTML("beforeend", html);
      return section;
    });
    const pictures = (response.pictures ?? []).map(({ title, svg }) => {
      const sheet = element("div", { class: "sheet", tabindex: "0", role: "img", "aria-label": title });
      sheet.innerHTML = svg;
      return element("section", { class: "picture" }, element("h2", {}, title), sheet);
    });
    this.container.replaceChildren(...pictures, ...sections);
  }
}
