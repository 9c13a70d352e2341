// The core in the explorer's module, with both models: it has no imports, and simulates closings exactly like the
// program.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { it } from "node:test";
import { fileURLToPath } from "node:url";
import { gunzipSync } from "node:zlib";

const SCENES = ["experiment-95", "gripper/design-95"];
const MODELS = ["analytic", "engine"];

const module = new WebAssembly.Module(gunzipSync(readFileSync(process.env.EXPLORER)));

it("has no imports", () => assert.deepEqual(WebAssembly.Module.imports(module), []));

/** Selects from the output of `phalanx run --json` the figures that the module returns, in its order. */
function figures({ final, fingers = { only: final }, object, contacts }) {
  const bodies = object === undefined ? [] : [object];
  return [
    ...Object.values(fingers).flatMap((f) => [f.q11_rad, f.q21_rad, f.q22_rad, f.qd11_rad_s, f.qd21_rad_s]),
    ...bodies.flatMap((b) => [b.x_m, b.y_m, b.angle_rad, b.vx_m_s, b.vy_m_s, b.spin_rad_s]),
    ...Object.values(contacts).map((c) => c.impulse_n_s ?? c.impulse_n_m_s),
  ];
}

const { figure } = new WebAssembly.Instance(module, {}).exports;

for (const [sceneIndex, scene] of SCENES.entries()) {
  for (const [modelIndex, model] of MODELS.entries()) {
    it(`equals the native program exactly: ${scene}, ${model}`, () => {
      const file = fileURLToPath(new URL(`../../scenes/${scene}.toml`, import.meta.url));
      const output = execFileSync(process.env.PHALANX, ["run", file, "--model", model, "--json"], { encoding: "utf8" });
      const native = figures(JSON.parse(output));
      const fromModule = native.map((_, index) => figure(sceneIndex, modelIndex, index));
      assert.ok(native.length > 6 && native.every(Number.isFinite), `${native}`);
      assert.deepEqual(fromModule, native);
      // The module has no further figures.
      assert.ok(!figure(sceneIndex, modelIndex, native.length), "every figure is compared");
    });
  }
}
