// Variations of an unreliable run: other tolerances, and a minute perturbation of the drive. Beyond the time at which
// they diverge, the run is one of many possible runs.

const TOLERANCES = ["1e-7", "1e-8", "1e-9"];
// Relative perturbations of the drive, as in the check.
const PERTURBATIONS = [-1e-7, 1e-7, 3e-7];
const DRIVE_FIELDS = ["motor.torque", "spring.torque", "spring.stiffness"];
const GAIN_OF_ACTUATOR = /^actuators\..*\.kp$/;
// Error of interpolated angles where a rate jumps.
const MIN_ANGLE_RAD = 1e-4;
const ERROR_FRACTION = 0.1;

// The additional setting of each run.
function variations(fields) {
  const driveFields = DRIVE_FIELDS.map((path) => fields.find((field) => field.path === path));
  const driveField = [...driveFields, fields.find(({ path }) => GAIN_OF_ACTUATOR.test(path))].find((field) => field && isNumeric(field));
  const toleranceVariations = TOLERANCES.map((rtol) => ["integrator.rtol", rtol]);
  const perturbedDrives = driveField ? PERTURBATIONS.map((perturbation) => [driveField.path, formatValue(driveField.value * (1 + perturbation), driveField.unit)]) : [];
  return [...toleranceVariations, ...perturbedDrives];
}

// Simulates the variations. Failed runs are omitted; returns `null` if superseded.
async function runVariations(queue, scene, fields, isCurrent) {
  const runs = [];
  for (const variation of variations(fields)) {
    const { file, text, set } = scene;
    const reply = await queue.request("cloud", { ask: "run", scene: { file, text }, set: [...set.filter(([path]) => path !== variation[0]), variation] }, 1);
    if (!reply || !isCurrent()) return null;
    const { playback: rawRun } = reply.response;
    if (rawRun) runs.push(decodeRun(rawRun, 0, rawRun.columns.map(([offset, length]) => reply.data.subarray(offset, offset + length))));
  }
  return runs;
}

// The first time at which the angle of a body differs between the runs by more than a tenth of the error found by the
// check; `null` if the runs do not diverge.
function divergenceTime(run, variationRuns, error) {
  const threshold = Math.max(ERROR_FRACTION * error, MIN_ANGLE_RAD);
  for (let i = 0; i < run.samples; i++) {
    const time = run.time[i];
    for (const other of variationRuns) {
      const position = locateSample(other, time);
      for (const [k, body] of run.bodies.entries()) {
        if (body.fixed || !other.bodies[k]) continue;
        if (Math.abs(poseAt(other.bodies[k], position).angle_rad - body.angle_rad[i]) > threshold) return time;
      }
    }
  }
  return null;
}
