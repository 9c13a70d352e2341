# shellcheck shell=bash
# To be sourced: says what goes on, and gets what a script cannot do without.

say() { printf '\n== %s\n' "$*"; }

# A program of the system: there, or installed where that is possible without asking, or asked for.
# Usage: need "who needs it" "what it is" PACKAGES test...        (PACKAGES: "these of one|or these of another distribution")
need() {
    local who=$1 what=$2 all=$3 choices packages
    IFS='|' read -ra choices <<<"$all"
    shift 3
    if "$@" >/dev/null 2>&1; then
        return
    fi
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        apt-get update -qq >/dev/null || true
        for packages in "${choices[@]}"; do
            say "installing $packages"
            # shellcheck disable=SC2086  # several packages
            DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $packages >/dev/null || true
            hash -r
            if "$@" >/dev/null 2>&1; then
                return
            fi
        done
    fi
    echo "$who need $what; install it and run this again (Debian, Ubuntu: sudo apt-get install ${all##*|})" >&2
    exit 1
}

# $PHALANX: the program of the profile and the features of the tests, so that nothing is built twice, unless another one is named.
program_as_tested() {
    if [ -z "${PHALANX:-}" ]; then
        cargo build --workspace --locked --all-features --profile test --quiet --bin phalanx
        PHALANX=$(realpath "${CARGO_TARGET_DIR:-target}")/debug/phalanx
    fi
    export PHALANX
}
