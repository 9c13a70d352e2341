// The explorer's module answers with the program's digits: every column of every scene that its page brings along, and of some that
// are set otherwise; and it says what is wrong with a scene as the program does.

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

/** What the module answers: `{ answer, data }`. */
function asked(request) {
  const bytes = new TextEncoder().encode(JSON.stringify(request));
  const room = exports.room(bytes.length) >>> 0;
  new Uint8Array(exports.memory.buffer, room, bytes.length).set(bytes);
  const pointer = exports.answer(bytes.length) >>> 0;
  const { buffer } = exports.memory;
  const [text, length, data, numbers] = new Uint32Array(buffer, pointer, 4);
  const said = new TextDecoder().decode(new Uint8Array(buffer, text, length));
  return { answer: JSON.parse(said), data: new Float64Array(buffer.slice(data, data + 8 * numbers)) };
}

/** The scenes of the page, as the program puts them there. */
function presets() {
  const page = path.join(DIRECTORY, "page.html");
  phalanx("explore", "--module", EXPLORER, "--out", page);
  const [, data] = readFileSync(page, "utf8").match(/<script type="application\/json" id="explorer">(.*?)<\/script>/s);
  return JSON.parse(data).presets;
}
const PRESETS = presets();

/** The samples of a scene as the program logs them. */
function logged(file, set) {
  const [log, table] = ["run.mcap", "run.csv"].map((name) => path.join(DIRECTORY, name));
  rmSync(log, { force: true });
  rmSync(table, { force: true });
  try {
    phalanx("run", path.join(SCENES, file), ...set.flatMap(([field, value]) => ["--set", `${field}=${value}`]), "--no-check", "--log", log);
  } catch (error) {
    // A run that broke off has a log up to there.
    assert.equal(error.status, 3, `${file}: ${error}`);
  }
  phalanx("replay", log, "--csv", table);
  return readFileSync(table, "utf8");
}

function same(preset, set) {
  const scene = { file: preset.file, text: preset.text };
  const { answer } = asked({ ask: "csv", scene, set });
  const [there, here] = [answer.text, logged(preset.file, set)];
  assert.ok(here.length > 1000, preset.file);
  if (there === here) return;
  const [a, b] = [there.split("\n"), here.split("\n")];
  const line = a.findIndex((each, index) => each !== b[index]);
  const cells = a[line].split(",");
  const cell = cells.findIndex((each, index) => each !== b[line]?.split(",")[index]);
  assert.fail(`${preset.file}, sample ${line}, ${a[0].split(",")[cell]}: ${cells[cell]} there, ${b[line]?.split(",")[cell]} here`);
}

describe("every column, to the last digit", () => {
  it("asks the browser for nothing", () => assert.deepEqual(WebAssembly.Module.imports(module), []));
  for (const preset of PRESETS) it(preset.file, () => same(preset, []));

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
  for (const [preset, set] of others) it(`${preset.file} with ${set.map((pair) => pair.join(" = ")).join(", ")}`, () => same(preset, set));
});

/** The texts of a picture, in order. */
const texts = (svg) => [...svg.matchAll(/<text[^>]*>([^<]*)/g)].map(([, text]) => text);

describe("what it answers", () => {
  const preset = PRESETS[0];
  const scene = { file: preset.file, text: preset.text };
  const said = JSON.parse(phalanx("run", path.join(SCENES, preset.file), "--json"));

  it("has the figures of the program's document", () => {
    const { answer } = asked({ ask: "run", scene });
    const numbers = answer.figures.filter(({ value }) => value !== null);
    assert.ok(numbers.length > 30);
    for (const { key, value } of numbers) assert.equal(value, key.split(".").reduce((at, part) => at[part], said), key);
    assert.equal(answer.figures[0].text, said.criteria.class);
    assert.equal(answer.verdict, `${said.criteria.class}: ${said.criteria.class_reason}`);
    assert.ok(answer.figures.every(({ key }) => key !== "criteria.class_reason"));
    assert.equal(answer.steps, said.steps);
  });

  it("checks a run as the program does", () => {
    const { answer } = asked({ ask: "check", scene });
    assert.deepEqual(answer.report, said.check);
  });

  it("has the tables of the grasp at rest, and its picture", () => {
    const { answer } = asked({ ask: "statics", scene });
    const picture = path.join(DIRECTORY, "grasp.svg");
    const words = phalanx("statics", path.join(SCENES, preset.file), "--svg", picture);
    // The page's picture is a column, the program's a sheet with a title: what they say is the same.
    const [title, ...said] = texts(readFileSync(picture, "utf8"));
    assert.match(title, /the grasp at rest/);
    assert.deepEqual(texts(answer.pictures[0].svg), said);
    assert.ok(said.some((text) => text.includes("29.90 N")), said.join("; "));
    const bare = (text) => text.replace(/<[^>]*>|\s|&[a-z0-9#]+;|picture:.*/g, "");
    const of = bare(answer.sections[0].html);
    for (const figure of words.match(/\d+\.\d{2,}/g)) assert.ok(of.includes(figure), figure);
  });

  it("finds for a map what single runs find", () => {
    const fields = ["design.base", "motor.torque"];
    const points = [["14 mm", "400 N*mm"], ["15.5 mm", "480 N*mm"], ["40 mm", "480 N*mm"]];
    const { answer, data } = asked({ ask: "criteria", scene, fields, points });
    const { columns, words, refused } = answer;
    assert.equal(data.length, columns.length * points.length);
    assert.equal(data[columns.length + columns.indexOf("criteria.tts_s")], said.criteria.tts_s);
    assert.equal(words["criteria.class"][1], said.criteria.class);
    const { figures } = asked({ ask: "run", scene, set: fields.map((field, index) => [field, points[0][index]]) }).answer;
    const peak = figures.find(({ key }) => key === "contacts.distal.peak_normal_n").value;
    assert.equal(data[columns.indexOf("contacts.distal.peak_normal_n")], peak);
    assert.deepEqual(refused.slice(0, 2), [null, null]);
  });

  it("writes a scene that the program takes for the same", () => {
    const set = [["design.base", "14.5 mm"]];
    const { answer } = asked({ ask: "toml", scene, set });
    assert.match(answer.text, /^# experiment-95\.toml with design\.base = 14\.5 mm, from the explorer/);
    const again = asked({ ask: "csv", scene: { file: "again.toml", text: answer.text } }).answer.text;
    assert.equal(again, asked({ ask: "csv", scene, set }).answer.text);
  });

  it("lists every field with what it holds", () => {
    const { fields, design } = asked({ ask: "fields", scene }).answer;
    const base = fields.find(({ path: of }) => of === "design.base");
    assert.deepEqual([base.value, base.unit, base.kind, base.given], [15.5, "mm", "quantity", true]);
    assert.ok(design.includes("motor.torque") && design.every((of) => fields.some((field) => field.path === of)));
    const law = fields.find(({ path: of }) => of === "contact.friction.law");
    assert.ok(law.words.includes("bristle"));
    assert.ok(fields.length > 60);
  });

  it("says what is wrong, and of which field", () => {
    const { problems } = asked({ ask: "run", scene, set: [["design.base", "-3 mm"]] }).answer;
    assert.equal(problems[0].field, "design.base");
    assert.ok(problems[0].message.length > 10);
    const broken = asked({ ask: "run", scene: { file: "own.toml", text: "duration = \"20 ms\"\nmoter = 3\n" } }).answer.problems;
    assert.equal(broken.find(({ message }) => message.includes("moter")).line, 2);
    assert.ok(asked({ ask: "nothing", scene }).answer.problems[0].message.includes("nothing"));
  });
});
