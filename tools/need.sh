# shellcheck shell=bash
# Functions to be sourced: headings, system requirements of a script, and the program under test.

# Prints a heading.
say() { printf '\n== %s\n' "$*"; }

# Ensures that a system program is available: installs it if this runs as root with apt-get, else ends with
# instructions.
# Usage: need "dependent" "requirement" PACKAGES test...        (PACKAGES: "first choice|packages of another distribution")
need() {
    local dependent=$1 requirement=$2 all=$3 choices packages
    IFS='|' read -ra choices <<<"$all"
    shift 3
    if "$@" >/dev/null 2>&1; then
        return
    fi
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        # Scripts that run at the same time wait for each other.
        local lock=${TMPDIR:-/tmp}/phalanx-packages.lock
        flock "$lock" apt-get update -qq >/dev/null || true
        for packages in "${choices[@]}"; do
            say "installing $packages"
            # shellcheck disable=SC2086  # several packages
            DEBIAN_FRONTEND=noninteractive flock "$lock" apt-get install -qq -y --no-install-recommends $packages >/dev/null || true
            hash -r
            if "$@" >/dev/null 2>&1; then
                return
            fi
        done
    fi
    echo "$dependent need $requirement; install it and run this again (Debian, Ubuntu: sudo apt-get install ${all##*|})" >&2
    exit 1
}

# Sets $PHALANX to the program, built with the profile and the features of the tests so that nothing is built twice. A
# value that is already set stays.
build_test_program() {
    if [ -z "${PHALANX:-}" ]; then
        cargo build --workspace --locked --all-features --profile test --quiet --bin phalanx
        PHALANX=$(realpath "${CARGO_TARGET_DIR:-target}")/debug/phalanx
    fi
    export PHALANX
}

# Sets $PHALANX_CAMPAIGN to the generator of random scenes, built in the same way.
build_campaign() {
    if [ -z "${PHALANX_CAMPAIGN:-}" ]; then
        cargo build --workspace --locked --all-features --profile test --quiet --example campaign
        PHALANX_CAMPAIGN=$(realpath "${CARGO_TARGET_DIR:-target}")/debug/examples/campaign
    fi
    export PHALANX_CAMPAIGN
}
