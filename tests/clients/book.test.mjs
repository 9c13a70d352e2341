// Tests of the tutorial's site in headless Chromium: the explorer on its first page, and every link into the explorer,
// which is compared with the native program and with the figures stated in the chapter. Screenshots: target/page-
// screenshots.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import path from "node:path";
import { after, before, describe, it } from "node:test";
import { inflateRawSync } from "node:zlib";

import { DIRECTORY, PHALANX, PROJECT, SCREENSHOTS, opened, start, stop } from "./browser.mjs";

const SITE = path.join(DIRECTORY, "site");
const EXPERIMENT = path.join(PROJECT, "scenes/experiment-95.toml");
const SLOW = { timeout: 300_000 };
const SIZES = { s: 1, ms: 1e-3, "µs": 1e-6, N: 1, kN: 1e3, mm: 1e-3, "µm": 1e-6, deg: Math.PI / 180, "%": 1 };

const TYPES = { ".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".json": "application/json", ".svg": "image/svg+xml", ".png": "image/png", ".woff2": "font/woff2" };

let server, site;
before(async () => {
  await start();
  execFileSync("python3", [path.join(PROJECT, "tools/book.py"), SITE], { stdio: ["ignore", "ignore", "inherit"], env: { ...process.env, PHALANX } });
  // The search of MkDocs needs a server.
  server = createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, site).pathname);
    try {
      const body = readFileSync(path.join(SITE, path.normalize(name)));
      response.writeHead(200, { "content-type": TYPES[path.extname(name)] ?? "application/octet-stream" }).end(body);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  site = `http://127.0.0.1:${server.address().port}/`;
});
after(async () => {
  await stop();
  server?.close();
});

/** Path of a shipped scene, or of a scene whose compressed text is in the address. */
function scenePath(scene, text) {
  if (text === null) return path.join(PROJECT, "scenes", scene);
  const file = path.join(DIRECTORY, scene);
  writeFileSync(file, inflateRawSync(Buffer.from(text, "base64url")));
  return file;
}

/** JSON output of the native program for a scene file with overridden fields. */
function native(file, set) {
  const flags = set.flatMap(([field, value]) => ["--set", `${field}=${value}`]);
  return JSON.parse(execFileSync(PHALANX, ["run", file, ...flags, "--json"], { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] }));
}

/** Asserts that numeric figures of the explorer equal those of the native program; returns their number. */
function countEqualFigures({ figures }, document) {
  const pairs = figures.map(({ key, value }) => [key, value, key.split(".").reduce((at, part) => at?.[part], document)]);
  const numeric = pairs.filter(([, value, found]) => typeof found === "number" && value !== null);
  for (const [key, value, found] of numeric) assert.ok(Math.abs(value - found) <= 1e-9 * Math.max(Math.abs(found), 1e-6), `${key}: ${value}, not ${found}`);
  return numeric.length;
}

/** Whether a number equals a stated figure within half of the last stated digit. */
function isStated(value, stated) {
  const [, number, unit] = stated.match(/^(-?[\d.]+)\s?(\S*)$/) ?? assert.fail(`${stated} is not a number with a unit`);
  const size = unit === "" ? 1 : SIZES[unit] ?? assert.fail(`unknown unit ${unit}`);
  const resolution = 10 ** -(number.split(".")[1] ?? "").length;
  return Math.abs(value / size - Number(number)) <= 0.5001 * resolution;
}

/** Text of the statics tab of the explorer. */
async function readStaticsTab(page) {
  await page.locator("#tab-statics").click();
  await page.locator("#panel-statics svg").first().waitFor();
  return page.locator("#panel-statics").innerText();
}

/** Asserts that the explorer shows the map of an address, and that its points equal the native program. */
async function assertMapMatches(page, call, [x, y, criterion], file, set) {
  await page.locator("#tab-map").click();
  await page.waitForFunction(() => document.getElementById("map-state").textContent.endsWith("closings"), null, { timeout: 120_000 });
  const chosen = await page.locator("#map-x, #map-y, #map-criterion").evaluateAll((all) => all.map(({ value }) => value));
  assert.deepEqual(chosen, [x, y, criterion]);
  const seen = new Set();
  const rest = set.filter(([field]) => field !== x && field !== y);
  for (const [i, j] of [[0, 4], [0, 12], [6, 8], [10, 8], [10, 16], [32, 32]]) {
    const at = await call("mapAt", i, j);
    let found = null;
    try {
      found = criterion.split(".").reduce((part, key) => part?.[key], native(file, [...rest, [x, at.x], [y, at.y]])) ?? null;
    } catch (error) {
      // An invalid scene has no value on the map.
      assert.equal(error.status, 2, `${at.x}, ${at.y}`);
    }
    assert.equal(at.value, typeof found === "boolean" ? (found ? "yes" : "no") : found, `${at.x}, ${at.y}`);
    if (found !== null) seen.add(at.value);
  }
  assert.ok(seen.size > 1, "the map has more than one colour");
}

/** Returns every link into the explorer with its page. */
async function links() {
  const found = [];
  for (const name of readdirSync(SITE, { recursive: true }).filter((each) => each.endsWith(".html") && each !== "explorer.html" && !each.startsWith("live"))) {
    if (!readFileSync(path.join(SITE, name), "utf8").includes('class="explore"')) continue;
    const { page, close } = await opened(site + name, { allowedSite: site });
    const text = await page.locator("body").innerText();
    for (const { href, says } of await page.locator("a.explore").evaluateAll((all) => all.map(({ href, dataset }) => ({ href, says: dataset.says ?? "" })))) {
      assert.equal(href.split("#")[0], `${site}explorer.html`, name);
      found.push({ page: name, text, hash: new URL(href).hash, says: says ? says.split("; ").map((each) => each.split("=")) : [] });
    }
    await close();
  }
  return found;
}

describe("the tutorial's site", () => {
  for (const [width, height] of [[1280, 800], [390, 844]]) {
    for (const scheme of ["light", "dark"]) {
      it(`shows the explorer on its first page, ${width} px, ${scheme}`, SLOW, async () => {
        const { page, close } = await opened(`${site}index.html`, { width, height, scheme, allowedSite: site });
        const holder = page.locator("iframe.explorer");
        assert.equal(await holder.getAttribute("loading"), "lazy");
        await holder.scrollIntoViewIfNeeded();
        const frame = await (await holder.elementHandle()).contentFrame();
        await frame.waitForFunction(() => window.phalanx);
        await frame.evaluate(() => window.phalanx.settled());
        const size = await holder.boundingBox();
        assert.ok(size.height >= 560 && size.height < height, `${size.height} px high: part of the page remains visible`);
        for (const each of [page, frame]) assert.equal(await each.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth), 0);
        assert.ok(countEqualFigures(await frame.evaluate(() => window.phalanx.state()), native(EXPERIMENT, [])) > 20);
        const slider = frame.locator('.field[data-path="design.base"] input[type=range]');
        await slider.focus();
        await page.keyboard.press("Shift+ArrowRight");
        await frame.waitForFunction(() => window.phalanx.state().set.length === 1);
        await frame.evaluate(() => window.phalanx.settled());
        const moved = await frame.evaluate(() => window.phalanx.state());
        assert.ok(countEqualFigures(moved, native(EXPERIMENT, moved.set)) > 20);
        await frame.evaluate(() => window.phalanx.pause());
        await holder.evaluate((each) => each.scrollIntoView({ block: "center" }));
        await page.waitForTimeout(200);
        await page.screenshot({ path: path.join(SCREENSHOTS, `book-${width}-${scheme}.png`) });
        await close();
      });
    }
  }

  it("opens every link into the explorer, which shows the figures stated in the chapters", SLOW, async (test) => {
    const all = await links();
    const sceneLinks = all.filter(({ hash }) => hash !== "");
    assert.deepEqual(all.filter(({ hash }) => hash === "").map(({ page }) => page), ["index.html"], "one link without a scene");
    assert.ok(sceneLinks.length >= 10, `${sceneLinks.length} links`);
    let stated = 0;
    for (const { page: name, text, hash, says } of sceneLinks) {
      const query = new URLSearchParams(hash.slice(1));
      const [scene, set] = [query.get("scene"), query.getAll("set").map((pair) => pair.split(/=(.*)/).slice(0, 2))];
      const file = scenePath(scene, query.get("text"));
      const at = `${name}: ${hash}`;
      const { page, state, call, close } = await opened(`${site}explorer.html`, { hash });
      await page.waitForFunction(() => window.phalanx);
      await call("settled");
      const now = await state();
      assert.deepEqual([now.file, now.set, now.problems], [scene, set, []], at);
      for (const [field] of set) assert.ok(field in now.fields, `${at}: unknown field ${field}`);
      if (query.has("t")) assert.equal(now.time_s, Number(query.get("t")), at);
      assert.ok(countEqualFigures(now, native(file, set)) > 10, at);
      for (const [key, value] of says) {
        const number = value.split(/\s|(?=ms$)/)[0];
        assert.ok(text.includes(number), `${name} does not state ${number}`);
        const figure = now.figures.find((each) => each.key === key);
        if (key === "statics") assert.ok((await readStaticsTab(page)).includes(value), `${at}: the statics tab does not contain ${value}`);
        else if (key === "verdict") assert.equal((await call("check")).verdict, value.toLowerCase(), at);
        else if (key === "t") assert.ok(isStated(now.time_s, value), `${at}: time ${now.time_s} s`);
        else if (/^-?\d/.test(value)) assert.ok(isStated(figure?.value, value), `${at}: ${key} is ${figure?.value}, not ${value}`);
        else assert.equal(figure?.text, value, at);
        stated++;
      }
      if (query.has("map")) await assertMapMatches(page, call, query.get("map").split(","), file, set);
      await close();
    }
    test.diagnostic(`${sceneLinks.length} links, ${stated} figures that are stated`);
    assert.ok(stated >= 8, `${stated} figures are stated`);
  });

  it("rejects a figure that differs from the stated one", () => {
    assert.ok(isStated(0.006883746, "6.88 ms") && isStated(23.6091, "23.6091 N") && isStated(98861.4, "98861 N"));
    assert.ok(!isStated(0.006883746, "6.89 ms") && !isStated(98862, "98861 N") && !isStated(undefined, "1 N"));
  });
});
