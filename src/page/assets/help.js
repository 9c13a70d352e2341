// The help: every key and what it does.

/** Fills the dialog with the keys and lets its button open it; what opens it comes back. */
function keyHelp(help, keys) {
  for (const [names, what] of keys) {
    const cell = element("span");
    names.forEach((name, index) => cell.append(index ? " " : "", element("kbd", {}, name)));
    byId("keys").append(cell, element("span", {}, what));
  }
  const open = () => { if (!help.open) help.showModal(); };
  byId("help-open").addEventListener("click", open);
  return open;
}
