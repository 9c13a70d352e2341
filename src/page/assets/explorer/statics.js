// What a grasp can do at rest, as the program says it: texts and pictures.

class Statics {
  constructor(line, holder, { setting, wanted }) {
    Object.assign(this, { line, holder, setting, wanted });
    this.key = null;
  }

  // Asks anew if it is to be seen and the setting is another one.
  async renew() {
    if (!this.wanted()) return;
    const setting = this.setting();
    const key = JSON.stringify(setting.copy());
    if (key === this.key) return;
    this.key = key;
    this.holder.classList.add("stale");
    const heard = await this.line.ask("statics", setting.asks("statics"), 1);
    if (key !== this.key) return;
    if (!heard) {
      this.key = null;
      return;
    }
    this.holder.classList.remove("stale");
    const { answer } = heard;
    const trouble = answer.problems?.map(({ message, help }) => [message, help].filter(Boolean).join(" ")).join(" ") ?? answer.failed;
    if (trouble) {
      this.holder.replaceChildren(element("p", { class: "soft" }, trouble));
      return;
    }
    // The module escapes what is foreign.
    const sections = (answer.sections ?? []).map(({ title, html }) => {
      const made = element("section", { class: "text" }, element("h2", {}, title));
      made.insertAdjacentHTML("beforeend", html);
      return made;
    });
    const pictures = (answer.pictures ?? []).map(({ title, svg }) => {
      const sheet = element("div", { class: "sheet", tabindex: "0", role: "img", "aria-label": title });
      sheet.innerHTML = svg;
      return element("section", { class: "picture" }, element("h2", {}, title), sheet);
    });
    this.holder.replaceChildren(...pictures, ...sections);
  }
}
