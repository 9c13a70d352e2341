#!/usr/bin/env node
// Measures the explorer: size of the page, time to the first picture, duration of a run of each preset. Prints a Markdown
// table.
//
// usage: node tools/explorer_cost.mjs      (requires `tools/clients.sh setup` and the module built by tools/explorer.sh)
// $PHALANX: program, $PHALANX_EXPLORER: module, $CHROMIUM: browser.

import { execFileSync } from "node:child_process";
import { readFileSync, statSync } from "node:fs";
import path from "node:path";

import { DIRECTORY, PHALANX, opened, start, stop } from "../tests/clients/browser.mjs";

// Loads of the page; runs of a scene; discarded runs before the browser has optimised the module.
const [LOADS, RUNS, WARM] = [5, 25, 10];
const GROUPS = { finger: "fingers", gripper: "grippers", mechanism: "mechanisms", hard: "hard cases" };

const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];
const digits = (value) => String(Number(value.toPrecision(2)));

await start();
try {
  const file = path.join(DIRECTORY, "explorer.html");
  execFileSync(PHALANX, ["explore", "-o", file], { stdio: ["ignore", "ignore", "inherit"] });
  const [, data] = readFileSync(file, "utf8").match(/<script type="application\/json" id="explorer">(.*?)<\/script>/s);
  const firsts = [];
  for (let load = 0; load < LOADS; load++) {
    const { page, state, call, close } = await opened(file);
    await page.waitForFunction(() => window.phalanx);
    await call("settled");
    firsts.push((await state()).firstPicture_ms);
    await close();
  }
  const { page, state, call, close } = await opened(file);
  await page.waitForFunction(() => window.phalanx);
  const costs = {};
  for (const { file: scene, group } of JSON.parse(data).presets) {
    await call("preset", scene);
    await call("settled");
    const times = [];
    for (let run = 0; run < RUNS; run++) {
      // The description does not affect the simulation.
      await call("set", "description", `run ${run}`);
      times.push((await state()).ms);
    }
    (costs[group] ??= []).push([median(times.slice(WARM)), scene]);
  }
  await close();
  console.log("| | |\n|---|---:|");
  console.log(`| the page, one file | ${(statSync(file).size / 1e6).toFixed(2)} MB |`);
  console.log(`| first picture after it is opened, median of ${LOADS} | ${digits(median(firsts) / 1e3)} s |`);
  for (const [group, all] of Object.entries(costs)) {
    all.sort(([a], [b]) => a - b);
    const [[least], [most, slowest]] = [all[0], all.at(-1)];
    console.log(`| a run in the worker, with its playback and figures: ${all.length} ${GROUPS[group]} | ${digits(least)} to ${digits(most)} ms (${slowest}) |`);
  }
} finally {
  await stop();
}
