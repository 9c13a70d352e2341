// The core in the explorer's module, with both models: nothing of the system is handed to it, and it closes a finger as the program does.

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

/** What `phalanx run --json` says of the figures that the module gives, in its order. */
function figures({ final, fingers = { only: final }, object, contacts }) {
  const bodies = object === undefined ? [] : [object];
  return [
    ...Object.values(fingers).flatMap((f) => [f.q11_rad, f.q21_rad, f.q22_rad, f.qd11_rad_s, f.qd21_rad_s]),
    ...bodies.flatMap((b) => [b.x_m, b.y_m, b.angle_rad, b.vx_m_s, b.vy_m_s, b.spin_rad_s]),
    ...Object.values(contacts).map((c) => c.impulse_n_s ?? c.impulse_n_m_s),
  ];
}

const { figure } = new WebAssembly.Instance(module, {}).exports;

for (const [s, scene] of SCENES.entries()) {
  for (const [m, model] of MODELS.entries()) {
    it(`closes as here, to the last digit: ${scene}, ${model}`, () => {
      const file = fileURLToPath(new URL(`../../scenes/${scene}.toml`, import.meta.url));
      const said = execFileSync(process.env.PHALANX, ["run", file, "--model", model, "--json"], { encoding: "utf8" });
      const here = figures(JSON.parse(said));
      const there = here.map((_, index) => figure(s, m, index));
      assert.ok(here.length > 6 && here.every(Number.isFinite), `${here}`);
      assert.deepEqual(there, here);
      // A table that is not there has no impulse, and behind it there is no figure.
      assert.ok(!figure(s, m, here.length), "every figure is compared");
    });
  }
}
