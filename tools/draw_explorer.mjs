#!/usr/bin/env node
// Takes the README's pictures of the explorer, light and dark: two designs as they close, their figures, and a map around them.
//
// usage: node tools/draw_explorer.mjs      (needs what `tools/clients.sh setup` installs, and the module of tools/explorer.sh)
// $PHALANX names the program, $PHALANX_EXPLORER the module, $CHROMIUM the browser.

import { execFileSync } from "node:child_process";
import path from "node:path";

import { DIRECTORY, PHALANX, PROJECT, opened, start, stop } from "../tests/clients/browser.mjs";

const FIGURES = path.join(PROJECT, "tools/figures");
const [WIDTH, HEIGHT] = [1500, 860];
// The second touch of what is kept as A; B has a smaller base.
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
    // Once more now that the browser has compiled all of the module well: so it says how long a run takes under a moving hand.
    for (const [field, value] of B) await call("set", field, value);
    await call("seek", SECOND_TOUCH_S);
    await call("check");
    // The last frame and the last line of the map.
    await page.waitForTimeout(500);
    const foot = await page.locator("footer").boundingBox();
    await page.screenshot({ path: path.join(FIGURES, name), clip: { x: 0, y: 0, width: WIDTH, height: Math.min(HEIGHT, Math.floor(foot.y)) } });
    await close();
  }
} finally {
  await stop();
}
