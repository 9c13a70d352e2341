// Tests of the explorer in headless Chromium: its results are compared with the native program. The module is the one
// next to the program (built by tools/explorer.sh), or $MODULE. Screenshots: target/page-screenshots.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import path from "node:path";
import { after, before, describe, it } from "node:test";
import { deflateRawSync } from "node:zlib";

import { DIRECTORY, PHALANX, PROJECT, SCREENSHOTS, opened, start, stop } from "./browser.mjs";
import { gif } from "./gif.mjs";

const MODULE = process.env.MODULE ? ["--module", process.env.MODULE] : [];
const SCENE = path.join(PROJECT, "scenes/experiment-95.toml");
const TWO_PIVOT = path.join(PROJECT, "scenes/mechanisms/two-pivot.toml");
const CYCLE = path.join(PROJECT, "scenes/gripper/cycle.toml");
const SLOW = { timeout: 120_000 };

let file;
before(async () => {
  await start();
  file = writeExplorer(SCENE, "explorer.html");
});
after(stop);

/** Writes the explorer of a scene; returns its path. */
function writeExplorer(scene, name) {
  const out = path.join(DIRECTORY, name);
  execFileSync(PHALANX, ["explore", ...MODULE, scene, "-o", out], { stdio: ["ignore", "ignore", "inherit"] });
  return out;
}

/** JSON output of the native program for a scene with overridden fields. */
function native(scene, set = []) {
  const flags = set.flatMap(([field, value]) => ["--set", `${field}=${value}`]);
  return JSON.parse(execFileSync(PHALANX, ["run", scene, ...flags, "--json"], { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] }));
}

/** Opens a page; waits for its first run and pauses the playback. */
async function openReady(options = {}, from = file) {
  const all = await opened(from, options);
  await all.page.waitForFunction(() => window.phalanx);
  await all.call("settled");
  await all.call("pause");
  return all;
}

/** Returns a figure of the page by key. */
const figure = ({ figures }, key) => figures.find((each) => each.key === key) ?? assert.fail(`no figure ${key}`);

/** Asserts that all numeric figures of the page equal those of the native program exactly. */
function assertFiguresEqual(state, expected) {
  let compared = 0;
  for (const { key, value } of state.figures) {
    const found = key.split(".").reduce((at, part) => at?.[part], expected);
    if (typeof found !== "number" || value === null) continue;
    assert.equal(value, found, key);
    compared++;
  }
  assert.ok(compared > 20, `${compared} figures`);
  if (expected.kind === "finger") assert.equal(figure(state, "criteria.class").text, expected.criteria.class);
}

const slider = (page, field) => page.locator(`.field[data-path="${field}"] input[type=range]`);
const entry = (page, field) => page.locator(`.field[data-path="${field}"] input[type=text]`);
const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];

describe("the explorer", () => {
  it("is a file under 4 MB", () => assert.ok(statSync(file).size < 4e6, `${statSync(file).size} bytes`));

  it("shows its first picture quickly", async (test) => {
    const times = [];
    for (let k = 0; k < 3; k++) {
      const { state, close } = await openReady();
      times.push((await state()).firstPicture_ms);
      await close();
    }
    test.diagnostic(`first picture after ${times.map(Math.round).join(", ")} ms; target: below 1000`);
    assert.ok(median(times) < 3000, `${times} ms`);
  });

  it("has the figures of the native program", async () => {
    const { page, state, close } = await openReady();
    assertFiguresEqual(await state(), native(SCENE));
    const strip = await page.locator("#strip output").allTextContents();
    const figures = (await state()).figures.slice(0, strip.length).map(({ text }) => text);
    assert.deepEqual(strip, figures);
    const { criteria } = native(SCENE);
    assert.equal(await page.locator("#class-reason").textContent(), `${criteria.class}: ${criteria.class_reason}`);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-light.png") });
    await close();
  });

  it("simulates again when a slider moves, by keyboard and by mouse", SLOW, async () => {
    const { page, call, state, close } = await openReady();
    const before = await state();
    await slider(page, "design.base").focus();
    for (let k = 0; k < 7; k++) await page.keyboard.press("ArrowRight");
    await page.keyboard.press("Shift+ArrowRight");
    await call("settled");
    const keyed = await state();
    assert.notEqual(keyed.fields["design.base"].value, before.fields["design.base"].value);
    assertFiguresEqual(keyed, native(SCENE, keyed.set));
    assert.equal(await entry(page, "design.base").inputValue(), keyed.fields["design.base"].text);

    const box = await slider(page, "design.phi22").boundingBox();
    const pointAt = (part) => [box.x + part * box.width, box.y + box.height / 2];
    await page.mouse.move(...pointAt(0.5));
    await page.mouse.down();
    const seen = new Set();
    for (let k = 1; k <= 20; k++) {
      await page.mouse.move(...pointAt(0.5 + 0.01 * k));
      seen.add(await page.locator("#strip output").nth(1).textContent());
    }
    await page.mouse.up();
    assert.ok(seen.size > 3, `${seen.size} different times to stability while dragging`);
    await call("settled");
    const dragged = await state();
    assert.equal(dragged.set.length, 2);
    assertFiguresEqual(dragged, native(SCENE, dragged.set));
    await close();
  });

  it("updates while a slider moves, and retains the time", SLOW, async (test) => {
    const { page, call, state, close } = await openReady();
    await call("seek", 0.005);
    const { ms, frames, seconds } = await page.evaluate(async () => {
      const slider = document.querySelector(".field[data-path='design.base'] input[type=range]");
      const [low, high] = [Number(slider.min), Number(slider.max)];
      const [ms, from] = [[], performance.now()];
      let frames = 0;
      await new Promise((resolve) => {
        const frame = () => {
          const past = performance.now() - from;
          slider.value = low + (high - low) * (0.4 + 0.1 * Math.sin(past / 300));
          slider.dispatchEvent(new Event("input", { bubbles: true }));
          ms.push(window.phalanx.state().ms);
          frames++;
          if (past < 2000) requestAnimationFrame(frame);
          else resolve();
        };
        requestAnimationFrame(frame);
      });
      return { ms, frames, seconds: (performance.now() - from) / 1000 };
    });
    await call("settled");
    test.diagnostic(`worker ${median(ms).toFixed(2)} ms a closing (median); ${(frames / seconds).toFixed(0)} pictures a second`);
    // Its speed depends on the load of the machine; tools/explorer_cost.mjs measures it.
    assert.ok(new Set(ms).size > 1, `${frames} pictures: ${ms}`);
    assert.ok(Math.abs((await state()).time_s - 0.005) < 1e-12);
    await close();
  });

  it("accepts values with a unit, and shows problems next to the field", async () => {
    const { page, call, state, close } = await openReady();
    const field = entry(page, "design.base");
    await field.fill("1.6 cm");
    await field.press("Enter");
    await call("settled");
    assertFiguresEqual(await state(), native(SCENE, [["design.base", "1.6 cm"]]));
    // A number without a unit has the unit of the field.
    await field.fill("1.65");
    await field.press("Enter");
    await call("settled");
    assert.deepEqual((await state()).set, [["design.base", "1.65 cm"]]);
    const good = await state();
    await field.fill("3 kg");
    await field.press("Enter");
    await call("settled");
    const wrong = await state();
    assert.equal(wrong.problems.length, 1);
    const text = await page.locator('.field[data-path="design.base"] .problem').textContent();
    assert.match(text, /3 kg is a mass/);
    assert.ok(await page.locator("#warning").isHidden(), "the problem is shown once");
    assert.deepEqual(wrong.figures, good.figures, "the last valid results remain");
    assert.equal(await call("check"), null);
    assert.equal(await page.locator("#verdict").textContent(), "not simulated");
    const opacities = await page.evaluate(() => ["stage", "strip", "class-reason", "panel-plots", "panel-map"].map((id) => Number(getComputedStyle(document.getElementById(id)).opacity)));
    assert.ok(opacities.every((opacity) => opacity < 0.5), `${opacities}`);
    await page.keyboard.press("Escape");
    await call("undo");
    const back = await state();
    assert.deepEqual([back.problems, back.figures], [[], good.figures]);
    // A problem of a hidden field is shown as a warning on the page.
    await call("set", "integrator.rtol", "3 kg");
    assert.match(await page.locator("#warning").textContent(), /integrator.rtol/);
    assert.equal(await page.locator(".problem:visible").count(), 0);
    await call("undo");
    assert.ok(await page.locator("#warning").isHidden());
    assert.equal((await call("check")).verdict, "sure");
    await close();
  });

  it("undoes, redoes and restores values of the scene", async () => {
    const { page, call, state, close } = await openReady();
    const first = await state();
    await call("set", "design.base", "16 mm");
    const second = await state();
    await call("set", "motor.torque", "500 N*mm");
    const third = await state();
    await page.locator("h1").click();
    await page.keyboard.press("Control+z");
    await call("settled");
    assert.deepEqual([(await state()).set, (await state()).figures], [second.set, second.figures]);
    await page.locator("#undo").click();
    await call("settled");
    assert.deepEqual([(await state()).set, (await state()).figures], [[], first.figures]);
    assert.ok(await page.locator("#undo").isDisabled());
    await page.keyboard.press("Control+Shift+z");
    await page.keyboard.press("Control+Shift+z");
    await call("settled");
    assert.deepEqual((await state()).figures, third.figures);
    await page.locator('.field[data-path="design.base"] .reset').click();
    await call("settled");
    assert.deepEqual((await state()).set, [["motor.torque", "500 N*mm"]]);
    await slider(page, "motor.torque").dblclick();
    await call("settled");
    assert.deepEqual([(await state()).set, (await state()).figures], [[], first.figures]);
    await close();
  });

  it("filters fields by text and by change", async () => {
    const { page, call, state, close } = await openReady();
    await call("set", "design.base", "16 mm");
    const shown = () => page.locator(".field:visible").evaluateAll((rows) => rows.map((row) => row.dataset.path));
    await page.keyboard.press("/");
    await page.keyboard.type("gravity");
    assert.deepEqual(await shown(), ["gravity"]);
    await page.locator("#filter").fill("");
    await page.locator("#changed-only").check();
    assert.deepEqual(await shown(), ["design.base"]);
    const sections = new Set(Object.keys((await state()).fields).map((field) => field.split(".")[0]));
    assert.deepEqual(["integrator", "engine", "validate", "log"].filter((section) => sections.has(section)), ["integrator"], "only sections that are used");
    await close();
  });

  it("restores its state from its address", async () => {
    const one = await openReady();
    await one.call("set", "design.base", "14.5 mm");
    one.call("keep");
    await one.call("set", "motor.torque", "500 N*mm");
    await one.call("map", "design.phi22", "design.base", "criteria.tts_s");
    await one.call("seek", 0.0061);
    const [address, before] = [await one.call("url"), await one.state()];
    await one.page.waitForFunction((address) => location.hash === address, address);
    await one.close();
    const two = await openReady({ hash: address });
    await two.page.waitForFunction(() => window.phalanx.state().reference);
    const after = await two.state();
    assert.deepEqual([after.set, after.figures, after.reference, after.time_s], [before.set, before.figures, before.reference, before.time_s]);
    assert.equal(await two.call("url"), address);
    await two.close();
    // A custom scene is contained in the address.
    const own = await openReady();
    await own.page.locator("#tab-scene").click();
    await own.page.locator("#scene").fill(readFileSync(SCENE, "utf8").replace("experiment-95", "own").replace("15.5 mm", "15 mm"));
    await own.page.locator("#scene-take").click();
    await own.call("settled");
    const [link, figures] = [await own.call("url"), (await own.state()).figures];
    await own.close();
    const again = await openReady({ hash: link });
    assert.deepEqual((await again.state()).figures, figures);
    assert.equal(await again.page.title(), "own");
    await again.close();
    // A scene file can be opened.
    const chosen = await openReady();
    await chosen.page.locator("#scene-file").setInputFiles(path.join(PROJECT, "scenes/torsional-spring.toml"));
    await chosen.page.waitForFunction(() => window.phalanx.state().file === "torsional-spring.toml");
    await chosen.call("settled");
    assertFiguresEqual(await chosen.state(), native(path.join(PROJECT, "scenes/torsional-spring.toml")));
    await chosen.close();
    // A truncated address is ignored with a warning.
    const cut = await openReady({ hash: "#scene=own.toml&text=eJ" });
    assertFiguresEqual(await cut.state(), native(SCENE));
    assert.match(await cut.page.locator("#warning").textContent(), /cannot be read/);
    // A decompression bomb is rejected.
    const bomb = deflateRawSync(Buffer.alloc(400 << 20, "#")).toString("base64url");
    await cut.page.evaluate((text) => { location.hash = `scene=own.toml&text=${text}`; }, bomb);
    await cut.page.locator("#warning", { hasText: "longer than the limit of 1024 KiB" }).waitFor();
    assertFiguresEqual(await cut.state(), native(SCENE));
    await cut.close();
  });

  it("compares A and B", async () => {
    const { page, call, state, close } = await openReady();
    const a = await state();
    await page.keyboard.press("k");
    await call("set", "design.base", "17 mm");
    const b = await state();
    assert.deepEqual(b.reference, a.figures);
    await page.locator("#tab-compare").click();
    const rows = await page.locator("table.figures tbody tr").evaluateAll((rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent)));
    b.figures.forEach(({ label, text }, index) => assert.deepEqual(rows[index].slice(0, 3), [label, a.figures[index].text, text]));
    const time = b.figures.findIndex(({ key }) => key === "criteria.tts_s");
    const difference = b.figures[time].value - a.figures[time].value;
    const [, shownDifference] = rows[time][3].replace("−", "-").match(/^([+-]?[\d.]+)\u202f[mµ]s/) ?? assert.fail(rows[time][3]);
    assert.ok(Math.abs(Number(shownDifference) - difference * (Math.abs(difference) >= 1e-3 ? 1e3 : 1e6)) <= 6e-3 * Math.abs(Number(shownDifference)), `${rows[time][3]} of ${difference} s`);
    assert.deepEqual(b.runs.map(({ label }) => label), ["B", "A"]);
    await call("seek", 0.02);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-compared.png") });
    await call("swap");
    const swapped = await state();
    assert.deepEqual([swapped.figures, swapped.reference, swapped.set], [a.figures, b.figures, []]);
    await call("drop");
    assert.equal((await state()).reference, null);
    await close();
  });

  it("fills a map with the values of the native program, and adopts a clicked point", SLOW, async () => {
    const { page, call, state, close } = await openReady();
    const { failed, points } = await call("map", "design.base", "design.phi22", "criteria.tts_s");
    assert.deepEqual([failed, points], [null, 33 * 33]);
    for (const [i, j] of [[8, 16], [12, 20], [15, 9]]) {
      const { x, y, value } = await call("mapAt", i, j);
      const expected = native(SCENE, [["design.base", x], ["design.phi22", y]]).criteria.tts_s ?? null;
      assert.equal(value, expected, `${x}, ${y}`);
    }
    const goal = await call("mapAt", 12, 20);
    await page.mouse.click(...await call("mapPlace", 12, 20));
    await call("settled");
    const there = await state();
    assert.deepEqual(there.set, [["design.base", goal.x], ["design.phi22", goal.y]]);
    assert.equal(figure(there, "criteria.tts_s").value, goal.value);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-map.png") });
    // By keyboard, from the position of the pointer: two to the right and one down.
    await page.locator("#map").focus();
    for (const key of ["ArrowRight", "ArrowRight", "ArrowDown", "Enter"]) await page.keyboard.press(key);
    await call("settled");
    const next = await call("mapAt", 14, 19);
    assert.deepEqual((await state()).set, [["design.base", next.x], ["design.phi22", next.y]]);
    assert.match(await page.locator("#map-description").textContent(), /time to stability/);
    // Another field changes the map; classes have their own colours.
    await call("set", "motor.torque", "450 N*mm");
    const torque = ["motor.torque", "450 N*mm"];
    await call("map", "design.base", "design.phi22", "criteria.class");
    // Each class has the same colour in the legend, in the strip and in pictures of studies.
    const colours = () => page.evaluate(() => {
      const of = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`);
      const named = Object.entries({ stable: "s0", "semi-stable": "pale", "semi-unstable": "doubtful", unstable: "neutral" });
      const shown = (ink) => Object.assign(document.createElement("canvas").getContext("2d"), { fillStyle: ink }).fillStyle;
      const legend = [...document.querySelectorAll("#map-legend .entry")].map((entry) => [entry.textContent, entry.firstChild.className || shown(entry.firstChild.style.background)]);
      const dot = getComputedStyle(document.querySelector("#strip output"), "::before").backgroundColor;
      return { legend, dot: shown(dot), wanted: named.map(([word, name]) => [word, shown(of(name))]) };
    });
    for (let scheme = 0; scheme < 2; scheme++) {
      const { legend, dot, wanted: expectedColours } = await colours();
      assert.deepEqual(legend.slice(0, -1), expectedColours);
      assert.equal(dot, new Map(expectedColours).get((await state()).figures[0].text));
      assert.deepEqual(legend.at(-1), ["invalid scene, or no such result", "none"]);
      await page.keyboard.press("d");
    }
    const { x, y, value } = await call("mapAt", 12, 20);
    assert.equal(value, native(SCENE, [["design.base", x], ["design.phi22", y], torque]).criteria.class);
    await close();
  });

  it("checks a run after a pause in the edits, and marks unreliable runs", SLOW, async () => {
    const sure = await openReady();
    assert.equal((await sure.call("check")).verdict, "sure");
    assert.equal(await sure.page.locator("#verdict").textContent(), "checked");
    assert.ok(await sure.page.locator("#doubt").isHidden());
    assert.ok(await sure.page.locator("#warnings").isHidden());
    await sure.close();
    const warned = await openReady({}, writeExplorer(CYCLE, "cycle.html"));
    const { warnings } = native(CYCLE);
    assert.deepEqual(await warned.page.locator("#warnings p").allTextContents(), warnings);
    assert.match(await warned.page.locator("#warnings summary").textContent(), new RegExp(`${warnings.length} warnings`));
    await warned.close();
    const chaos = path.join(PROJECT, "scenes/hard/chaos.toml");
    const { page, call, state, close } = await openReady({}, writeExplorer(chaos, "chaos.html"));
    const { verdict } = await call("check");
    assert.equal(verdict, native(chaos).check?.verdict ?? verdict);
    assert.ok(["uncertain", "chaotic"].includes(verdict), verdict);
    assert.equal(await page.locator("#verdict").textContent(), verdict);
    assert.match(await page.locator("#doubt").textContent(), new RegExp(`This run is ${verdict}`));
    assert.equal((await state()).verdict.verdict, verdict);
    await page.waitForFunction(() => window.phalanx.state().variations > 3);
    const { trusted_s, runs } = await state();
    assert.ok(trusted_s > 0.005 && trusted_s < 0.06, `${trusted_s} s`);
    assert.match(await page.locator("#doubt").textContent(), /from [\d.]+\u202fms on/);
    assert.equal(runs.length, 1);
    await call("seek", 0.055);
    await page.waitForTimeout(300);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-uncertain.png") });
    await close();
  });

  it("shows the statics report of the native program", async () => {
    const { page, call, close } = await openReady();
    const panel = page.locator("#panel-statics");
    // Every number with a decimal point in the native text; the last digits of the certificate are rounding errors.
    const numbers = (...flags) => {
      const text = execFileSync(PHALANX, ["statics", SCENE, ...flags], { encoding: "utf8" });
      return text.replace(/\(to [^)]*\)/, "").match(/\d+\.\d+/g);
    };
    await page.locator("#tab-statics").click();
    await panel.locator("svg").first().waitFor();
    const first = numbers();
    assert.ok(first.length > 30, `${first.length} numbers`);
    const panelText = await panel.textContent();
    assert.deepEqual(first.filter((each) => !panelText.includes(each)), []);
    // The report follows the sliders.
    await call("set", "design.base", "17 mm");
    const next = numbers("--set", "design.base=17 mm");
    assert.ok(next.some((each) => !panelText.includes(each)));
    await page.waitForFunction((expected) => expected.every((each) => document.getElementById("panel-statics").textContent.includes(each)), next);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-statics.png") });
    await close();
  });

  it("opens presets, including a gripper", SLOW, async () => {
    const { page, call, state, close } = await openReady();
    const files = await page.locator("#preset option").evaluateAll((options) => options.map((option) => option.value));
    assert.ok(files.length >= 3, files.join(", "));
    const gripper = "gripper/design-95.toml";
    await page.locator("#preset").selectOption(gripper);
    await call("settled");
    const expected = native(path.join(PROJECT, "scenes", gripper));
    const found = await state();
    assert.equal(found.file, gripper);
    assert.deepEqual(found.problems, []);
    assert.equal(figure(found, "grasp.fate").text, expected.grasp.fate);
    assertFiguresEqual(found, expected);
    await call("toggleSymbols");
    assert.ok((await state()).symbols.some(({ text }) => text === "l21"));
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-gripper.png") });
    await call("undo");
    assertFiguresEqual(await state(), native(SCENE));
    await close();
  });

  it("opens a mechanism, with sliders of its parameters and a map of its fates", { timeout: 300_000 }, async (test) => {
    const text = readFileSync(TWO_PIVOT, "utf8").replace('at = ["3 mm", "120 mm"]', 'at = ["3 mm", "= center"]').replace('"0.8 rad"]', '"= close"]');
    const scene = path.join(DIRECTORY, "own.toml");
    writeFileSync(scene, text.replace("[parameters]\n", '[parameters]\ncenter = "120 mm"\nclose = "0.8 rad"\n'));
    const { page, call, state, close } = await openReady({ width: 1400, height: 900 }, writeExplorer(scene, "mechanism.html"));
    const before = await state();
    assertFiguresEqual(before, native(scene));
    assert.deepEqual(before.figures.slice(0, 3).map(({ label }) => label), ["fate", "margin", "time to stability"]);
    test.diagnostic(`worker ${before.ms.toFixed(0)} ms a closing`);
    // It moves.
    const place = async (time) => {
      await call("seek", time);
      return (await state()).runs[0].bodies;
    };
    assert.notDeepEqual(await place(0.01), await place(0.09));
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-mechanism.png") });

    // Parameters come first; the parts of the mechanism are collapsed.
    const shown = await page.locator("#fields input[type=range]:visible").evaluateAll((all) => all.map((each) => each.getAttribute("aria-label")));
    assert.deepEqual(shown.slice(0, 2), ["parameters.center", "parameters.close"]);
    assert.ok(Object.keys(before.fields).length > 60 && shown.length < 20, `${shown.length} sliders`);
    await page.locator("#filter").fill("right_tip pad");
    assert.ok(await slider(page, "bodies.right_tip.outlines.pad.size[1]").isVisible());
    await page.locator("#filter").fill("");

    // A is overlaid on B, which the slider of a parameter has changed.
    await page.keyboard.press("Escape");
    await call("keep");
    await slider(page, "parameters.center").focus();
    for (let k = 0; k < 3; k++) await page.keyboard.press("Shift+ArrowRight");
    await call("settled");
    const after = await state();
    assert.notEqual(after.fields["parameters.center"].value, 120);
    assert.notDeepEqual(after.figures, before.figures);
    assertFiguresEqual(after, native(scene, after.set));
    assert.deepEqual(after.runs.map(({ label }) => label), ["B", "A"]);
    await call("seek", 0.15);
    await page.locator("#tab-compare").click();
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-mechanism-compared.png") });

    // The coarse points of the map suffice for two fates.
    await page.locator("#tab-map").click();
    await page.waitForFunction(() => document.querySelectorAll("#map-legend .entry > i:not(.none)").length > 1, null, { timeout: 240_000 });
    assert.equal(await page.locator("#map-criterion").inputValue(), "grasp.fate");
    const legend = await page.locator("#map-legend .entry").allTextContents();
    const fates = ["held", "carried", "placed", "dropped", "escaped", "not grasped"].filter((fate) => legend.includes(fate));
    assert.ok(fates.length > 1, `${legend}`);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-mechanism-map.png") });
    await page.locator("#map-criterion").selectOption("grasp.margin.driven.acceleration_m_s2");
    assert.match(await page.locator("#map-legend").textContent(), /m\/s²/);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-mechanism-margin.png") });

    await page.locator("#tab-statics").click();
    await page.locator("#panel-statics svg").first().waitFor();
    assert.match(await page.locator("#panel-statics").textContent(), /actuators of the hand/);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-mechanism-statics.png") });
    await close();
  });

  it("shows symbols while the pointer is over a field", async () => {
    const { page, state, close } = await openReady();
    assert.deepEqual((await state()).symbols, []);
    await slider(page, "design.base").hover();
    const symbols = (await state()).symbols.map(({ text }) => text);
    for (const symbol of ["l11", "l12", "l21", "l22", "t22", "φ22", "base", "q11", "q22"]) assert.ok(symbols.includes(symbol), symbol);
    await close();
  });

  it("saves files in standard formats", SLOW, async () => {
    const { page, call, state, close } = await openReady();
    await call("set", "design.base", "16.2 mm");
    const saved = async (kind) => {
      const [download] = await Promise.all([page.waitForEvent("download", { timeout: 90_000 }), page.selectOption("#save", kind)]);
      const name = path.join(DIRECTORY, download.suggestedFilename());
      await download.saveAs(name);
      return name;
    };
    const toml = await saved("toml");
    assertFiguresEqual(await state(), native(toml));
    const csv = readFileSync(await saved("csv"), "utf8").trim().split(/\r?\n/);
    const log = path.join(DIRECTORY, "run.mcap");
    const table = path.join(DIRECTORY, "native.csv");
    execFileSync(PHALANX, ["run", toml, "--set", "log.joint_forces=true", "--log", log], { stdio: "ignore" });
    execFileSync(PHALANX, ["replay", log, "--csv", table], { stdio: "ignore" });
    const expected = readFileSync(table, "utf8").trim().split(/\r?\n/);
    assert.deepEqual(csv, expected);
    const svg = readFileSync(await saved("svg"), "utf8");
    assert.match(svg, /^<svg xmlns.*<\/svg>\s*$/s);
    assert.deepEqual([...readFileSync(await saved("png")).subarray(1, 4)], [...Buffer.from("PNG")]);
    await call("setWindow", 0.0044, 0.0046);
    await call("setSpeed", 1e-4);
    const animation = gif(readFileSync(await saved("gif")));
    assert.ok(animation.frames.length > 10, `${animation.frames.length} frames`);
    if (await page.locator("#save option[value='webm']").count()) {
      assert.deepEqual([...readFileSync(await saved("webm")).subarray(0, 4)], [0x1a, 0x45, 0xdf, 0xa3]);
    }
    await close();
  });

  for (const scheme of ["light", "dark"]) {
    it(`fits a phone and supports touch, ${scheme}`, async () => {
      const { page, call, state, close } = await openReady({ width: 390, height: 844, scheme, hasTouch: true, isMobile: true });
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
      // Every tab is visible without scrolling.
      for (const tab of ["map", "statics", "scene"]) assert.ok(await page.locator(`#tab-${tab}`).evaluate((tab) => tab.getBoundingClientRect().bottom < innerHeight && tab.getBoundingClientRect().right <= innerWidth), tab);
      const box = await slider(page, "design.base").boundingBox();
      await page.touchscreen.tap(box.x + 0.6 * box.width, box.y + box.height / 2);
      await call("settled");
      const touched = await state();
      assert.equal(touched.set.length, 1);
      assertFiguresEqual(touched, native(SCENE, touched.set));
      await page.screenshot({ path: path.join(SCREENSHOTS, `explorer-phone-${scheme}.png`) });
      // The animation and the figures remain visible while the fields scroll.
      await slider(page, "contact.friction.mu_static").scrollIntoViewIfNeeded();
      await page.evaluate(() => scrollBy(0, 300));
      const tops = await page.evaluate(() => ["stage", "strip"].map((id) => document.getElementById(id).getBoundingClientRect()).map(({ top, bottom }) => [top, bottom]));
      assert.ok(tops.every(([top, bottom]) => top >= -1 && bottom <= 600), JSON.stringify(tops));
      for (const tab of ["compare", "map", "statics", "events", "scene"]) {
        await page.locator(`#tab-${tab}`).click();
        await page.waitForTimeout(100);
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390, tab);
      }
      await close();
    });
  }

  for (const [width, height] of [[390, 844], [768, 1024], [1400, 900]]) {
    it(`does not cut off text at ${width} pixels`, SLOW, async () => {
      const cut = ({ page }) => page.evaluate(() => {
        document.querySelectorAll("#fields details").forEach((group) => { group.open = true; });
        const seen = [...document.querySelectorAll(".results *, .transport *, .tabs *, #fields *, .text td, .text th, .legend *, .file *")].filter((each) => each.offsetWidth > 1 && !each.matches(".hidden, canvas, input[type='range']"));
        return seen.filter((each) => each.scrollWidth > each.clientWidth + 1 && getComputedStyle(each).display !== "inline" || each.getBoundingClientRect().right > innerWidth).map((each) => each.value || each.textContent);
      });
      for (const scene of [SCENE, CYCLE, TWO_PIVOT]) {
        const all = await openReady({ width, height }, writeExplorer(scene, "cut.html"));
        const { page } = all;
        for (const tab of width < 1100 ? ["fields", "map", "statics"] : ["map", "statics"]) {
          await page.locator(`#tab-${tab}`).click();
          if (tab === "statics") await page.locator("#panel-statics svg").first().waitFor();
          assert.deepEqual(await cut(all), [], `${scene}, ${tab}`);
        }
        // Text in the picture is at least as large as in the tables.
        const heights = await page.locator("#panel-statics svg text").evaluateAll((all) => all.map((text) => text.getBoundingClientRect().height));
        assert.ok(Math.min(...heights) > 10, `${heights}`);
        if (width === 1400) assert.equal(await page.evaluate(() => document.documentElement.scrollHeight), height, "the page does not scroll");
        await all.close();
      }
    });
  }

  it("keeps its layout while figures change", async () => {
    const { page, call, close } = await openReady();
    const places = () => page.evaluate(() => ["strip", "speed-of-run", "play", "stage"].map((id) => {
      const { top, height } = document.getElementById(id).getBoundingClientRect();
      return [id, top, height];
    }));
    const before = await places();
    for (const base of ["12 mm", "19 mm", "24 mm", "3 kg"]) {
      await call("set", "design.base", base);
      assert.deepEqual(await places(), before, base);
    }
    await close();
  });

  it("does not play automatically with reduced motion", async () => {
    const still = await opened(file, { reducedMotion: "reduce" });
    await still.page.waitForFunction(() => window.phalanx);
    assert.equal((await still.state()).playing, false);
    await still.close();
    const moving = await opened(file, { reducedMotion: "no-preference" });
    await moving.page.waitForFunction(() => window.phalanx);
    assert.equal((await moving.state()).playing, true);
    await moving.close();
  });

  it("supports dark colours", async () => {
    const { page, call, close } = await openReady({ scheme: "dark", width: 1720, height: 1000 });
    await call("seek", 0.02);
    await page.waitForTimeout(100);
    await page.screenshot({ path: path.join(SCREENSHOTS, "explorer-dark.png") });
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "dark");
    await close();
  });
});
