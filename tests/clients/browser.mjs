// Headless Chromium for the tests of pages. Each test file runs in its own process.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

import { chromium } from "playwright-core";

export const PROJECT = fileURLToPath(new URL("../../", import.meta.url));
export const PHALANX = process.env.PHALANX ?? path.join(PROJECT, "target/debug/phalanx");
export const SCREENSHOTS = path.join(PROJECT, "target/page-screenshots");
/** Temporary directory of the test file. */
export const DIRECTORY = mkdtempSync(path.join(tmpdir(), "phalanx-page-"));
const CHROMIUM = execFileSync("sh", ["-c", 'command -v "$0"', process.env.CHROMIUM || "chromium"], { encoding: "utf8" }).trim();
const QUIET = ["--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];

let browser;

/** Starts the browser, before all tests. */
export async function start() {
  mkdirSync(SCREENSHOTS, { recursive: true });
  browser = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", ...QUIET] });
}

/** Stops the browser and removes the temporary directory, after all tests. */
export async function stop() {
  await browser?.close();
  rmSync(DIRECTORY, { recursive: true });
}

/**
 * Opens a page (a file or an address). `close` fails on console messages, errors and requests, except requests below the
 * address `allowedSite`. Animations slow down the other tests, so reduced motion is requested by default.
 */
export async function opened(file, { width = 1280, height = 800, scheme = "light", reducedMotion = "reduce", hash = "", allowedSite = null, ...more } = {}) {
  const address = file.startsWith("http:") ? file : pathToFileURL(file).href;
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, reducedMotion, ...more });
  const page = await context.newPage();
  const problems = [];
  // Pages of phalanx must not log; the search of the site may.
  page.on("console", (message) => allowedSite !== null && message.type() === "log" || problems.push(message.text()));
  page.on("pageerror", (error) => problems.push(error.stack));
  page.on("request", (request) => {
    // Saved files are data or blob addresses; any other request is external.
    const isLocal = request.url().startsWith("data:") || request.url().startsWith("blob:");
    const isAllowed = allowedSite !== null && request.url().startsWith(allowedSite);
    if (request.url().split("#")[0] !== address && !isLocal && !isAllowed) problems.push(request.url());
  });
  await page.goto(address + hash);
  return {
    page,
    problems,
    state: () => page.evaluate(() => window.phalanx.state()),
    call: (name, ...args) => page.evaluate(([name, args]) => window.phalanx[name](...args), [name, args]),
    async close() {
      await context.close();
      assert.deepEqual(problems, []);
    },
  };
}
