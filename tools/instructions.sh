#!/usr/bin/env bash
# Counts the instructions of one 20 ms closing of design 95 with the engineering preset: the difference between N and 2N
# closings under callgrind, which excludes program start and scene loading. Unlike wall time, the count does not depend
# on the load of the machine.
# Usage: tools/instructions.sh [N]        (N = 10)
set -euo pipefail
cd "$(dirname "$0")/.."

closings=${1:-10}
if ! [[ $closings =~ ^[1-9][0-9]*$ ]]; then
    echo "the number of closings must be a positive integer, not '$closings'" >&2
    exit 2
fi
if ! command -v valgrind >/dev/null; then
    echo "valgrind is not installed (Debian, Ubuntu: sudo apt-get install valgrind)" >&2
    exit 1
fi

program=$(cargo bench --locked --no-run --bench work_precision 2>&1 | sed -n 's/.*Executable.*(\(.*\))$/\1/p')
if [ -z "$program" ]; then
    echo "the benchmark does not build; see: cargo bench --no-run --bench work_precision" >&2
    exit 1
fi

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# Prints the instructions of one process that runs $1 closings.
count() {
    valgrind --tool=callgrind --callgrind-out-file="$scratch/out.$1" "$program" --closings "$1" 2>"$scratch/log"
    sed -n 's/^summary: //p; s/^totals: //p' "$scratch/out.$1" | tail -1
}

count_n=$(count "$closings")
count_2n=$(count $((2 * closings)))
echo "$(((count_2n - count_n) / closings)) instructions per closing"
