// Runs beside one that is not to be trusted: what other tolerances, and a push that nobody would notice, make of it. Where
// they part, the run is one of many.

const TOLERANCES = ["1e-7", "1e-8", "1e-9"];
// As the check pushes: a part of what drives the gripper.
const PUSHES = [-1e-7, 1e-7, 3e-7];
const DRIVES = ["motor.torque", "spring.torque", "spring.stiffness"];
// Angles between two samples are known no better where a rate jumps.
const LEAST_RAD = 1e-4;
const PART = 0.1;

// What is set on top for each of the runs.
function variations(fields) {
  const drive = DRIVES.map((path) => fields.find((field) => field.path === path)).find((field) => field && isNumeric(field));
  const tight = TOLERANCES.map((rtol) => ["integrator.rtol", rtol]);
  const pushed = drive ? PUSHES.map((push) => [drive.path, asText(drive.value * (1 + push), drive.unit)]) : [];
  return [...tight, ...pushed];
}

// The runs, as the film has them; fewer where some fail, `null` where nobody wants them any more.
async function cloudOf(line, scene, fields, still) {
  const runs = [];
  for (const pair of variations(fields)) {
    const { file, text, set } = scene;
    const heard = await line.ask("cloud", { ask: "run", scene: { file, text }, set: [...set.filter(([path]) => path !== pair[0]), pair] }, 1);
    if (!heard || !still()) return null;
    const { film } = heard.answer;
    if (film) runs.push(runOf(film, 0, film.columns.map(([offset, length]) => heard.data.subarray(offset, offset + length))));
  }
  return runs;
}

// The first time at which a body of any of the runs has turned otherwise by more than a tenth of the error that the check
// found; `null` if they stay together.
function parting(run, cloud, error) {
  const apart = Math.max(PART * error, LEAST_RAD);
  for (let i = 0; i < run.samples; i++) {
    const time = run.time[i];
    for (const other of cloud) {
      const place = placeAt(other, time);
      for (const [k, body] of run.bodies.entries()) {
        if (body.fixed || !other.bodies[k]) continue;
        if (Math.abs(poseAt(other.bodies[k], place).angle_rad - body.angle_rad[i]) > apart) return time;
      }
    }
  }
  return null;
}
