#!/usr/bin/env bash
# The checks of the project. Usage: tools/test.sh [core]
#   core   formatting, lints, tests but the long ones, and the examples of the documentation: some minutes, and a Rust toolchain alone
#   (all)  everything: also the long tests, the documentation, the core in the browser, the Python package, real clients of the logs, and
#          a sweep under Slurm
# Needs a Rust toolchain with rustfmt and clippy; uses cargo-nextest where it is installed. tools/wasm.sh, tools/python.sh,
# tools/clients.sh, tools/slurm/test.sh and tools/lint_workflows.sh install or name what the other checks need.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

# Everything is built once here: what lets the next build be partial only fills the disk.
export CARGO_INCREMENTAL=0
room=$(df --output=avail --block-size=1G . 2>/dev/null | tail -1 | tr -d ' ') || room=
if [ -n "$room" ] && [ "$room" -lt 8 ]; then
    echo "only $room GB are free here; the checks need about 6: linking may fail for want of room" >&2
fi

if ! command -v cargo >/dev/null; then
    echo "cargo is not installed: get a Rust toolchain (rustup.rs), at least the version named in Cargo.toml" >&2
    exit 1
fi
for part in rustfmt clippy; do
    cargo "${part/rustfmt/fmt}" --version >/dev/null 2>&1 || rustup component add "$part"
done

say "formatting"
cargo fmt --check

if [ "${1:-}" = core ]; then
    say "lints"
    cargo clippy --workspace --locked --all-targets -- -D warnings
    say "tests"
    # Long: random scenes and campaigns, kills and full disks, whole validations and reproductions.
    long='campaign|random_scenes|hard_grippers|faults_process|replay_recover|validate_command|sweep_resume|reproduce|optimize_search'
    if cargo nextest --version >/dev/null 2>&1; then
        cargo nextest run --workspace --locked --no-fail-fast --tests -E "not test(/^($long)::/)"
    else
        IFS='|' read -ra skipped <<<"$long"
        cargo test --workspace --locked --no-fail-fast --tests -- "${skipped[@]/#/--skip=}"
    fi
    say "examples of the documentation"
    cargo test --workspace --locked --doc --quiet
    exit
fi

say "lock files of what is built apart"
# Nothing else here builds them, and a change of the main manifest makes them stale.
for apart in benches/solvers crates/explorer tests/fuzz; do
    if ! cargo update --workspace --locked --quiet --manifest-path "$apart/Cargo.toml"; then
        echo "$apart/Cargo.lock is stale: cargo update --workspace --manifest-path $apart/Cargo.toml mends it" >&2
        exit 1
    fi
done

say "workflows and scripts"
tools/lint_workflows.sh

say "lints"
# Everything with all features, so that one build serves; the default set has to be sound too.
cargo clippy --workspace --locked --all-targets --all-features -- -D warnings
cargo clippy --workspace --locked --features phalanx-python/as-linted --quiet -- -D warnings

# The comparison with published solvers is a workspace of its own; what is built for it serves nothing else. diffsol is left out, which
# takes a minute: what is ours of its file is what the others have too.
cargo check --locked --quiet --no-default-features --manifest-path benches/solvers/Cargo.toml --target-dir target

say "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --locked --all-features --no-deps --quiet
cargo test --workspace --locked --all-features --doc --quiet

say "tests"
if cargo nextest --version >/dev/null 2>&1; then
    cargo nextest run --workspace --locked --all-features --no-fail-fast --tests
else
    cargo test --workspace --locked --all-features --no-fail-fast --tests
fi

say "the core in the browser"
tools/wasm.sh

say "the Python package and sweeps under Slurm, and beside them real clients"
# Clients wait for browsers, the others keep one processor busy. What clients need is installed before, so that no two ask for packages at
# a time, and the program is there, so that none waits for another's build.
tools/clients.sh setup
program_as_tested
told=$(mktemp)
# They are shown the module that has just been built.
PHALANX_EXPLORER=$(realpath "${CARGO_TARGET_DIR:-target}")/release/phalanx-explorer.wasm.gz tools/clients.sh >"$told" 2>&1 &
beside=$!
package=0 sweeps=0 clients=0
tools/python.sh || package=$?
say "sweeps under Slurm"
# Under two minutes; what waits for a scheduler that does not answer must not wait for ever.
timeout --kill-after=60 600 tools/slurm/test.sh || sweeps=$?
wait "$beside" || clients=$?
say "real clients"
cat "$told"
rm -f "$told"
if [ "$package" != 0 ] || [ "$sweeps" != 0 ] || [ "$clients" != 0 ]; then
    echo "not all is well: the Python package ended with $package, Slurm with $sweeps, clients with $clients" >&2
    exit 1
fi
