#!/usr/bin/env bash
# Instructions of one 20 ms closing of design 95 with the engineering preset: the difference between N and 2N closings under
# callgrind, so that starting the program and loading the scene do not count. Unlike times, it is the same on a busy machine.
# Usage: tools/instructions.sh [N]        (N = 10)
set -euo pipefail
cd "$(dirname "$0")/.."

closings=${1:-10}
if ! [[ $closings =~ ^[1-9][0-9]*$ ]]; then
    echo "the number of closings must be a whole number from 1, not '$closings'" >&2
    exit 2
fi
if ! command -v valgrind >/dev/null; then
    echo "valgrind is not installed: get it from the packages of the system (apt-get install valgrind)" >&2
    exit 1
fi

program=$(cargo bench --locked --no-run --bench work_precision 2>&1 | sed -n 's/.*Executable.*(\(.*\))$/\1/p')
if [ -z "$program" ]; then
    echo "the bench does not build; see: cargo bench --no-run --bench work_precision" >&2
    exit 1
fi

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# Instructions of $1 closings in one program.
count() {
    valgrind --tool=callgrind --callgrind-out-file="$scratch/out.$1" "$program" --closings "$1" 2>"$scratch/log"
    sed -n 's/^summary: //p; s/^totals: //p' "$scratch/out.$1" | tail -1
}

once=$(count "$closings")
twice=$(count $((2 * closings)))
echo "$(((twice - once) / closings)) instructions per closing"
