// The core in a bare WebAssembly module: nothing of the system is handed to it, and it closes a finger as the program does.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { it } from "node:test";
import { fileURLToPath } from "node:url";

const SCENE = fileURLToPath(new URL("../../scenes/experiment-95.toml", import.meta.url));
// Sines and powers are Rust's own there and the system's here: last digits differ.
const TOLERANCE_RAD = 1e-9;

const module = new WebAssembly.Module(readFileSync(process.env.MODULE));
const imports = WebAssembly.Module.imports(module);

/** Everything that the module would import, refused when it is called. */
function refused() {
  const modules = {};
  for (const { module: from, name } of imports) {
    (modules[from] ??= {})[name] = () => assert.fail(`${name} was called`);
  }
  return modules;
}

it("has no imports but those of microlp's clock", () => {
  // microlp measures how long a linear programme takes, by web-time, and that by wasm-bindgen. A closing solves none.
  assert.deepEqual(imports.filter(({ module: from }) => !from.startsWith("__wbindgen_")), []);
});

for (const model of ["analytic", "engine"]) {
  it(`closes as here: ${model}`, () => {
    const there = new WebAssembly.Instance(module, refused()).exports[`${model}_q11_rad`]();
    const said = execFileSync(process.env.PHALANX, ["run", SCENE, "--model", model, "--json"], { encoding: "utf8" });
    const here = JSON.parse(said).final.q11_rad;
    assert.ok(Math.abs(there - here) <= TOLERANCE_RAD, `${there} in the browser, ${here} here`);
  });
}
