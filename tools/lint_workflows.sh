#!/usr/bin/env bash
# Linters for what no test runs: workflows (actionlint for their form, zizmor for what they let others do) and shell scripts
# (shellcheck). They are installed once, into target/lint, and again when what is pinned in tools/lint changes; nothing leaves this
# machine. Needs Python 3.11 with venv and Node 18 with npm.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

python_works() { python3 -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))'; }
node_works() { npm --version && node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)'; }
need "the linters" "Python 3.11 or later with venv" "python3 python3-venv" python_works
need "the linters" "Node 18 or later with npm" "nodejs npm" node_works

room=$PWD/target/lint
wanted=$( (python3 --version; node --version; pwd; cat tools/lint/requirements.txt tools/lint/package-lock.json) | cksum)
if [ "$(cat "$room/.installed-from" 2>/dev/null)" != "$wanted" ]; then
    say "lint: installing tools/lint"
    rm -rf "$room"
    mkdir -p "$room"
    python3 -m venv "$room/venv"
    "$room/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: -r tools/lint/requirements.txt
    cp tools/lint/package.json tools/lint/package-lock.json "$room"
    (cd "$room" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
    echo "$wanted" >"$room/.installed-from"
fi
# A module finds what it imports beside itself.
cp tools/lint/workflows.mjs "$room"

workflows=(.github/workflows/*.yml)
node "$room/workflows.mjs" "${workflows[@]}"
"$room/venv/bin/zizmor" --offline --no-progress --quiet --config .github/zizmor.yml "${workflows[@]}"
"$room/venv/bin/shellcheck" --external-sources .ci/run tools/*.sh tools/slurm/*.sh tools/slurm/*.sbatch
echo "${#workflows[@]} workflows and all shell scripts are sound, as far as linters see"
