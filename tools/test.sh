#!/usr/bin/env bash
# The checks of the project. Usage: tools/test.sh [core | all | lints | tests | browser | python]
#   core     formatting, lints, all tests except the long ones, and the doc tests; takes a few minutes and needs only a
#            Rust toolchain
#   (none)   lints, tests, browser and python
#   all      also the campaigns of random scenes, and a sweep under Slurm; CI runs these every night
#   lints    formatting, lock files, workflows and scripts, lints, documentation and its tests
#   tests    the tests in Rust, also the long ones
#   browser  the core in the browser, and real clients of logs and pages
#   python   the Python package
# Needs a Rust toolchain with rustfmt and clippy; uses cargo-nextest if it is installed. tools/wasm.sh, tools/python.sh,
# tools/clients.sh, tools/slurm/test.sh and tools/lint_workflows.sh install or name the requirements of the other
# checks.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

# Everything is built only once, so incremental artifacts would only fill the disk.
export CARGO_INCREMENTAL=0
# The module of the explorer is built by its own script, once, and as fast as possible.
export PHALANX_EXPLORER_MODULE=
export EXPLORER_PROFILE=checks
# Without line numbers in backtraces, the tests are built faster.
export CARGO_PROFILE_DEV_DEBUG=false

has_nextest() { cargo nextest --version >/dev/null 2>&1; }

core() {
    say "formatting"
    cargo fmt --check
    say "lints"
    cargo clippy --workspace --locked --all-targets -- -D warnings
    say "tests"
    # The long tests: random scenes and campaigns, killed processes and full disks, complete validations and
    # reproductions.
    local long='campaign|random_scenes|hard_grippers|faults_process|validate_command|sweep_resume|reproduce'
    if has_nextest; then
        cargo nextest run --workspace --locked --no-fail-fast --tests -E "not test(/^($long)::/)"
    else
        local skipped
        IFS='|' read -ra skipped <<<"$long"
        cargo test --workspace --locked --no-fail-fast --tests -- "${skipped[@]/#/--skip=}"
    fi
    say "doc tests"
    cargo test --workspace --locked --doc --quiet
}

lints() {
    say "formatting"
    cargo fmt --check
    say "lock files of the separate workspaces"
    # A change of the main manifest makes them stale, and no other check notices.
    local workspace
    for workspace in benches/solvers crates/explorer tests/fuzz; do
        if ! cargo update --workspace --locked --quiet --manifest-path "$workspace/Cargo.toml"; then
            echo "$workspace/Cargo.lock is stale; update it: cargo update --workspace --manifest-path $workspace/Cargo.toml" >&2
            exit 1
        fi
    done
    say "workflows and scripts"
    tools/lint_workflows.sh
    say "lints"
    # All features for all targets, so that one build serves all checks.
    cargo clippy --workspace --locked --all-targets --all-features -- -D warnings
    # The comparison with published solvers is a separate workspace. It is checked without diffsol, which takes a minute to
    # build; its adapter uses the same code of this project as the other adapters.
    cargo check --locked --quiet --no-default-features --manifest-path benches/solvers/Cargo.toml --target-dir target
    say "documentation"
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --locked --all-features --no-deps --quiet
    cargo test --workspace --locked --all-features --doc --quiet
}

# Usage: tests PROFILE      (of .config/nextest.toml)
tests() {
    say "tests"
    if has_nextest; then
        # More threads than processors, because many tests wait for other processes.
        local threads=$(($(getconf _NPROCESSORS_ONLN) + 2))
        cargo nextest run --workspace --locked --all-features --no-fail-fast --tests --profile "$1" --test-threads "$threads"
    else
        cargo test --workspace --locked --all-features --no-fail-fast --tests
    fi
}

# What later checks need, in the background: downloads mostly wait, and the module has a target directory of its own.
prepare() {
    prepare_log=$(mktemp)
    (
        tools/clients.sh setup
        tools/python.sh requirements
        FEATURES=figures tools/explorer.sh
    ) >"$prepare_log" 2>&1 &
    prepare_pid=$!
    trap 'kill "$prepare_pid" 2>/dev/null || true' EXIT
}

finish_preparing() {
    local status=0
    wait "$prepare_pid" || status=$?
    trap - EXIT
    say "requirements of Python and clients, the explorer's module"
    cat "$prepare_log"
    rm -f "$prepare_log"
    if [ "$status" != 0 ]; then
        exit "$status"
    fi
}

core_in_browser() {
    say "the core in the browser"
    tools/wasm.sh
    # The clients use the same module.
    PHALANX_EXPLORER=$(realpath "${CARGO_TARGET_DIR:-target}")/release/phalanx-explorer.wasm.gz
    export PHALANX_EXPLORER
}

slurm() {
    say "sweeps under Slurm"
    # Takes less than two minutes; the timeout ends it if the scheduler does not respond.
    timeout --kill-after=60 600 tools/slurm/test.sh
}

# The Python package, and real clients in parallel, which mostly wait for browsers.
python_and_clients() {
    say "the Python package, and real clients in parallel"
    # The programs are built first, so that no check waits for another's build.
    build_test_program
    build_campaign
    local clients_log clients_pid python_status=0 clients_status=0
    clients_log=$(mktemp)
    tools/clients.sh >"$clients_log" 2>&1 &
    clients_pid=$!
    tools/python.sh || python_status=$?
    wait "$clients_pid" || clients_status=$?
    say "real clients"
    cat "$clients_log"
    rm -f "$clients_log"
    if [ "$python_status" != 0 ] || [ "$clients_status" != 0 ]; then
        echo "some checks failed; exit statuses: Python package $python_status, clients $clients_status" >&2
        exit 1
    fi
}

free_gb=$(df --output=avail --block-size=1G . 2>/dev/null | tail -1 | tr -d ' ') || free_gb=
if [ -n "$free_gb" ] && [ "$free_gb" -lt 8 ]; then
    echo "only $free_gb GB of disk space are free; the checks need about 6 GB, and linking may fail" >&2
fi
if ! command -v cargo >/dev/null; then
    echo "cargo is not installed: install a Rust toolchain (rustup.rs) of at least the version in Cargo.toml" >&2
    exit 1
fi
for component in rustfmt clippy; do
    cargo "${component/rustfmt/fmt}" --version >/dev/null 2>&1 || rustup component add "$component"
done

case ${1:-} in
'')
    prepare
    lints
    tests ci
    finish_preparing
    core_in_browser
    python_and_clients
    ;;
all)
    prepare
    lints
    tests all
    finish_preparing
    core_in_browser
    python_and_clients
    slurm
    ;;
core) core ;;
lints) lints ;;
tests) tests ci ;;
browser)
    core_in_browser
    tools/clients.sh
    ;;
python) tools/python.sh ;;
*)
    echo "tools/test.sh: $1 is not one of core, all, lints, tests, browser and python" >&2
    exit 2
    ;;
esac
