// The explorer's module equals the program exactly: every column of every preset and of some modified scenes. It also
// reports problems of a scene like the program.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import path from "node:path";
import { after, describe, it } from "node:test";
import { fileURLToPath } from "node:url";
import { gunzipSync } from "node:zlib";

const { PHALANX, EXPLORER } = process.env;
const SCENES = fileURLToPath(new URL("../../scenes/", import.meta.url));
const DIRECTORY = mkdtempSync(path.join(tmpdir(), "phalanx-explorer-"));
const phalanx = (...flags) => execFileSync(PHALANX, flags, { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"], maxBuffer: 1 << 28 });

after(() => rmSync(DIRECTORY, { recursive: true }));

const module = new WebAssembly.Module(gunzipSync(readFileSync(EXPLORER)));
const { exports } = new WebAssembly.Instance(module, {});

/** Sends a request to the module; returns `{ response, data }`. */
function send(request) {
  const bytes = new TextEncoder().encode(JSON.stringify(request));
  const requestPointer = exports.alloc(bytes.length) >>> 0;
  new Uint8Array(exports.memory.buffer, requestPointer, bytes.length).set(bytes);
  const pointer = exports.response(bytes.length) >>> 0;
  const { buffer } = exports.memory;
  const [text, length, data, numbers] = new Uint32Array(buffer, pointer, 4);
  const json = new TextDecoder().decode(new Uint8Array(buffer, text, length));
  return { response: JSON.parse(json), data: new Float64Array(buffer.slice(data, data + 8 * numbers)) };
}

/** The presets that the program embeds in the page. */
function presets() {
  const page = path.join(DIRECTORY, "page.html");
  phalanx("explore", "--module", EXPLORER, "--out", page);
  const [, data] = readFileSync(page, "utf8").match(/<script type="application\/json" id="explorer">(.*?)<\/script>/s);
  return JSON.parse(data).presets;
}
const PRESETS = presets();

/** Samples of a scene as CSV, logged by the program. */
function loggedCsv(file, set) {
  const [log, table] = ["run.mcap", "run.csv"].map((name) => path.join(DIRECTORY, name));
  rmSync(log, { force: true });
  rmSync(table, { force: true });
  try {
    phalanx("run", path.join(SCENES, file), ...set.flatMap(([field, value]) => ["--set", `${field}=${value}`]), "--set", "log.joint_forces=true", "--no-check", "--log", log);
  } catch (error) {
    // An aborted run has a log up to its end.
    assert.equal(error.status, 3, `${file}: ${error}`);
  }
  phalanx("replay", log, "--csv", table);
  return readFileSync(table, "utf8");
}

function assertCsvEqual(preset, set) {
  const scene = { file: preset.file, text: preset.text };
  const { response } = send({ ask: "csv", scene, set });
  const [fromModule, fromProgram] = [response.text, loggedCsv(preset.file, set)];
  assert.ok(fromProgram.length > 1000, preset.file);
  if (fromModule === fromProgram) return;
  const [a, b] = [fromModule.split("\n"), fromProgram.split("\n")];
  const line = a.findIndex((each, index) => each !== b[index]);
  const cells = a[line].split(",");
  const cell = cells.findIndex((each, index) => each !== b[line]?.split(",")[index]);
  assert.fail(`${preset.file}, sample ${line}, ${a[0].split(",")[cell]}: ${cells[cell]} from the module, ${b[line]?.split(",")[cell]} from the program`);
}

describe("every column, exactly", () => {
  it("has no imports", () => assert.deepEqual(WebAssembly.Module.imports(module), []));
  for (const preset of PRESETS) it(preset.file, () => assertCsvEqual(preset, []));

  const finger = PRESETS.find(({ file }) => file === "experiment-95.toml");
  const gripper = PRESETS.find(({ file }) => file === "gripper/design-95.toml");
  const others = [
    [finger, [["design.base", "14.25 mm"], ["motor.torque", "900 N*mm"]]],
    [finger, [["contact.stiffness_si", "2e9"], ["contact.exponent", "1.37"], ["contact.friction.mu_static", "0.31"], ["object.radius", "17.3 mm"]]],
    [finger, [["spring.torque", "90 N*mm"], ["design.phi22", "2 rad"]]],
    [finger, [["integrator.preset", "reference"], ["duration", "12.5 ms"]]],
    [gripper, [["object.radius", "18 mm"], ["object.offset", "1.1 mm"]]],
    [gripper, [["motor.torque", "300 N*mm"], ["material.density", "2700 kg/m^3"], ["contact.damping", "0 N*s/m"]]],
  ];
  for (const [preset, set] of others) it(`${preset.file} with ${set.map((pair) => pair.join(" = ")).join(", ")}`, () => assertCsvEqual(preset, set));
});

/** Texts of a picture, in order. */
const texts = (svg) => [...svg.matchAll(/<text[^>]*>([^<]*)/g)].map(([, text]) => text);

describe("responses", () => {
  const preset = PRESETS[0];
  const scene = { file: preset.file, text: preset.text };
  const document = JSON.parse(phalanx("run", path.join(SCENES, preset.file), "--json"));

  it("contain the figures of the program", () => {
    const { response } = send({ ask: "run", scene });
    const numbers = response.figures.filter(({ value }) => value !== null);
    assert.ok(numbers.length > 30);
    for (const { key, value } of numbers) assert.equal(value, key.split(".").reduce((at, part) => at[part], document), key);
    assert.equal(response.figures[0].text, document.criteria.class);
    assert.equal(response.verdict, `${document.criteria.class}: ${document.criteria.class_reason}`);
    assert.ok(response.figures.every(({ key }) => key !== "criteria.class_reason"));
    assert.equal(response.steps, document.steps);
  });

  it("contain the check of the program", () => {
    const { response } = send({ ask: "check", scene });
    assert.deepEqual(response.report, document.check);
  });

  it("contain the statics report and its picture", () => {
    const { response } = send({ ask: "statics", scene });
    const picture = path.join(DIRECTORY, "grasp.svg");
    const printed = phalanx("statics", path.join(SCENES, preset.file), "--plot", picture);
    // The page arranges the picture in a column and the program in a sheet with a title; the texts are equal.
    const [title, ...pictureTexts] = texts(readFileSync(picture, "utf8"));
    assert.match(title, /the grasp at rest/);
    assert.deepEqual(texts(response.pictures[0].svg), pictureTexts);
    assert.ok(pictureTexts.some((text) => text.includes("29.90 N")), pictureTexts.join("; "));
    const withoutMarkup = (text) => text.replace(/<[^>]*>|\s|&[a-z0-9#]+;|picture:.*/g, "");
    const html = withoutMarkup(response.sections[0].html);
    for (const figure of printed.match(/\d+\.\d{2,}/g)) assert.ok(html.includes(figure), figure);
  });

  it("contain the values of single runs for a map", () => {
    const fields = ["design.base", "motor.torque"];
    const points = [["14 mm", "400 N*mm"], ["15.5 mm", "480 N*mm"], ["40 mm", "480 N*mm"]];
    const { response, data } = send({ ask: "criteria", scene, fields, points });
    const { columns, words, refused } = response;
    assert.equal(data.length, columns.length * points.length);
    assert.equal(data[columns.length + columns.indexOf("criteria.tts_s")], document.criteria.tts_s);
    assert.equal(words["criteria.class"][1], document.criteria.class);
    const { figures } = send({ ask: "run", scene, set: fields.map((field, index) => [field, points[0][index]]) }).response;
    const peak = figures.find(({ key }) => key === "contacts.distal.peak_normal_n").value;
    assert.equal(data[columns.indexOf("contacts.distal.peak_normal_n")], peak);
    assert.deepEqual(refused.slice(0, 2), [null, null]);
  });

  it("contain an equivalent scene as TOML", () => {
    const set = [["design.base", "14.5 mm"]];
    const { response } = send({ ask: "toml", scene, set });
    assert.match(response.text, /^# experiment-95\.toml with design\.base = 14\.5 mm, from the explorer/);
    const again = send({ ask: "csv", scene: { file: "again.toml", text: response.text } }).response.text;
    assert.equal(again, send({ ask: "csv", scene, set }).response.text);
  });

  it("list every field with its value", () => {
    const { fields, design } = send({ ask: "fields", scene }).response;
    const base = fields.find(({ path: fieldPath }) => fieldPath === "design.base");
    assert.deepEqual([base.value, base.unit, base.kind, base.given], [15.5, "mm", "quantity", true]);
    assert.ok(design.includes("motor.torque") && design.every((fieldPath) => fields.some((field) => field.path === fieldPath)));
    const law = fields.find(({ path: fieldPath }) => fieldPath === "contact.friction.law");
    assert.ok(law.words.includes("bristle"));
    assert.ok(fields.length > 60);
  });

  it("report problems with their field", () => {
    const { problems } = send({ ask: "run", scene, set: [["design.base", "-3 mm"]] }).response;
    assert.equal(problems[0].field, "design.base");
    assert.ok(problems[0].message.length > 10);
    const broken = send({ ask: "run", scene: { file: "own.toml", text: "duration = \"20 ms\"\nmoter = 3\n" } }).response.problems;
    assert.equal(broken.find(({ message }) => message.includes("moter")).line, 2);
    assert.ok(send({ ask: "nothing", scene }).response.problems[0].message.includes("nothing"));
  });
});
