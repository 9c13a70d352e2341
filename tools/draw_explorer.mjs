#!/usr/bin/env node
// Creates the README's pictures of the explorer, light and dark: two closing designs, their figures, and a map.
//
// usage: node tools/draw_explorer.mjs      (requires `tools/clients.sh setup` and the module built by tools/explorer.sh)
// $PHALANX: program, $PHALANX_EXPLORER: module, $CHROMIUM: browser.

import { execFileSync } from "node:child_process";
import path from "node:path";

import { DIRECTORY, PHALANX, PROJECT, opened, start, stop } from "../tests/clients/browser.mjs";

const FIGURES = path.join(PROJECT, "tools/figures");
const [WIDTH, HEIGHT] = [1500, 860];
// Second touch-down of A; B has a smaller base.
const SECOND_TOUCH_S = 0.006883746;
const B = [["design.base", "14 mm"]];

await start();
try {
  const file = path.join(DIRECTORY, "explorer.html");
  execFileSync(PHALANX, ["explore", "-o", file], { stdio: ["ignore", "ignore", "inherit"] });
  for (const [scheme, name] of [["light", "explorer.png"], ["dark", "explorer-dark.png"]]) {
    const { page, call, close } = await opened(file, { width: WIDTH, height: HEIGHT, scheme, reducedMotion: "reduce" });
    await page.waitForFunction(() => window.phalanx);
    await call("settled");
    await call("keep");
    for (const [field, value] of B) await call("set", field, value);
    await call("map", "design.base", "design.phi22", "criteria.tts_s");
    // Simulates again with the optimised module, so that the displayed duration is that of a moving slider.
    for (const [field, value] of B) await call("set", field, value);
    await call("seek", SECOND_TOUCH_S);
    await call("check");
    // Waits for the last frame and the completed map.
    await page.waitForTimeout(500);
    const foot = await page.locator("footer").boundingBox();
    await page.screenshot({ path: path.join(FIGURES, name), clip: { x: 0, y: 0, width: WIDTH, height: Math.min(HEIGHT, Math.floor(foot.y)) } });
    await close();
  }
} finally {
  await stop();
}
