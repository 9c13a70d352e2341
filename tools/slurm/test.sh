#!/usr/bin/env bash
# A sweep under a real Slurm of this one machine (Debian's packages: munge, slurmctld, slurmd, slurm-client): the array of a small
# study, one of whose tasks is killed, and its merge have the bytes of the sweep in one piece; submitted again, nothing is computed.
# munged, slurmctld and slurmd are this script's own: on free ports of the loopback, with all their files in a temporary directory,
# ended by their process numbers. Where the packages cannot be had it says so, and that nothing was run.
# $PHALANX names another binary. Needs root, as slurmd does.
set -euo pipefail
cd "$(dirname "$0")/../.."

# shellcheck source=tools/need.sh
. tools/need.sh

not_run() {
    echo "NOT RUN: the sweep under Slurm: $*" >&2
    exit 0
}

there() {
    command -v munged && command -v slurmctld && command -v slurmd && command -v sbatch
}

export PATH=$PATH:/usr/sbin
[ "$(id -u)" = 0 ] || not_run "slurmd has to be started by root"
# In a shell of its own, for `need` ends it where the packages are not to be had.
(need "the sweep under Slurm" "Slurm and munge" "munge slurmctld slurmd slurm-client" there) ||
    not_run "its packages do not install here"

program_as_tested
PHALANX=$(realpath "$PHALANX")

# Sockets have short names; slurmd's is in here too.
room=$(mktemp -d /tmp/phalanx-slurm.XXXXXX)
unset SLURM_CONF
started=()
end() {
    local status=$? process
    trap - EXIT
    # Of this Slurm alone: before its configuration stands, it would be another's.
    if [ "${SLURM_CONF:-}" = "$room/slurm.conf" ]; then
        timeout 10 scancel --user="$(id -un)" --quiet 2>/dev/null || true
    fi
    for process in "${started[@]}"; do
        kill "$process" 2>/dev/null || true
    done
    for process in "${started[@]}"; do
        # Half a minute for each to end by itself.
        for _ in $(seq 300); do
            kill -0 "$process" 2>/dev/null || break
            sleep 0.1
        done
        kill -KILL "$process" 2>/dev/null || true
    done
    if [ "$status" != 0 ]; then
        echo "the sweep under Slurm failed; the last lines of its logs:" >&2
        tail -n 15 "$room"/*.log "$room"/out.csv.parts/*/*.log >&2 2>/dev/null || true
    fi
    rm -rf "$room"
    exit "$status"
}
trap end EXIT

free_port() {
    python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}
command -v python3 >/dev/null || not_run "Python 3 finds the free ports, and is not installed"

say "slurm: starting it on this machine"
host=$(hostname -s)
cores=$(nproc)
chmod 755 "$room"
mkdir -p "$room/munge" "$room/state" "$room/spool"
chmod 700 "$room/munge"
(umask 077 && dd if=/dev/urandom of="$room/munge/key" bs=1 count=128 status=none)
cat >"$room/slurm.conf" <<CONF
ClusterName=phalanx-test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# The second: how long after a requeue a job waits, and how long its credential is good.
AuthInfo=socket=$room/munge/socket,cred_expire=5
CryptoType=crypto/munge
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmctldPidFile=$room/slurmctld.pid
SlurmdPidFile=$room/slurmd.pid
SlurmctldLogFile=$room/slurmctld.log
SlurmdLogFile=$room/slurmd.log
StateSaveLocation=$room/state
SlurmdSpoolDir=$room/spool
# A container has no cgroups to give away.
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
export SLURM_CONF=$room/slurm.conf

munged --foreground --force --key-file="$room/munge/key" --socket="$room/munge/socket" --pid-file="$room/munge/pid" \
    --log-file="$room/munge/log" --seed-file="$room/munge/seed" >"$room/munged.log" 2>&1 &
started+=($!)
for _ in $(seq 100); do
    [ -S "$room/munge/socket" ] && break
    sleep 0.1
done
slurmctld -D >"$room/slurmctld.out.log" 2>&1 &
started+=($!)
slurmd -D >"$room/slurmd.out.log" 2>&1 &
started+=($!)
for _ in $(seq 300); do
    sinfo --noheader --format=%T 2>/dev/null | grep -q idle && break
    sleep 0.2
done
sinfo --noheader --format=%T | grep -q idle || {
    echo "Slurm does not get ready on this machine" >&2
    exit 1
}

# Each part takes a second or so: long enough to be killed on its way.
cat >"$room/study.toml" <<STUDY
scene = "$PWD/scenes/experiment-95.toml"

[[axes]]
field = "motor.torque"
from = "300 N*mm"
to = "600 N*mm"
count = ${RUNS:-4000}
STUDY
"$PHALANX" --quiet sweep "$room/study.toml" --out "$room/whole.csv" >/dev/null

say "slurm: a sweep in eight parts, by three tasks, one of them killed"
jobs=$(TASKS=3 tools/slurm/sweep.sbatch submit "$room/study.toml" 8 "$room/out.csv")
read -r _ sweep _ merge <<<"$jobs"
parts=$room/out.csv.parts/of-8

# The first process that makes a part: killed as the machine's own killer would.
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
[ -n "$victim" ] || { echo "no task has begun" >&2; exit 1; }
killed=$(tr '\0' '\n' <"/proc/$victim/cmdline" | grep -m1 '\.parquet$')
kill -KILL "$victim"
[ ! -e "$killed" ] || { echo "$killed was there before its process was killed: the runs are too short for this test" >&2; exit 1; }

for _ in $(seq 1200); do
    [ -z "$(squeue --noheader --jobs="$sweep,$merge" 2>/dev/null)" ] && break
    sleep 0.2
done
grep -q "requeued" "$parts"/task-*.log || { echo "the killed task was not requeued" >&2; exit 1; }
cmp "$room/out.csv" "$room/whole.csv"
cmp "$room/out.csv.study.json" "$room/whole.csv.study.json"
echo "the killed task was requeued; the merged table has the bytes of the sweep in one piece"

say "slurm: the same again, with one part lost"
rm "$parts/5.parquet" "$room/out.csv" "$room/out.csv.study.json"
before=$(stat --format='%n %Y' "$parts"/[!5].parquet)
jobs=$(TASKS=3 tools/slurm/sweep.sbatch submit "$room/study.toml" 8 "$room/out.csv")
read -r _ sweep _ merge <<<"$jobs"
for _ in $(seq 1200); do
    [ -z "$(squeue --noheader --jobs="$sweep,$merge" 2>/dev/null)" ] && break
    sleep 0.2
done
cmp "$room/out.csv" "$room/whole.csv"
[ "$before" = "$(stat --format='%n %Y' "$parts"/[!5].parquet)" ] || { echo "finished parts were made again" >&2; exit 1; }
echo "only the lost part was made again"
