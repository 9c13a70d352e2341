#!/usr/bin/env bash
# Lints the files that no test executes: workflows (actionlint for syntax, zizmor for security) and shell scripts
# (shellcheck). The linters are installed into target/lint, and again when the pins in tools/lint change; they run
# offline. Needs Python 3.11 with venv and Node 18 with npm.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

python_works() { python3 -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))'; }
node_works() { npm --version && node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)'; }
need "the linters" "Python 3.11 or later with venv" "python3 python3-venv" python_works
need "the linters" "Node 18 or later with npm" "nodejs npm" node_works

lint_dir=$PWD/target/lint
requirements=$( (python3 --version; node --version; pwd; cat tools/lint/requirements.txt tools/lint/package-lock.json) | cksum)
if [ "$(cat "$lint_dir/.installed-from" 2>/dev/null)" != "$requirements" ]; then
    say "lint: installing tools/lint"
    rm -rf "$lint_dir"
    mkdir -p "$lint_dir"
    python3 -m venv "$lint_dir/venv"
    "$lint_dir/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: -r tools/lint/requirements.txt
    cp tools/lint/package.json tools/lint/package-lock.json "$lint_dir"
    (cd "$lint_dir" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
    echo "$requirements" >"$lint_dir/.installed-from"
fi
# Node resolves imports from the directory of the module.
cp tools/lint/workflows.mjs "$lint_dir"

workflows=(.github/workflows/*.yml)
node "$lint_dir/workflows.mjs" "${workflows[@]}"
"$lint_dir/venv/bin/zizmor" --offline --no-progress --quiet --config .github/zizmor.yml "${workflows[@]}"
"$lint_dir/venv/bin/shellcheck" --external-sources .ci/run tools/*.sh tools/slurm/*.sh tools/slurm/*.sbatch
echo "the linters found no errors in ${#workflows[@]} workflows and all shell scripts"
