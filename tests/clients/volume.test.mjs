// Tests of the page of grasp-state volumes in headless Chromium: operates its controls and compares it with the written
// points and shares. Screenshots: target/page-screenshots.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, statSync } from "node:fs";
import path from "node:path";
import { after, before, describe, it } from "node:test";

import { DIRECTORY, PHALANX, SCREENSHOTS, opened, start, stop } from "./browser.mjs";

let file, points, shares;
before(async () => {
  await start();
  ({ file, points, shares } = runVolume("volumes", "--base", "12 mm, 15.5 mm, 22.5 mm", "--mu-static", "0,0.8", "--resolution", "7,6,5"));
});
after(stop);

/** Runs `phalanx volume`; returns its page, points and shares. */
function runVolume(name, ...args) {
  const out = path.join(DIRECTORY, name);
  execFileSync(PHALANX, ["volume", ...args, "--out", out], { stdio: ["ignore", "ignore", "inherit"] });
  const [head, ...lines] = readFileSync(path.join(out, "points.csv"), "utf8").trim().split(/\r?\n/).map((line) => line.split(","));
  const points = lines.map((cells) => Object.fromEntries(head.map((column, index) => [column, cells[index]])));
  return { file: path.join(out, "page.html"), points, shares: JSON.parse(readFileSync(path.join(out, "table.json"), "utf8")) };
}

const near = (found, expected, relative, what) =>
  assert.ok(Math.abs(found - expected) <= relative * Math.abs(expected) + 1e-12, `${what}: ${found}, not ${expected}`);

/** Reads the facts of the design panel, by name. */
const readFacts = (page) =>
  page.evaluate(() => Object.fromEntries([...document.querySelectorAll("#design tr")].map((row) => [...row.children].map((cell) => cell.textContent))));

/** Parses the number of a quantity: "333.6 N·mm" → 333.6. */
const parseNumber = (text) => Number(text.replace("−", "-").match(/^-?[\d.]+/)?.[0] ?? assert.fail(text));

describe("the page of grasp-state volumes", () => {
  it("is small", () => assert.ok(statSync(file).size < 4e5, `${statSync(file).size} bytes`));

  it("contains the points of the data file with seven digits", async () => {
    const { page, call, close } = await opened(file);
    const size = await page.evaluate(() => window.phalanx.size);
    assert.deepEqual(size, [7, 6, 5]);
    let row = 0;
    for (let base = 0; base < 3; base++) {
      for (let friction = 0; friction < 2; friction++) {
        await call("setBase", base);
        await call("setFriction", friction);
        const cells = [];
        for (let i = 0; i < 7; i++) for (let j = 0; j < 6; j++) for (let k = 0; k < 5; k++) cells.push([i, j, k]);
        const found = await page.evaluate((cells) => cells.map((cell) => window.phalanx.point(cell)), cells);
        for (const point of found) {
          const expected = points[row++];
          for (const column of ["l11_m", "l12_m", "l21_m", "l22_m", "t22_m", "mass_kg", "motor_n_m", "spring_n_m", "static_f21_n", "static_f22_n", "static_pfp_n"]) {
            near(point[column], Number(expected[column]), 1e-7, column);
          }
          const flags = ["force_positive", "palm_force_positive", "form_closed"].map((name) => expected[name] === "true");
          assert.deepEqual([1, 2, 4].map((bit) => (point.flags & bit) !== 0), flags);
        }
      }
    }
    assert.equal(row, points.length);
    await close();
  });

  it("computes the shares of the table for every volume and the intersection", async () => {
    const { page, call, state, close } = await opened(file);
    let compared = 0;
    const compare = async (base, friction, expected) => {
      await call("setBase", base);
      await call("setFriction", friction);
      const found = (await state()).shares;
      near(found.stable, expected.stable_percent, 1e-9, "stable");
      near(found.palm, expected.palm_positive_percent, 1e-9, "palm");
      near(found.closed, expected.form_closed_percent, 1e-9, "closed");
      assert.equal(await page.locator('#shares [data-region="stable"]').textContent(), `${expected.stable_percent.toFixed(2)}\u202f%`);
      compared++;
    };
    for (const [index, expected] of shares.volumes.entries()) await compare(index >> 1, index & 1, expected);
    for (const [friction, expected] of shares.intersections.entries()) await compare(-1, friction, expected);
    assert.equal(compared, 8);
    await close();
  });

  it("colours the selected region, and hides other cells", async () => {
    const { call, state, close } = await opened(file);
    await call("setFriction", 0);
    const all = await state();
    assert.ok(all.coloured > 0 && all.faces > all.coloured);
    await call("setRest", false);
    const bare = await state();
    assert.ok(bare.coloured >= all.coloured, "cells behind the dark ones become visible");
    await call("setRegion", "palm");
    const palmPoints = points.filter((point) => point.base_m === "0.012" && point.mu_static === "0.0" && point.force_positive === "true" && point.palm_force_positive === "true");
    const palm = await state();
    assert.ok(palm.coloured <= palmPoints.length && palm.coloured < bare.coloured);
    await call("setRegion", "closed");
    await call("setBase", 2);
    assert.equal((await state()).coloured, 0, "no design is form-closed at the largest base");
    await close();
  });

  it("draws each cell in the colour of its value", async () => {
    const { page, call, close } = await opened(file);
    await call("setBase", 1);
    await call("view", "front");
    // The slice of the smallest r_l is in front.
    const cells = [[0, 0, 0], [3, 5, 0], [6, 5, 0], [2, 2, 0]];
    const found = await page.evaluate((cells) => {
      const { phalanx } = window;
      phalanx.state();
      const canvas = document.getElementById("stage");
      const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return cells.map((cell) => {
        const [x, y] = phalanx.toScreen(cell).map((at) => Math.round(at) + 4);
        const first = 4 * (y * width + x);
        return { pixel: [...data.slice(first, first + 3)], colour: phalanx.colour(cell), flags: phalanx.point(cell).flags };
      });
    }, cells);
    const stable = found.filter(({ flags }) => flags & 1);
    assert.ok(stable.length >= 3, `${stable.length} cells`);
    for (const { pixel, colour } of stable) {
      // Faces normal to r_l are slightly darker.
      const off = Math.max(...pixel.map((channel, c) => Math.abs(channel - 0.97 * colour[c])));
      assert.ok(off < 3, `${pixel}, not ${colour}`);
    }
    assert.ok(new Set(stable.map(({ pixel }) => pixel.join())).size >= 3, "different values have different colours");
    await close();
  });

  it("shows the design under the pointer and selects it on click", async () => {
    const { page, call, state, close } = await opened(file);
    await call("setBase", 1);
    await call("view", "front");
    await state();
    const box = await page.locator("#stage").boundingBox();
    for (const cell of [[1, 4, 0], [5, 3, 0]]) {
      const [x, y] = await call("toScreen", cell);
      await page.mouse.move(box.x + x, box.y + y);
      assert.deepEqual((await state()).design, cell);
      const shownFacts = await readFacts(page);
      const expected = points.find((point, row) => point.base_m === "0.0155" && point.mu_static === "0.8" && (row % 210) === (cell[0] * 6 + cell[1]) * 5 + cell[2]);
      near(parseNumber(shownFacts["palm PFP"]), Number(expected.static_pfp_n), 2e-3, "PFP");
      near(parseNumber(shownFacts["motor τ11"]), 1e3 * Number(expected.motor_n_m), 1e-3, "motor");
      near(parseNumber(shownFacts.l21), 1e3 * Number(expected.l21_m), 1e-3, "l21");
      near(parseNumber(shownFacts.mass), 1e3 * Number(expected.mass_kg), 1e-3, "mass");
    }
    await page.mouse.down();
    await page.mouse.up();
    await page.mouse.move(box.x + 5, box.y + box.height - 5);
    const kept = await state();
    assert.deepEqual([kept.chosen, kept.design], [[5, 3, 0], [5, 3, 0]]);
    await page.mouse.move(box.x + 300, box.y + 300);
    await page.mouse.down();
    await page.mouse.move(box.x + 380, box.y + 340, { steps: 4 });
    await page.mouse.up();
    const turned = await state();
    near(turned.turn_rad - kept.turn_rad, 0.8, 0.05, "rotated by the drag");
    assert.deepEqual(turned.chosen, [5, 3, 0], "a drag does not change the selection");
    await page.mouse.wheel(0, -300);
    await page.waitForFunction(() => window.phalanx.state().zoom > 1.5);
    await close();
  });

  it("can be operated by keyboard", async () => {
    const { page, state, close } = await opened(file);
    const press = async (key) => {
      await page.keyboard.press(key);
      return state();
    };
    const start = await state();
    assert.ok((await press("ArrowRight")).turn_rad > start.turn_rad);
    assert.ok((await press("ArrowUp")).tilt_rad < start.tilt_rad);
    assert.ok((await press("+")).zoom > 1);
    assert.equal((await press("0")).zoom, 1);
    const bases = [];
    for (let n = 0; n < 4; n++) bases.push((await press("b")).base);
    assert.deepEqual(bases, [1, 2, -1, 0]);
    assert.equal((await press("Shift+B")).base, -1);
    assert.equal((await press("m")).friction, 0);
    const keys = new Set();
    for (let n = 0; n < 7; n++) keys.add((await press("c")).quantity);
    assert.equal(keys.size, 7);
    assert.equal((await press("g")).region, "palm");
    assert.equal((await press("s")).rest, false);
    assert.deepEqual((await press("l")).chosen, [3, 3, 2]);
    assert.deepEqual((await press("l")).chosen, [4, 3, 2]);
    assert.deepEqual((await press("Shift+P")).chosen, [4, 2, 2]);
    for (let n = 0; n < 5; n++) await press("r");
    assert.deepEqual((await state()).chosen, [4, 2, 4], "the index is limited");
    assert.deepEqual((await press("x")).slices[0], [4, 4]);
    assert.deepEqual((await press("x")).slices[0], [0, 6]);
    assert.deepEqual((await press("z")).slices[1], [2, 2]);
    assert.deepEqual((await press("a")).slices, [[0, 6], [0, 5], [0, 4]]);
    assert.equal((await press("Escape")).chosen, null);
    assert.equal((await press("3")).tilt_rad, Math.PI / 2);
    await press("?");
    assert.ok(await page.locator("#help").isVisible());
    await page.keyboard.press("Escape");
    // Every control can be reached with Tab, has a name and shows the focus.
    const seen = new Set();
    for (let k = 0; k < 40; k++) {
      await page.keyboard.press("Tab");
      const focus = await page.evaluate(() => {
        const element = document.activeElement;
        const { outlineStyle, outlineWidth } = getComputedStyle(element);
        const named = element.getAttribute("aria-label") || element.labels?.[0]?.textContent || element.textContent;
        return { id: element.id || element.getAttribute("aria-label"), tag: element.tagName, outline: outlineStyle !== "none" && parseFloat(outlineWidth) >= 2, named: Boolean(named?.trim()) };
      });
      if (focus.tag === "BODY") break;
      assert.ok(focus.outline && focus.named, JSON.stringify(focus));
      seen.add(focus.id);
    }
    for (const id of ["stage", "base", "friction", "quantity", "region", "rest", "same", "view-top", "zoom-in", "slices-all", "φ22: from", "r_l: to", "theme", "help-open"]) {
      assert.ok(seen.has(id), `${id} is not reached with Tab`);
    }
    await close();
  });

  it("restricts axes by sliders, which push each other", async () => {
    const { page, state, close } = await opened(file);
    const [from, to] = [page.getByLabel("φ22: from"), page.getByLabel("φ22: to")];
    await from.focus();
    for (let n = 0; n < 3; n++) await page.keyboard.press("ArrowRight");
    assert.deepEqual((await state()).slices[1], [3, 5]);
    const whole = (await state()).turn_rad;
    await to.focus();
    await page.keyboard.press("Home");
    const cut = await state();
    assert.deepEqual(cut.slices[1], [0, 0]);
    assert.equal(cut.turn_rad, whole, "arrow keys on a slider do not rotate the volume");
    assert.equal(await page.locator("fieldset.slice output").nth(1).textContent(), "90°");
    assert.equal(cut.faces > 0 && cut.faces < 200, true);
    await close();
  });

  it("supports a common scale for all volumes", async () => {
    const { call, state, close } = await opened(file);
    const own = (await state()).scale;
    await call("setSameScale", true);
    const all = (await state()).scale;
    const stable = points.filter((point) => point.force_positive === "true").map((point) => Number(point.static_pfp_n));
    near(all[1], Math.max(...stable), 1e-6, "the maximum of all volumes");
    assert.ok(all[1] > own[1] && all[0] === -all[1]);
    await close();
  });

  for (const [width, height] of [[390, 844], [1280, 800]]) {
    for (const scheme of ["light", "dark"]) {
      it(`is readable at ${width} pixels in ${scheme} colours`, async () => {
        const { page, call, state, close } = await opened(file, { width, height, scheme, deviceScaleFactor: width < 500 ? 2 : 1, hasTouch: width < 500 });
        const shot = async (name) => {
          await state();
          await page.screenshot({ path: path.join(SCREENSHOTS, `volume-${width}-${scheme}-${name}.png`) });
        };
        await shot("start");
        // The names of the axes are within the canvas from any direction.
        const box = await page.locator("canvas").first().boundingBox();
        for (let k = 0; k < 12; k++) {
          await call("turn", 0.5, 0);
          const { names_px } = await state();
          assert.ok(names_px.length >= 2 && names_px.every(([from, to]) => from >= 0 && to <= box.width), JSON.stringify(names_px));
        }
        await call("view", "corner");
        await call("setBase", 1);
        await call("setSlice", 0, 0, 3);
        await call("choose", [4, 5, 1]);
        await shot("design");
        await page.locator("#quantity").selectOption({ label: "form closure" });
        await call("setBase", -1);
        await call("setRegion", "stable");
        await shot("intersection");
        const found = await page.evaluate(() => {
          const rgb = (text) => text.match(/[\d.]+/g).map(Number);
          const luminance = ([r, g, b]) => {
            const [x, y, z] = [r, g, b].map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
            return 0.2126 * x + 0.7152 * y + 0.0722 * z;
          };
          const ground = (element) => {
            for (let each = element; each; each = each.parentElement) {
              const colour = rgb(getComputedStyle(each).backgroundColor);
              if ((colour[3] ?? 1) > 0.99) return colour;
            }
            return [255, 255, 255];
          };
          const poor = [];
          const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
          for (let node; (node = walker.nextNode()); ) {
            const element = node.parentElement;
            if (!node.textContent.trim() || !element.checkVisibility() || element.closest("script, dialog, noscript, .skip, option")) continue;
            const [a, b] = [luminance(rgb(getComputedStyle(element).color)), luminance(ground(element))].sort((x, y) => y - x);
            if ((a + 0.05) / (b + 0.05) < 4.5) poor.push(`${node.textContent.trim().slice(0, 40)}: ${getComputedStyle(element).color}`);
          }
          return {
            poor,
            small: [...document.querySelectorAll("main button, main select")].filter((each) => each.offsetHeight < 32 || each.offsetWidth < 32).length,
            wide: document.documentElement.scrollWidth - innerWidth,
            ground: luminance(rgb(getComputedStyle(document.body).backgroundColor)),
            cut: [...document.querySelectorAll("#design td, #design th, #shares dd, .slice output, .swatches span")].filter((each) => each.scrollWidth > each.clientWidth + 1).map((each) => each.textContent),
          };
        });
        assert.deepEqual(found.poor, [], "contrast below 4.5");
        assert.equal(found.small, 0);
        assert.ok(found.wide <= 0, `${found.wide} pixels too wide`);
        assert.ok(scheme === "dark" ? found.ground < 0.05 : found.ground > 0.8);
        assert.deepEqual(found.cut, [], "texts that are cut off");
        await page.keyboard.press("?");
        await shot("help");
        await page.keyboard.press("Escape");
        await close();
      });
    }
  }

  it("allows no network access", async () => {
    const { page } = await opened(file);
    const blocked = await page.evaluate(async () => {
      const violated = new Promise((resolve) => addEventListener("securitypolicyviolation", (event) => resolve(event.effectiveDirective), { once: true }));
      await fetch("https://example.org/").catch(() => {});
      return violated;
    });
    assert.equal(blocked, "connect-src");
    await page.context().close();
  });
});

describe("volumes with holes", () => {
  it("leave cells without a finger empty, and show the reason", async () => {
    const holes = runVolume("holes", "--base", "15.5 mm", "--mu-static", "0.8", "--resolution", "6", "--phi22", "0.5 rad, 2.6 rad", "--arm-ratio", "0.3,2.5");
    const empty = holes.points.findIndex((point) => point.reason);
    assert.ok(empty >= 0 && holes.points.some((point) => !point.reason));
    const { page, call, state, close } = await opened(holes.file);
    const cell = [Math.floor(empty / 36), Math.floor(empty / 6) % 6, empty % 6];
    await call("choose", cell);
    await state();
    const reason = (await call("point", cell)).reason;
    assert.ok(reason.length > 20);
    assert.ok((await page.locator("#design").textContent()).includes(reason));
    assert.ok((await page.locator("#swatches").textContent()).includes("no such finger"));
    assert.equal(await page.locator("#base option").count(), 1, "one base has no intersection");
    await page.screenshot({ path: path.join(SCREENSHOTS, "volume-holes.png") });
    await close();
  });

  it("show a single point", async () => {
    const single = runVolume("single", "--base", "15.5 mm", "--mu-static", "0.8", "--resolution", "1");
    const { state, close } = await opened(single.file);
    const { faces, coloured, shares } = await state();
    assert.deepEqual([faces, coloured, shares.stable], [3, 1, 100]);
    await close();
  });
});
