// Tests of the page of a validation in headless Chromium: operates its controls and compares what it draws with the
// logs, which are read with @mcap/core and protobufjs. Screenshots: target/page-screenshots.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import path from "node:path";
import { after, before, describe, it } from "node:test";

import { McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import "protobufjs/ext/descriptor.js";

import { DIRECTORY, PHALANX, PROJECT, SCREENSHOTS, opened, start, stop } from "./browser.mjs";
import { gif } from "./gif.mjs";

before(start);
after(stop);

/** Validates a scene; returns the directory with its page and logs. */
function validate(scene, name) {
  const out = path.join(DIRECTORY, name);
  execFileSync(PHALANX, ["validate", scene, "--quick", "--out", out], { stdio: ["ignore", "ignore", "inherit"] });
  return out;
}

/** Decodes the messages of a log, by topic. */
function messages(log) {
  const reader = new McapStreamReader({ decompressHandlers: { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) } });
  reader.append(readFileSync(log));
  const [channels, types, topics] = [new Map(), new Map(), {}];
  for (let record; (record = reader.nextRecord()) !== undefined; ) {
    if (record.type === "Schema") {
      types.set(record.id, protobuf.Root.fromDescriptor(record.data, { keepCase: true }).lookupType(record.name));
    } else if (record.type === "Channel") {
      channels.set(record.id, record);
    } else if (record.type === "Message") {
      const { topic, schemaId } = channels.get(record.channelId);
      (topics[topic] ??= []).push(types.get(schemaId).decode(record.data));
    }
  }
  return { ...topics, states: states(topics) };
}

/** The coordinates of a finger at each sample: angles and rates of its joints. */
const states = (topics) =>
  (topics["/joint/q11"] ?? []).map(({ timestamp }, k) => {
    const joints = ["11", "21", "12", "22"].map((index) => [index, topics[`/joint/q${index}`][k]]);
    const angles = joints.map(([index, { angle_rad }]) => [`q${index}_rad`, angle_rad]);
    return Object.fromEntries([["timestamp", timestamp], ...angles, ...joints.map(([index, { rate_rad_s }]) => [`qd${index}_rad_s`, rate_rad_s])]);
  });

/** The first touch-down of a contact. */
const touchDown = (log, name) => log["/event"].find(({ subject, kind }) => subject === name && kind === "touch_down");

/** The last message of a topic at an exact time. */
const at = (topic, time) => topic.findLast((message) => message.timestamp === time);

const near = (found, expected, relative, what) =>
  assert.ok(Math.abs(found - expected) <= relative * Math.abs(expected) + 1e-300, `${what}: ${found}, not ${expected}`);

/** Parses a quantity: "98.459 kN" → 98459. */
function parseQuantity(text) {
  const [, number, unit] = text.replace("−", "-").replace("−", "-").match(/^(-?[\d.]+(?:e-?\d+)?)\s?(.*)$/) ?? assert.fail(text);
  if (unit === "°") return (Number(number) * Math.PI) / 180;
  const prefix = { p: 1e-12, n: 1e-9, µ: 1e-6, m: 1e-3, k: 1e3, M: 1e6 };
  const bare = ["N", "m", "J", "N·m", "m/s", "rad/s"];
  return Number(number) * (bare.includes(unit) ? 1 : prefix[unit[0]] ?? assert.fail(text));
}

/** Reads the table of a plot: texts by series and run. */
const readPlotTable = (page, title) =>
  page.evaluate((title) => {
    const plot = [...document.querySelectorAll(".plot")].find((each) => each.getAttribute("aria-label") === title);
    const rows = [...plot.querySelectorAll("tbody tr")];
    return Object.fromEntries(rows.map((row) => [row.querySelector("th").textContent, [...row.querySelectorAll("td")].map((cell) => cell.textContent)]));
  }, title);

describe("the page of a closing in both models", () => {
  let file, logs;
  before(() => {
    const out = validate(path.join(PROJECT, "scenes/experiment-95.toml"), "closing");
    file = path.join(out, "page.html");
    logs = ["analytic", "engine"].map((model) => messages(path.join(out, `${model}.mcap`)));
  });

  it("is small", () => assert.ok(statSync(file).size < 1.5e6, `${statSync(file).size} bytes`));

  it("draws the poses, contacts and arrows of the log, to the bit", async () => {
    const { state, call, close } = await opened(file);
    const [analytic, engine] = logs;
    const { time: first } = { time: engine.states[0].timestamp };
    assert.equal((await state()).time_s, first);
    // Every 10th sample of the engine, of which the page has all samples; the ends and peaks of the reference, which
    // are retained.
    const times = engine.states.filter((_, index) => index % 10 === 0).map((message) => message.timestamp);
    const peaks = ["proximal", "distal"].map((name) => {
      const contact = analytic[`/contact/${name}`];
      return contact.reduce((best, each) => (each.normal_n > best.normal_n ? each : best)).timestamp;
    });
    const ends = [analytic.states[0].timestamp, analytic.states.at(-1).timestamp];
    let [arrows, activeContacts] = [0, 0];
    for (const [index, log, when] of [[0, analytic, [...ends, ...peaks]], [1, engine, times]]) {
      const reach = { l12: new Set(), l22: new Set() };
      for (const time of when) {
        await call("seek", time);
        const drawn = (await state()).runs[index];
        const q = at(log.states, time);
        const body = Object.fromEntries(drawn.bodies.map((each) => [each.name, each]));
        for (const [name, angle] of [["l11", q.q11_rad], ["l12", q.q11_rad + q.q12_rad], ["l21", q.q21_rad], ["l22", q.q21_rad + q.q22_rad]]) {
          assert.equal(body[name].angle_rad, angle, `${name} at ${time}`);
        }
        assert.deepEqual([body.l11.x_m, body.l11.y_m, body.l21.x_m, body.l21.y_m], [0, 0, 0, 0]);
        for (const [name, angle] of [["l12", q.q11_rad], ["l22", q.q21_rad]]) {
          const { x_m, y_m } = body[name];
          near(Math.atan2(y_m, x_m), Math.atan2(Math.sin(angle), Math.cos(angle)), 1e-12, `direction of ${name}`);
          reach[name].add(Math.hypot(x_m, y_m).toPrecision(12));
        }
        for (const name of ["proximal", "distal"]) {
          const logged = at(log[`/contact/${name}`], time);
          const contact = drawn.contacts.find((each) => each.name === name);
          assert.equal(contact.gap_m, logged.gap_m);
          assert.deepEqual(contact.point_m, [logged.point_x_m, logged.point_y_m]);
          for (const arrow of drawn.arrows.filter((each) => each.contact === name)) {
            arrows++;
            const normal = arrow.kind === "normal";
            assert.equal(arrow.force_n, normal ? logged.normal_n : logged.tangential_n);
            assert.deepEqual(arrow.from_m, contact.point_m);
            const along = normal ? [logged.normal_x, logged.normal_y] : [-logged.normal_y, logged.normal_x];
            assert.deepEqual(arrow.direction, along.map((k) => Math.sign(arrow.force_n) * k));
            assert.ok(arrow.length_px > 1);
          }
          if (logged.normal_n > 1) {
            activeContacts++;
            assert.ok(drawn.arrows.some((each) => each.contact === name && each.kind === "normal"));
          }
        }
        for (const [panel, series, value] of [
          ["Joint angle", "q22", q.q22_rad],
          ["Joint rate", "q11", q.qd11_rad_s],
          ["Energy", "balance", at(log["/energy"], time).balance_j],
          ["Torque", "limit", at(log["/contact/limit"], time).torque_n_m],
        ]) assert.equal(drawn.readings[panel][series], value, `${panel}, ${series}`);
      }
      for (const [name, lengths] of Object.entries(reach)) assert.equal(lengths.size, 1, `${name} has a constant distance from its joint`);
    }
    assert.ok(activeContacts > 10 && arrows >= activeContacts, `${arrows} arrows of ${activeContacts} contacts`);
    await close();
  });

  it("draws the frames of the log", async () => {
    const { call, state, close } = await opened(file);
    const [, engine] = logs;
    const seconds = ({ seconds, nanos }) => Number(seconds ?? 0) + (nanos ?? 0) * 1e-9;
    let compared = 0;
    for (const { transforms } of engine["/tf"].filter((_, index) => index % 4 === 0)) {
      const stamp = seconds(transforms[0].timestamp);
      // Stamps are rounded to nanoseconds, so two samples may share one.
      const [sample, another] = engine.states.filter(({ timestamp }) => Math.abs(timestamp - stamp) < 0.6e-9);
      if (another) continue;
      await call("seek", sample.timestamp);
      const { bodies } = (await state()).runs[1];
      for (const { parent_frame_id, child_frame_id, translation, rotation } of transforms) {
        assert.equal(parent_frame_id, "world");
        const drawn = bodies.find((body) => body.name === child_frame_id);
        assert.deepEqual([drawn.x_m, drawn.y_m], [translation?.x ?? 0, translation?.y ?? 0]);
        const half = 0.5 * drawn.angle_rad;
        assert.ok(Math.abs(Math.sin(half) * (rotation.w ?? 0) - Math.cos(half) * (rotation.z ?? 0)) < 1e-15, child_frame_id);
        compared++;
      }
    }
    assert.ok(compared > 20, `${compared} frames`);
    await close();
  });

  it("shows the values at the cursor with their units", async () => {
    const { page, call, state, close } = await opened(file);
    const engine = logs[1];
    const peakTime = engine["/contact/distal"].reduce((best, each) => (each.normal_n > best.normal_n ? each : best)).timestamp;
    for (const time of [engine.states[100].timestamp, peakTime, engine.states.at(-1).timestamp]) {
      await call("seek", time);
      await state();
      const forces = await readPlotTable(page, "Normal force");
      const gaps = await readPlotTable(page, "Gap");
      for (const name of ["proximal", "distal"]) {
        const logged = at(engine[`/contact/${name}`], time);
        near(parseQuantity(forces[name][1]), logged.normal_n, 1e-4, `force, ${forces[name]}`);
        near(parseQuantity(gaps[name][1]), logged.gap_m, 1e-4, `gap, ${gaps[name]}`);
      }
      near(parseQuantity((await readPlotTable(page, "Joint angle")).q21[1]), at(engine.states, time).q21_rad, 1e-4, "q21");
    }
    await close();
  });

  it("interpolates with values and rates between two samples", async () => {
    const { call, state, close } = await opened(file);
    const samples = logs[1].states;
    const bendAt = (k) => (samples[k + 1].timestamp - samples[k].timestamp) / 8 * (samples[k].qd11_rad_s - samples[k + 1].qd11_rad_s);
    const swing = samples.filter(({ timestamp }) => timestamp < 4e-3).length - 1;
    const [k, bend] = Array.from({ length: swing }, (_, k) => [k, bendAt(k)]).reduce((most, each) => (Math.abs(each[1]) > Math.abs(most[1]) ? each : most));
    const [a, b] = [samples[k], samples[k + 1]];
    await call("seek", 0.5 * (a.timestamp + b.timestamp));
    const { bodies, readings } = (await state()).runs[1];
    const halfway = 0.5 * (a.q11_rad + b.q11_rad) + bend;
    assert.ok(Math.abs(bend) > 1e-6, `a straight line would be noticeable: ${bend}`);
    near(bodies.find((body) => body.name === "l11").angle_rad, halfway, 1e-13, "halfway");
    near(readings["Joint angle"].q11, halfway, 1e-13, "the curve halfway");
    near(readings["Energy"].kinetic, 0.5 * (logs[1]["/energy"][k].kinetic_j + logs[1]["/energy"][k + 1].kinetic_j), 1e-13, "no rate: a straight line");
    // The length of a link is constant.
    const arm = (name) => bodies.find((body) => body.name === name);
    const [start, end] = [Math.hypot(arm("l12").x_m, arm("l12").y_m), Math.hypot(arm("l22").x_m, arm("l22").y_m)];
    near(start, 15e-3, 1e-6, "l11");
    near(end, 24.4324e-3, 1e-5, "l21");
    await close();
  });

  it("shows no spurious difference between the models before a touch-down", async () => {
    const { page, call, state, close } = await opened(file, { width: 1400 });
    const touch = touchDown(logs[0], "distal");
    // Gaps from a millimetre down to ten micrometres, between the samples of either model.
    for (let gap = 1e-3; gap > 1e-5; gap /= 1.3) {
      await call("seek", touch.timestamp - gap / touch.approach_speed_m_s);
      const [analytic, engine] = (await state()).runs.map((run) => run.readings.Gap.distal);
      near(engine, analytic, 0.01, `gap of about ${gap}`);
      near(analytic, gap, 0.2, "gap");
    }
    // The drawn curves of both models are also equal, per column of pixels.
    const from = touch.timestamp - 4e-4;
    await call("setWindow", from, touch.timestamp + 1e-4);
    await call("seek", from);
    await page.locator('.plot[aria-label="Gap"] button.series', { hasText: "proximal" }).click();
    const drawn = async (index) => {
      await call("show", 1 - index, false);
      await call("show", index, true);
      await state();
      return page.evaluate(() => {
        const canvas = document.querySelector('.plot[aria-label="Gap"] canvas');
        const { width, height } = canvas;
        const copy = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d", { willReadFrequently: true });
        copy.drawImage(canvas, 0, 0);
        const { data } = copy.getImageData(0, 0, width, height);
        const rows = [];
        for (let x = 66; x < width - 12; x++) {
          let [sum, count] = [0, 0];
          for (let y = 0; y < height - 24; y++) {
            const k = 4 * (y * width + x);
            if (data[k + 3] > 40 && Math.max(...data.slice(k, k + 3)) - Math.min(...data.slice(k, k + 3)) > 60) [sum, count] = [sum + y, count + 1];
          }
          rows.push(count ? sum / count : null);
        }
        return { rows, height };
      });
    };
    const [analytic, engine] = [await drawn(0), await drawn(1)];
    const edge = Math.floor(0.78 * analytic.rows.length);
    let compared = 0;
    for (let x = 0; x < edge; x++) {
      // The curve of the second model is dashed.
      if (analytic.rows[x] === null || engine.rows[x] === null) continue;
      compared++;
      assert.ok(Math.abs(analytic.rows[x] - engine.rows[x]) < 4, `${engine.rows[x]}, not ${analytic.rows[x]}, at ${x} of ${edge}`);
    }
    assert.ok(compared > edge / 3, `${compared} columns`);
    await close();
  });

  it("shows the symbols of the linkage on hover, without overlap", async () => {
    const names = ["l11", "l12", "l21", "l22", "t22", "w", "base", "q11", "q12", "q21", "q22", "φ22"];
    for (const width of [1400, 390]) {
      const { page, call, state, close } = await opened(file, { width, height: 844 });
      assert.deepEqual((await state()).symbols, []);
      const stage = await page.locator("#stage").boundingBox();
      // No symbols over the background; all symbols over the end of the proximal phalanx.
      await page.mouse.move(stage.x + 20, stage.y + 60);
      assert.deepEqual((await state()).symbols, []);
      const { bodies, view } = await state().then(({ runs, view }) => ({ bodies: runs[0].bodies, view }));
      const tip = bodies.find((body) => body.name === "l22");
      const at = [0, 1].map((k) => (k ? -1 : 1) * ([tip.x_m, tip.y_m][k] - view.centre_m[k]) * view.px_per_m);
      await page.mouse.move(stage.x + stage.width / 2 + at[0], stage.y + stage.height / 2 + at[1]);
      assert.deepEqual((await state()).symbols.map((symbol) => symbol.text).sort(), [...names].sort());
      await page.mouse.move(stage.x + 20, stage.y + 60);
      assert.deepEqual((await state()).symbols, []);
      await page.keyboard.press("l");
      for (const time of [0, 2e-3, 4.4e-3, 4.501316e-3, 5.5e-3, 6.8e-3, 0.02]) {
        await call("seek", time);
        const { symbols } = await state();
        for (const name of names) assert.ok(symbols.some((symbol) => symbol.text === name), `${name} at ${time}`);
        if (time === 0.02) assert.deepEqual(symbols.filter(({ text }) => text.startsWith("F")).map(({ text }) => text), ["F21 23.6 N", "F22 8.26 N"]);
        for (const [k, symbol] of symbols.entries()) {
          assert.ok(symbol.box[0] >= 0 && symbol.box[1] >= 0 && symbol.box[2] <= stage.width && symbol.box[3] <= stage.height, symbol.text);
          for (const other of symbols.slice(k + 1)) {
            const isSeparate = symbol.box[2] <= other.box[0] || other.box[2] <= symbol.box[0] || symbol.box[3] <= other.box[1] || other.box[3] <= symbol.box[1];
            assert.ok(isSeparate, `${symbol.text} overlaps ${other.text} at ${time}, ${width} pixels`);
          }
        }
      }
      await page.locator("#symbols").click();
      await page.mouse.move(stage.x + 20, stage.y + 60);
      assert.deepEqual((await state()).symbols, []);
      await close();
    }
  });

  it("saves samples and pictures, and links to an instant", async () => {
    const touch = touchDown(logs[1], "distal").timestamp;
    const { page, call, state, close } = await opened(file, { hash: "#t=4.25ms" });
    near((await state()).time_s, 4.25e-3, 1e-12, "the instant of the link");
    await call("seek", touch);
    await page.waitForFunction((time) => location.hash === `#t=${time}`, touch);
    const saved = async (kind) => {
      const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#save").selectOption(kind)]);
      assert.equal(download.suggestedFilename(), `experiment-95.${kind}`);
      return readFileSync(await download.path());
    };
    const [head, ...lines] = (await saved("csv")).toString().trim().split("\n");
    const names = head.split(",").map((name) => name.slice(1, -1));
    const engine = lines.map((line) => line.split(",")).filter((line) => line[0] === '"engine"');
    const states = logs[1].states;
    assert.equal(engine.length, states.length);
    const [time, q22, gap] = ["time_s", "Joint angle: q22 (rad)", "Gap: distal (m)"].map((name) => names.indexOf(name));
    states.forEach((logged, index) => {
      assert.equal(Number(engine[index][time]), logged.timestamp);
      assert.equal(Number(engine[index][q22]), logged.q22_rad);
    });
    assert.equal(Number(engine.at(-1)[gap]), logs[1]["/contact/distal"].at(-1).gap_m);
    const svg = (await saved("svg")).toString();
    const found = await page.evaluate((text) => {
      const document = new DOMParser().parseFromString(text, "image/svg+xml");
      return { error: document.querySelector("parsererror")?.textContent, paths: document.querySelectorAll("path").length, texts: [...document.querySelectorAll("text")].map((each) => each.textContent) };
    }, svg);
    assert.equal(found.error, undefined);
    assert.ok(found.paths > 60 && !svg.includes("NaN"), `${found.paths} paths`);
    for (const text of ["Normal force ", "Gap ", "proximal", "q22", "20 mm"]) assert.ok(found.texts.includes(text), `${text} in ${found.texts}`);
    writeFileSync(path.join(SCREENSHOTS, "saved.svg"), svg);
    const png = await saved("png");
    assert.deepEqual([...png.subarray(1, 4)], [..."PNG"].map((char) => char.charCodeAt(0)));
    assert.ok(png.readUInt32BE(16) > 800 && png.length > 40_000, `${png.readUInt32BE(16)} wide, ${png.length} bytes`);
    writeFileSync(path.join(SCREENSHOTS, "saved.png"), png);
    await close();
  });

  it("saves the animation as a GIF", async () => {
    const { page, call, state, close } = await opened(file);
    const saved = async () => {
      const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#save").selectOption("gif")]);
      assert.equal(download.suggestedFilename(), "experiment-95.gif");
      await page.waitForFunction(() => !document.getElementById("save").disabled);
      assert.equal(await page.locator("#save option").first().textContent(), "Save…");
      return readFileSync(await download.path());
    };
    const length = ({ frames }) => frames.reduce((sum, frame) => sum + frame.delay_s, 0);
    // One millisecond at a millisecond per second, 25 frames per second; the last frame lasts longer.
    await call("setSpeed", 1e-3);
    await call("setWindow", 4e-3, 5e-3);
    await call("seek", 4.2e-3);
    const short = gif(await saved());
    assert.equal(short.frames.length, 26);
    near(length(short), 25 * 0.04 + 1.5, 1e-9, "seconds");
    assert.equal((await state()).time_s, 4.2e-3, "the cursor is unchanged");
    // The whole run with the automatic speed.
    await call("setAuto", true);
    await call("setWindow", 0, 1);
    const bytes = await saved();
    const whole = gif(bytes);
    assert.ok(whole.loops && bytes.length < 3e6, `${bytes.length} bytes`);
    assert.ok(whole.frames.length > 250 && whole.frames.length <= 500, `${whole.frames.length} frames`);
    assert.ok(length(whole) > 12, `${length(whole)} s`);
    // Most frames contain only the changed pixels.
    const [first, ...rest] = whole.frames.map((frame) => frame.pixels);
    assert.equal(first, whole.width * whole.height);
    assert.ok(rest.reduce((sum, pixels) => sum + pixels, 0) < 0.5 * rest.length * first);
    writeFileSync(path.join(SCREENSHOTS, "saved.gif"), bytes);
    // The last frame equals the page, below a caption with the time.
    await page.keyboard.press("End");
    await state();
    const shown = await page.evaluate(() => {
      const canvas = document.getElementById("stage");
      const ctx = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height }).getContext("2d");
      ctx.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--panel");
      ctx.fillRect(0, 0, canvas.width, canvas.height);
      ctx.drawImage(canvas, 0, 0);
      return { width: canvas.width, height: canvas.height, data: [...ctx.getImageData(0, 0, canvas.width, canvas.height).data] };
    });
    const caption = whole.height - shown.height;
    assert.ok(whole.width === shown.width && caption > 0 && caption < 40, `${shown.width} × ${shown.height}`);
    let [near32, colours] = [0, new Set()];
    for (let y = 0; y < shown.height; y++) {
      for (let x = 0; x < shown.width; x++) {
        const pixel = whole.pixel(x, y + caption);
        const k = 4 * (y * shown.width + x);
        if (pixel.every((value, c) => Math.abs(value - shown.data[k + c]) < 32)) near32++;
        colours.add(pixel.join());
      }
    }
    const share = near32 / (shown.width * shown.height);
    assert.ok(share > 0.995 && colours.size > 30, `${share} of all pixels, ${colours.size} colours`);
    await close();
  });

  it("plays at the selected speed, and stops at the end", async () => {
    const { page, call, state, close } = await opened(file);
    for (const speed of [1e-5, 2e-3]) {
      await call("setSpeed", speed);
      await call("seek", 1e-3);
      const passed = await page.evaluate(async () => {
        const frame = () => new Promise(requestAnimationFrame);
        window.phalanx.play();
        await frame();
        const [time, now] = [window.phalanx.state().time_s, await frame()];
        let last = now;
        while (last - now < 600) last = await frame();
        window.phalanx.pause();
        return { time: window.phalanx.state().time_s - time, wall: (last - now) / 1000 };
      });
      near(passed.time / passed.wall, speed, 0.2, "speed");
    }
    await call("setSpeed", 1);
    await call("play");
    await page.waitForFunction(() => !window.phalanx.state().playing);
    assert.equal((await state()).time_s, (await page.evaluate(() => window.phalanx.span_s))[1]);
    await close();
  });

  it("slows down at impacts automatically, to 1e-5", async () => {
    const { call, state, close } = await opened(file);
    await call("setAuto", true);
    const touch = touchDown(logs[1], "proximal").timestamp;
    const speedAt = async (time) => {
      await call("seek", time);
      return (await state()).speed;
    };
    assert.ok(await speedAt(1e-3) > 1e-3);
    assert.ok(await speedAt(touch - 1e-4) < 5e-4);
    near(await speedAt(touch), 1e-5, 1e-9, "slowest");
    assert.ok(await speedAt(12e-3) > 1e-3);
    await close();
  });

  it("can be operated by keyboard, with visible focus", async () => {
    const { page, state, close } = await opened(file);
    const [start, end] = await page.evaluate(() => window.phalanx.span_s);
    const press = async (key) => {
      await page.keyboard.press(key);
      return state();
    };
    const both = [...new Set(logs.flatMap((log) => log.states.map((each) => each.timestamp)))].sort((a, b) => a - b);
    assert.ok(both.includes((await press("ArrowRight")).time_s));
    assert.equal((await press("ArrowLeft")).time_s, start);
    const events = logs.flatMap((log) => log["/event"].map((each) => each.timestamp));
    const after = [...new Set(events)].filter((time) => time > start).sort((a, b) => a - b);
    for (const time of after) assert.equal((await press("n")).time_s, time);
    assert.equal((await press("p")).time_s, after.at(-2));
    assert.equal((await press("End")).time_s, end);
    assert.equal((await press("Home")).time_s, start);
    assert.equal((await press("Space")).playing, true);
    assert.equal((await press("Space")).playing, false);
    assert.equal((await press("s")).auto, false);
    const slow = (await press("-")).speed;
    assert.ok((await press("+")).speed > slow);
    assert.equal((await press("2")).runs.length, 1);
    assert.equal((await press("2")).runs.length, 2);
    assert.equal((await press("c")).view.follow, "proximal");
    assert.equal((await press("0")).view.follow, null);
    const whole = (await press("a")).window_s;
    const near = (await press("z")).window_s;
    assert.ok(near[1] - near[0] < 0.6 * (whole[1] - whole[0]));
    await page.keyboard.press("?");
    assert.ok(await page.locator("#help").isVisible());
    await page.keyboard.press("Escape");
    assert.ok(!(await page.locator("#help").isVisible()));
    // Every control can be reached with Tab, has a name and shows the focus.
    const seen = new Set();
    for (let k = 0; k < 80; k++) {
      await page.keyboard.press("Tab");
      const focus = await page.evaluate(() => {
        const element = document.activeElement;
        const { outlineStyle, outlineWidth } = getComputedStyle(element);
        const named = element.getAttribute("aria-label") || element.labels?.[0]?.textContent || element.textContent;
        return { id: element.id, tag: element.tagName, outline: outlineStyle !== "none" && parseFloat(outlineWidth) >= 2, named: Boolean(named?.trim()) };
      });
      if (focus.tag === "BODY") break;
      assert.ok(focus.outline && focus.named, JSON.stringify(focus));
      seen.add(focus.id);
    }
    for (const id of ["play", "previous", "next", "backward", "forward", "scrub", "speed", "auto", "follow", "zoom-in", "symbols", "save", "theme", "help-open", "window-event"]) {
      assert.ok(seen.has(id), `${id} is not reached with Tab`);
    }
    await close();
  });

  it("can be operated by mouse: slider, plots, bar, list, zoom", async () => {
    const { page, call, state, close } = await opened(file);
    const [start, end] = await page.evaluate(() => window.phalanx.span_s);
    const click = async (selector, part) => {
      const box = await page.locator(selector).first().boundingBox();
      await page.mouse.click(box.x + part * box.width, box.y + box.height / 2);
      return ((await state()).time_s - start) / (end - start);
    };
    near(await click("#scrub", 0.5), 0.5, 0.03, "slider");
    near(await click("#overview", 0.25), 0.25, 0.05, "bar");
    assert.ok(await click(".plot canvas", 0.9) > 0.8, "plot");
    const box = await page.locator(".plot canvas").first().boundingBox();
    await page.mouse.move(box.x + 0.9 * box.width, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.5 * box.width, box.y + 30, { steps: 4 });
    await page.mouse.up();
    const dragged = ((await state()).time_s - start) / (end - start);
    assert.ok(dragged > 0.3 && dragged < 0.6, `${dragged}`);
    const touch = touchDown(logs[0], "distal").timestamp;
    await page.locator(".event", { hasText: "distal" }).first().click();
    assert.ok(Math.abs((await state()).time_s - touch) < 1e-7);
    await page.locator("#window-event").click();
    const [from, to] = (await state()).window_s;
    assert.ok(to - from < 1e-4 && from < touch && touch < to, "a window of microseconds");
    await page.locator("#follow").selectOption("distal");
    const { view, runs } = await state();
    assert.ok(view.px_per_m > 1e6, "micrometres are visible");
    const { point_m } = runs[0].contacts.find((contact) => contact.name === "distal");
    assert.ok(Math.hypot(view.centre_m[0] - point_m[0], view.centre_m[1] - point_m[1]) < 1e-5);
    const stage = await page.locator("#stage").boundingBox();
    await call("fit");
    const before = (await state()).view.px_per_m;
    await page.mouse.move(stage.x + 100, stage.y + 200);
    await page.mouse.wheel(0, -300);
    await page.waitForFunction((before) => window.phalanx.state().view.px_per_m > 1.5 * before, before);
    await close();
  });

  it("shows a peak that is a thousandth of a pixel wide", async () => {
    const { page, state, close } = await opened(file);
    await state();
    // The impacts last 2 of 20,000 µs; their peaks must be visible at the top of the plot of forces.
    const inked = await page.evaluate(() => {
      const canvas = document.querySelector(".plot canvas");
      const { data } = canvas.getContext("2d").getImageData(62, 8, canvas.width - 72, 24);
      let count = 0;
      for (let k = 0; k < data.length; k += 4) if (data[k + 3] > 60 && Math.max(...data.slice(k, k + 3)) - Math.min(...data.slice(k, k + 3)) > 60) count++;
      return count;
    });
    assert.ok(inked > 20, `${inked} pixels`);
    await close();
  });

  for (const [width, height] of [[390, 844], [1280, 800]]) {
    for (const scheme of ["light", "dark"]) {
      it(`is readable at ${width} pixels in ${scheme} colours`, async () => {
        const { page, call, state, close } = await opened(file, { width, height, scheme, deviceScaleFactor: width < 500 ? 2 : 1, hasTouch: width < 500 });
        const shot = async (name) => {
          await state();
          await page.screenshot({ path: path.join(SCREENSHOTS, `${width}-${scheme}-${name}.png`) });
        };
        await shot("start");
        const peakTime = logs[1]["/contact/proximal"].reduce((best, each) => (each.normal_n > best.normal_n ? each : best)).timestamp;
        await call("seek", peakTime);
        await shot("impact");
        await page.keyboard.press("e");
        await call("follow", "proximal");
        await call("seek", peakTime);
        await shot("contact");
        await call("fit");
        await page.keyboard.press("a");
        await page.keyboard.press("End");
        await shot("end");
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
            if (!node.textContent.trim() || !element.checkVisibility() || element.closest("script, dialog, noscript, button:disabled, .skip")) continue;
            const style = getComputedStyle(element);
            const ink = rgb(element.closest("svg") ? style.fill : style.color);
            const [a, b] = [luminance(ink), luminance(ground(element))].sort((x, y) => y - x);
            if ((a + 0.05) / (b + 0.05) < 4.5) poor.push(`${node.textContent.trim().slice(0, 40)}: ${style.color}`);
          }
          const small = [...document.querySelectorAll(".transport button, .window button")].filter((each) => each.offsetHeight < 32 || each.offsetWidth < 32);
          const inView = (id) => {
            const { top, bottom } = document.getElementById(id).getBoundingClientRect();
            return top >= 0 && bottom <= innerHeight;
          };
          return {
            poor,
            small: small.length,
            wide: document.documentElement.scrollWidth - innerWidth,
            ground: luminance(rgb(getComputedStyle(document.body).backgroundColor)),
            preformatted: document.querySelectorAll("pre").length,
            tables: [...document.querySelectorAll(".text .grid")].map((box) => {
              const { left, right } = box.getBoundingClientRect();
              const figures = [...box.querySelectorAll("td")].filter((cell) => cell.scrollWidth > cell.clientWidth + 1 || cell.textContent.includes("  "));
              const last = box.querySelector("thead th:last-child");
              return { within: left >= 0 && right <= innerWidth, difference: last?.textContent.startsWith("difference") ? last.getBoundingClientRect().right - right : null, scrolls: box.scrollWidth > box.clientWidth, rows: box.querySelectorAll("tr").length, poor: figures.length };
            }),
            together: ["stage", "play", "scrub", "speed"].every(inView),
            cut: [...document.querySelectorAll(".plot td, .now, .ends span, .speed output")].filter((each) => each.scrollWidth > each.clientWidth + 1).map((each) => each.textContent),
          };
        });
        assert.deepEqual(found.poor, [], "contrast below 4.5");
        assert.equal(found.small, 0);
        assert.ok(found.wide <= 0, `${found.wide} pixels too wide`);
        assert.ok(scheme === "dark" ? found.ground < 0.05 : found.ground > 0.8);
        assert.equal(found.preformatted, 0, "reports are tables");
        assert.ok(found.tables.length >= 8 && found.tables.every((table) => table.within && table.rows > 1 && table.poor === 0), JSON.stringify(found.tables));
        const differences = found.tables.map(({ difference }) => difference).filter((beyond) => beyond !== null);
        assert.ok(differences.length >= 2 && differences.every((beyond) => beyond <= 0), `the column of differences is not in view: ${differences}`);
        // Wide tables scroll within their box on a phone.
        if (width === 390) {
          assert.ok(found.tables.some((table) => table.scrolls));
          const box = page.locator(".text .grid").last();
          await box.scrollIntoViewIfNeeded();
          await shot("table");
          await box.focus();
          await page.keyboard.press("ArrowRight");
          await page.waitForFunction((box) => box.scrollLeft > 0, await box.elementHandle());
        }
        assert.ok(found.together, "animation and controls are visible together");
        assert.deepEqual(found.cut, [], "texts that are cut off");
        await page.keyboard.press("?");
        await shot("help");
        await page.keyboard.press("Escape");
        await page.locator(".picture").scrollIntoViewIfNeeded();
        await shot("picture");
        await close();
      });
    }
  }

  it("allows no network access", async () => {
    const { page, problems } = await opened(file);
    const blocked = await page.evaluate(async () => {
      const violated = new Promise((resolve) => addEventListener("securitypolicyviolation", (event) => resolve(event.effectiveDirective), { once: true }));
      await fetch("https://example.org/").catch(() => {});
      return violated;
    });
    assert.equal(blocked, "connect-src");
    const ran = await page.evaluate(() => {
      document.body.insertAdjacentHTML("beforeend", '<img src="data:," onerror="window.hacked = 1">');
      const script = document.createElement("script");
      script.textContent = "window.hacked = 2";
      document.body.append(script);
      return new Promise((resolve) => setTimeout(() => resolve(window.hacked ?? null), 200));
    });
    assert.equal(ran, null, "only the page's own scripts run");
    assert.ok(!problems.some((text) => text.startsWith("https://example.org")), "no request went out");
    await page.context().close();
  });
});

describe("the page of a run without samples", () => {
  it("shows a warning and its texts", async () => {
    const out = path.join(DIRECTORY, "closing", "page.html");
    const file = path.join(DIRECTORY, "empty.html");
    writeFileSync(file, readFileSync(out, "utf8").replace(/(id="data">).*?(<\/script>)/s, '$1{"runs":[]}$2'));
    const { page, close } = await opened(file, { scheme: "dark" });
    assert.ok(await page.locator("#warning").isVisible());
    assert.ok(!(await page.locator("#playback").isVisible()));
    assert.ok(await page.locator(".text table").first().isVisible());
    await close();
  });
});

describe("the page of discs with a hostile name", () => {
  it("draws the log, and escapes the name", async () => {
    const name = "</script><script>window.hacked=1</script>";
    const text = readFileSync(path.join(PROJECT, "scenes/laws/two-free.toml"), "utf8");
    const scene = path.join(DIRECTORY, "hostile.toml");
    const description = '"><img src=x onerror=window.hacked=2> {{data}} &amp;';
    writeFileSync(scene, text.replace(/^name = .*$/m, `name = '${name}'\ndescription = '${description}'`));
    const out = validate(scene, "hostile");
    const { page, call, state, close } = await opened(path.join(out, "page.html"), { width: 390, height: 844 });
    assert.equal(await page.title(), name);
    assert.equal(await page.locator("h1").textContent(), name);
    assert.equal(await page.locator(".description").textContent(), description);
    assert.equal(await page.evaluate(() => window.hacked ?? null), null);
    const log = messages(path.join(out, "engine.mcap"));
    const discs = Object.keys(log).filter((topic) => topic.startsWith("/body/"));
    assert.equal(discs.length, 2);
    const times = log[discs[0]].map((message) => message.timestamp);
    for (const time of times.filter((_, index) => index % 50 === 0)) {
      await call("seek", time);
      const { bodies } = (await state()).runs[1];
      for (const topic of discs) {
        const drawn = bodies.find((body) => `/body/${body.name}` === topic);
        const logged = at(log[topic], time);
        assert.deepEqual([drawn.x_m, drawn.y_m, drawn.angle_rad], [logged.x_m, logged.y_m, logged.angle_rad]);
      }
    }
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
    await page.screenshot({ path: path.join(SCREENSHOTS, "discs-390-light.png") });
    await close();
  });
});

describe("the page of a gripper that lifts a box", () => {
  let file;
  before(() => {
    file = path.join(DIRECTORY, "lift.html");
    execFileSync(PHALANX, ["run", path.join(PROJECT, "scenes/real/2f85-lift.toml"), "--plot", file], { stdio: ["ignore", "ignore", "inherit"] });
  });

  it("shows one contact for each pair of outlines, and gravity points down", async () => {
    const { page, call, state, close } = await opened(file);
    const [, end] = await page.evaluate(() => window.phalanx.span_s);
    await call("seek", end);
    const { runs: [{ contacts, arrows, readings }], labels, view } = await state();
    assert.deepEqual(contacts.map(({ name }) => name), ["left_follower / object", "right_follower / object", "object / ground.table"]);
    // Forces act on the pads: outwards.
    for (const [contact, sign] of [["left_follower / object", -1], ["right_follower / object", 1]]) {
      const arrow = arrows.find((each) => each.contact === contact && each.kind === "normal");
      near(arrow.force_n, 46, 0.02, contact);
      assert.ok(sign * arrow.direction[0] > 0.99, `${arrow.direction}`);
      assert.equal(readings["Normal force"][contact], arrow.force_n);
    }
    for (const [index, label] of labels.entries()) {
      const overlaps = (other) => Math.abs(other.x - label.x) < other.halfWidth + label.halfWidth && Math.abs(other.y - label.y) < 15;
      assert.ok(!labels.slice(index + 1).some(overlaps), label.text);
    }
    assert.equal(labels.length, arrows.length);
    // The table is below, although it is at a larger y.
    const colourAt = (part) => page.evaluate((part) => {
      const canvas = document.getElementById("stage");
      const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height }).getContext("2d", { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      return [...copy.getImageData(canvas.width / 2, Math.round(part * canvas.height), 1, 1).data];
    }, part);
    assert.ok(view.turned);
    const [above, below] = [await colourAt(0.02), await colourAt(0.98)];
    await page.keyboard.press("t");
    assert.ok(!(await state()).view.turned);
    assert.deepEqual([await colourAt(0.98), await colourAt(0.02)], [above, below]);
    assert.ok(above[3] === 0 && below[3] === 255, `${above}, ${below}`);
    await close();
  });

  for (const width of [390, 1280]) {
    it(`distinguishes all curves, with whole names, at ${width} pixels`, async () => {
      const { page, state, close } = await opened(file, { width, height: 844 });
      await state();
      const plots = await page.evaluate(() =>
        [...document.querySelectorAll(".plot")].map((plot) => ({
          title: plot.getAttribute("aria-label"),
          strokes: [...plot.querySelectorAll(".series path")].map((line) => line.getAttribute("stroke") + line.getAttribute("stroke-dasharray")),
          broken: [...plot.querySelectorAll(".series span")].filter((name) => name.getClientRects().length > 1 || name.offsetHeight > 20).map((name) => name.textContent),
          share: plot.querySelector("canvas").clientWidth / plot.clientWidth,
          height: plot.querySelector("canvas").clientHeight,
        })));
      assert.ok(plots.some(({ strokes }) => strokes.length > 7));
      for (const { title, strokes, broken, share, height } of plots) {
        assert.equal(new Set(strokes).size, strokes.length, `${title}: ${strokes}`);
        assert.deepEqual(broken, [], title);
        assert.ok(share > (width > 390 ? 0.5 : 0.9) && height >= 140, `${title}: ${share}, ${height}`);
      }
      await page.screenshot({ path: path.join(SCREENSHOTS, `${width}-lift.png`), fullPage: true });
      await close();
    });
  }
});
