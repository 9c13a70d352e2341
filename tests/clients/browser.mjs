// A headless Chromium that opens pages from the disk, for the tests of pages; each test file is a process of its own.

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
/** A directory of these tests' own. */
export const DIRECTORY = mkdtempSync(path.join(tmpdir(), "phalanx-page-"));
const CHROMIUM = execFileSync("sh", ["-c", 'command -v "$0"', process.env.CHROMIUM || "chromium"], { encoding: "utf8" }).trim();
const QUIET = ["--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];

let browser;

/** Starts the browser: before all tests. */
export async function start() {
  mkdirSync(SCREENSHOTS, { recursive: true });
  browser = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", ...QUIET] });
}

/** Ends the browser and clears up: after all tests. */
export async function stop() {
  await browser?.close();
  rmSync(DIRECTORY, { recursive: true });
}

/**
 * A page (a file or an address) in a browser that fails on anything it complains of or asks for, but what is under the address `beside`.
 * What moves by itself takes the time of the other tests, so the browser asks pages not to, unless a test says `reducedMotion`.
 */
export async function opened(file, { width = 1280, height = 800, scheme = "light", reducedMotion = "reduce", hash = "", beside = null, ...more } = {}) {
  const address = file.startsWith("http:") ? file : pathToFileURL(file).href;
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, reducedMotion, ...more });
  const page = await context.newPage();
  const complaints = [];
  // A page of ours says nothing; that of a site may tell of its search.
  page.on("console", (message) => beside !== null && message.type() === "log" || complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.stack));
  page.on("request", (request) => {
    // What the page saves is its own; everything else would come from somewhere.
    const own = request.url().startsWith("data:") || request.url().startsWith("blob:");
    const near = beside !== null && request.url().startsWith(beside);
    if (request.url().split("#")[0] !== address && !own && !near) complaints.push(request.url());
  });
  await page.goto(address + hash);
  return {
    page,
    complaints,
    state: () => page.evaluate(() => window.phalanx.state()),
    call: (name, ...args) => page.evaluate(([name, args]) => window.phalanx[name](...args), [name, args]),
    async close() {
      await context.close();
      assert.deepEqual(complaints, []);
    },
  };
}
