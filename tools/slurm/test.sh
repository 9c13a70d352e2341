#!/usr/bin/env bash
# Tests a sweep under a real Slurm on this machine (Debian packages munge, slurmctld, slurmd, slurm-client): a job array
# of a small study, one task of which is killed, and its merge must give the same bytes as the sweep in one piece.
# Submitted again, it computes only lost parts. The script starts its own munged, slurmctld and slurmd on free loopback
# ports, with all files in a temporary directory, and ends them by process id. If the packages cannot be installed, it
# reports NOT RUN and ends with status 0. $PHALANX names another binary. Needs root, because slurmd does.
set -euo pipefail
cd "$(dirname "$0")/../.."

# shellcheck source=tools/need.sh
. tools/need.sh

not_run() {
    echo "NOT RUN: the sweep under Slurm: $*" >&2
    exit 0
}

slurm_installed() {
    command -v munged && command -v slurmctld && command -v slurmd && command -v sbatch
}

export PATH=$PATH:/usr/sbin
[ "$(id -u)" = 0 ] || not_run "slurmd must be started by root"
# In a subshell, because `need` exits if the packages cannot be installed.
(need "the sweep under Slurm" "Slurm and munge" "munge slurmctld slurmd slurm-client" slurm_installed) ||
    not_run "the packages of Slurm cannot be installed"

build_test_program
PHALANX=$(realpath "$PHALANX")

# A short path, because the length of socket names is limited; the socket of slurmd is in this directory too.
scratch=$(mktemp -d /tmp/phalanx-slurm.XXXXXX)
unset SLURM_CONF
daemons=()
cleanup() {
    local status=$? process
    trap - EXIT
    # Without its own configuration, scancel would act on another Slurm.
    if [ "${SLURM_CONF:-}" = "$scratch/slurm.conf" ]; then
        timeout 10 scancel --user="$(id -un)" --quiet 2>/dev/null || true
    fi
    for process in "${daemons[@]}"; do
        kill "$process" 2>/dev/null || true
    done
    for process in "${daemons[@]}"; do
        # Each daemon gets half a minute to end before it is killed.
        for _ in $(seq 300); do
            kill -0 "$process" 2>/dev/null || break
            sleep 0.1
        done
        kill -KILL "$process" 2>/dev/null || true
    done
    if [ "$status" != 0 ]; then
        echo "the sweep under Slurm failed; the last lines of its logs:" >&2
        tail -n 15 "$scratch"/*.log "$scratch"/out.csv.parts/*/*.log >&2 2>/dev/null || true
    fi
    rm -rf "$scratch"
    exit "$status"
}
trap cleanup EXIT

free_port() {
    python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}
command -v python3 >/dev/null || not_run "Python 3, which finds free ports, is not installed"

say "slurm: starting on this machine"
host=$(hostname -s)
cores=$(nproc)
chmod 755 "$scratch"
mkdir -p "$scratch/munge" "$scratch/state" "$scratch/spool"
chmod 700 "$scratch/munge"
(umask 077 && dd if=/dev/urandom of="$scratch/munge/key" bs=1 count=128 status=none)
cat >"$scratch/slurm.conf" <<CONF
ClusterName=phalanx-test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# cred_expire: lifetime of a job credential and delay after a requeue, s.
AuthInfo=socket=$scratch/munge/socket,cred_expire=5
CryptoType=crypto/munge
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmctldPidFile=$scratch/slurmctld.pid
SlurmdPidFile=$scratch/slurmd.pid
SlurmctldLogFile=$scratch/slurmctld.log
SlurmdLogFile=$scratch/slurmd.log
StateSaveLocation=$scratch/state
SlurmdSpoolDir=$scratch/spool
# Cgroups may not be available in a container.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=2
JobRequeue=1
ReturnToService=2
MailProg=/bin/true
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cores State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=10 State=UP
CONF
export SLURM_CONF=$scratch/slurm.conf

munged --foreground --force --key-file="$scratch/munge/key" --socket="$scratch/munge/socket" --pid-file="$scratch/munge/pid" \
    --log-file="$scratch/munge/log" --seed-file="$scratch/munge/seed" >"$scratch/munged.log" 2>&1 &
daemons+=($!)
for _ in $(seq 100); do
    [ -S "$scratch/munge/socket" ] && break
    sleep 0.1
done
slurmctld -D >"$scratch/slurmctld.out.log" 2>&1 &
daemons+=($!)
slurmd -D >"$scratch/slurmd.out.log" 2>&1 &
daemons+=($!)
for _ in $(seq 300); do
    sinfo --noheader --format=%T 2>/dev/null | grep -q idle && break
    sleep 0.2
done
sinfo --noheader --format=%T | grep -q idle || {
    echo "Slurm has no idle node after 60 s" >&2
    exit 1
}

# Each part takes about a second: long enough to be killed before it ends.
cat >"$scratch/study.toml" <<STUDY
scene = "$PWD/scenes/experiment-95.toml"

[[axes]]
field = "motor.torque"
from = "300 N*mm"
to = "600 N*mm"
count = ${RUNS:-4000}
STUDY
"$PHALANX" --quiet sweep "$scratch/study.toml" --out "$scratch/whole.csv" >/dev/null

say "slurm: a sweep of eight parts in three tasks; one task is killed"
jobs=$(TASKS=3 tools/slurm/sweep.sbatch submit "$scratch/study.toml" 8 "$scratch/out.csv")
read -r _ sweep _ merge <<<"$jobs"
parts=$scratch/out.csv.parts/of-8

# Kill the first process that computes a part with SIGKILL, as the kernel does when memory runs out.
victim=
for _ in $(seq 600); do
    for process in /proc/[0-9]*; do
        if [ "$(readlink "$process/exe" 2>/dev/null)" = "$PHALANX" ] && tr '\0' ' ' <"$process/cmdline" | grep -q -- "$parts/"; then
            victim=${process#/proc/}
            break 2
        fi
    done
    sleep 0.05
done
[ -n "$victim" ] || { echo "no task has started within 30 s" >&2; exit 1; }
killed_part=$(tr '\0' '\n' <"/proc/$victim/cmdline" | grep -m1 '\.parquet$')
kill -KILL "$victim"
[ ! -e "$killed_part" ] || { echo "$killed_part was complete before its process was killed: the runs are too short for this test" >&2; exit 1; }

for _ in $(seq 1200); do
    [ -z "$(squeue --noheader --jobs="$sweep,$merge" 2>/dev/null)" ] && break
    sleep 0.2
done
grep -q "requeued" "$parts"/task-*.log || { echo "the killed task was not requeued" >&2; exit 1; }
cmp "$scratch/out.csv" "$scratch/whole.csv"
cmp "$scratch/out.csv.study.json" "$scratch/whole.csv.study.json"
echo "the killed task was requeued; the merged table has the same bytes as the sweep in one piece"

say "slurm: the same sweep again after the loss of one part"
rm "$parts/5.parquet" "$scratch/out.csv" "$scratch/out.csv.study.json"
before=$(stat --format='%n %Y' "$parts"/[!5].parquet)
jobs=$(TASKS=3 tools/slurm/sweep.sbatch submit "$scratch/study.toml" 8 "$scratch/out.csv")
read -r _ sweep _ merge <<<"$jobs"
for _ in $(seq 1200); do
    [ -z "$(squeue --noheader --jobs="$sweep,$merge" 2>/dev/null)" ] && break
    sleep 0.2
done
cmp "$scratch/out.csv" "$scratch/whole.csv"
[ "$before" = "$(stat --format='%n %Y' "$parts"/[!5].parquet)" ] || { echo "finished parts were computed again" >&2; exit 1; }
echo "only the lost part was computed again"
