// The help dialog with all keys.

/** Fills the dialog with the keys and connects its button; returns the function that opens it. */
function connectHelp(dialog, keys) {
  for (const [names, description] of keys) {
    const cell = element("span");
    names.forEach((name, index) => cell.append(index ? " " : "", element("kbd", {}, name)));
    byId("keys").append(cell, element("span", {}, description));
  }
  const openHelp = () => { if (!dialog.open) dialog.showModal(); };
  byId("help-open").addEventListener("click", openHelp);
  return openHelp;
}
