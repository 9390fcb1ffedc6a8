#!/usr/bin/env bash
# A real Slurm on loopback for tests: its own munge, controller and emulated
# nodes, as root, without systemd and without cgroups. Everything of a cluster
# lies below one folder DIR, so several can run side by side.
#
#   cluster.sh install             install what is missing (exit 77: cannot, and why)
#   cluster.sh start DIR [NODES]   a fresh cluster with the nodes n1, n2, …; DIR/env
#                                  has the lines that clients need in their environment;
#                                  MAX_ARRAY_SIZE in the environment: indices are below it
#   cluster.sh kill-node DIR nK    that node loses power, with all that runs on it
#   cluster.sh start-node DIR nK   that node is switched on again
#   cluster.sh stop-ctl DIR        the controller ends, having saved its state; jobs go on
#   cluster.sh start-ctl DIR       the controller comes back with the saved state
#   cluster.sh stop DIR            end every process of this cluster
#
# Exit: 0 done, 1 failed, 2 wrong usage, 77 there can be no Slurm here.
set -euo pipefail

readonly UP_DEADLINE_S=60
readonly STOP_DEADLINE_S=20
# So long a node may be silent before it counts as down; not less, because a
# busy machine answers late.
readonly NODE_TIMEOUT_S=10
# A path of a unix socket holds at most 107 bytes; Slurm adds "nK_JOB.STEP".
readonly SPOOL_PATH_MAX_BYTES=70
readonly PACKAGES=(slurmctld slurmd slurm-client munge)
readonly PROGRAMS=(munged slurmctld slurmd sbatch srun squeue sinfo scontrol scancel)
# Debian keeps the daemons in sbin, which is not in every PATH.
export PATH="$PATH:/usr/local/sbin:/usr/sbin:/sbin"

say() { printf 'cluster.sh: %s\n' "$*" >&2; }
die() {
    say "$*"
    exit 1
}
usage() {
    say "$*"
    sed -n 's/^#   //p' "$0" >&2
    exit 2
}
# Skipping is an outcome, not an error: the reason goes to standard output.
skip() {
    printf '%s\n' "$*"
    exit 77
}

# ---- install ----------------------------------------------------------------

readonly POLICY=/usr/sbin/policy-rc.d
apt_log=''

missing_programs() {
    local program
    for program in "${PROGRAMS[@]}"; do
        type -P "$program" >/dev/null || printf '%s ' "$program"
    done
}

apt() { DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=120 "$@" >"$apt_log" 2>&1; }

# The packages must not start their services: tests start their own.
forbid_services() {
    if [[ -e $POLICY ]]; then mv "$POLICY" "$POLICY.saved"; fi
    printf '#!/bin/sh\nexit 101\n' >"$POLICY"
    chmod 755 "$POLICY"
}
allow_services() {
    rm -f "$POLICY" "$apt_log"
    if [[ -e $POLICY.saved ]]; then mv "$POLICY.saved" "$POLICY"; fi
}

install_slurm() {
    local missing
    missing=$(missing_programs)
    [[ $EUID -eq 0 ]] || skip 'only root can start a cluster (munge and slurmd act for other users)'
    if [[ -z $missing ]]; then return; fi
    type -P apt-get >/dev/null || skip "Slurm is not installed (no ${missing% }) and there is no apt-get to install it with"
    # Two tests at a time must not mix up the policy file.
    exec 9>/tmp/spinebench-slurm-install.lock
    flock 9
    apt_log=$(mktemp)
    trap allow_services EXIT
    forbid_services
    # The package lists may be absent or old: fetch them when the first try fails.
    apt install -y --no-install-recommends "${PACKAGES[@]}" ||
        { apt update && apt install -y --no-install-recommends "${PACKAGES[@]}"; } ||
        skip "apt-get cannot install ${PACKAGES[*]}: $(grep -m1 '^E:' "$apt_log" || tail -n1 "$apt_log")"
    missing=$(missing_programs)
    [[ -z $missing ]] || skip "${PACKAGES[*]} are installed, but there is no ${missing% }"
}

# ---- processes of a cluster -------------------------------------------------

# The cluster and node that a daemon was started for. slurmstepd inherits it, but
# overwrites its environment for a title: there, the log that it writes tells.
# A job's processes carry what Slurm itself puts there. Clients carry none of it.
readonly DIR_MARK=SPINEBENCH_SLURM_DIR NODE_MARK=SPINEBENCH_SLURM_NODE

has() { grep -qzFx -e "$2" "/proc/$1/environ" 2>/dev/null; } # PID NAME=VALUE

# Processes that have this NAME=VALUE, and that one if given, in their environment.
pids_with() {
    local pid
    for pid in $({ grep -lzFx -e "$1" /proc/[0-9]*/environ 2>/dev/null || true; } | cut -d/ -f3); do
        if has "$pid" "${2-$1}"; then printf '%s\n' "$pid"; fi
    done
}

# Daemons that have one of the cluster's logs open.
pids_that_log_to() { # PATTERN
    local pid program
    for pid in $({ find /proc/[0-9]*/fd -maxdepth 1 -lname "$dir/logs/$1" 2>/dev/null || true; } | cut -d/ -f3 | uniq); do
        program=$(readlink "/proc/$pid/exe" || true)
        case ${program##*/} in
            slurm* | munged*) printf '%s\n' "$pid" ;;
        esac
    done
}

# The pids given, and all that descend from them.
with_descendants() {
    # Processes come and go while this reads: the files that vanish don't matter.
    { cat /proc/[0-9]*/status 2>/dev/null || true; } | awk -v roots="$*" '
        $1 == "Pid:" { pid = $2 }
        $1 == "PPid:" { children[$2] = children[$2] " " pid }
        function show(p,    list, n, i) {
            if (p in seen) return
            seen[p]
            print p
            n = split(children[p], list, " ")
            for (i = 1; i <= n; i++) show(list[i])
        }
        END { n = split(roots, list, " "); for (i = 1; i <= n; i++) show(list[i]) }'
}

# Every process of the cluster, or of its node $1; daemons come first.
pids_of() {
    local cluster roots
    cluster=$(sed -n 's/^ClusterName=//p' "$dir/slurm.conf" 2>/dev/null || true)
    roots="$(pids_with "$DIR_MARK=$dir" ${1:+"$NODE_MARK=$1"}) $(pids_that_log_to "${1:-*}.log")"
    if [[ -n $cluster ]]; then
        roots+=" $(pids_with "SLURM_CLUSTER_NAME=$cluster" ${1:+"SLURMD_NODENAME=$1"})"
    fi
    # shellcheck disable=SC2086 # a list of numbers
    with_descendants $roots
}

# As a power cut: all of them stand still before the first of them ends, so that
# none can tell the controller of another's end. Succeeds when nothing is left.
cut_power() { # [nK]
    local pids before deadline=$((SECONDS + STOP_DEADLINE_S))
    while pids=$(pids_of "$@") && [[ -n $pids ]]; do
        ((SECONDS < deadline)) || return 1
        before=''
        while [[ $pids != "$before" ]]; do
            # shellcheck disable=SC2086
            kill -STOP $pids 2>/dev/null || true
            before=$pids
            pids=$(pids_of "$@")
        done
        # shellcheck disable=SC2086
        kill -KILL $pids 2>/dev/null || true
        sleep 0.05
    done
}

# ---- configuration ----------------------------------------------------------

# The first of $1 neighbouring ports below the ephemeral ones that nobody uses.
# Another cluster may take one before we do; the start then tries again.
free_ports() {
    local used first port
    used=" $({ cat /proc/net/tcp /proc/net/tcp6 2>/dev/null || true; } | awk '{ sub(/.*:/, "", $2); print $2 }' | tr '\n' ' ') "
    while :; do
        first=$((10000 + RANDOM % 20000))
        for ((port = first; port < first + $1; port++)); do
            [[ $used != *" $(printf '%04X' "$port") "* ]] || continue 2
        done
        printf '%s\n' "$first"
        return
    done
}

# With these, Slurm listens where the machine's own name leads instead of
# everywhere, while connections come from 127.0.0.1: only where both are the same.
communication_parameters() {
    local address
    address=$(getent ahostsv4 "$(uname -n)" | awk 'NR == 1 { print $1 }' || true)
    if [[ $address == 127.0.0.1 ]]; then printf 'NoCtldInAddrAny,NoInAddrAny\n'; fi
}

# Unix sockets (munge's, each job step's) need a short path: DIR/spool is a link
# to a folder in /tmp when DIR itself is long.
make_spool() {
    if ((${#dir} + 6 <= SPOOL_PATH_MAX_BYTES)); then
        mkdir "$dir/spool"
    else
        ln -s "$(mktemp -d /tmp/spinebench-slurm.XXXXXX)" "$dir/spool"
        chmod 755 "$dir/spool/"
    fi
}
remove_spool() {
    if [[ -L $dir/spool ]]; then rm -rf "$(readlink "$dir/spool")"; fi
    rm -rf "$dir/spool"
}

write_configuration() { # NODES
    local nodes=$1 spool port parameters k
    spool=$(realpath "$dir/spool")
    port=$(free_ports $((nodes + 1)))
    parameters=$(communication_parameters)
    cat >"$dir/slurm.conf" <<CONF
ClusterName=spinebench$port
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort=$port
${parameters:+CommunicationParameters=$parameters}
AuthType=auth/munge
CredType=cred/munge
# A requeued job waits until its old credential has expired.
AuthInfo=cred_expire=10,socket=$spool/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc=$dir/jobcomp.txt
MpiDefault=none
PropagateResourceLimits=NONE

StateSaveLocation=$dir/state
SlurmdSpoolDir=$spool/%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/%n.pid
SlurmctldLogFile=$dir/logs/slurmctld.log
SlurmdLogFile=$dir/logs/%n.log

# A dead node is noticed within some 20 s, and comes back by registering.
SlurmdTimeout=$NODE_TIMEOUT_S
MessageTimeout=5
ReturnToService=2
JobRequeue=1
KillWait=3
InactiveLimit=0
MinJobAge=600
MaxJobCount=250000
MaxArraySize=${MAX_ARRAY_SIZE:-100001}
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,batch_sched_delay=0,bf_interval=1
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU

# More processors and memory than the machine may have.
SlurmdParameters=config_overrides
CONF
    for ((k = 1; k <= nodes; k++)); do
        printf 'NodeName=n%d NodeHostname=localhost NodeAddr=127.0.0.1 Port=%d CPUs=2 RealMemory=16384\n' "$k" $((port + k))
    done >>"$dir/slurm.conf"
    cat >>"$dir/slurm.conf" <<CONF
PartitionName=bench Nodes=ALL Default=YES MaxTime=INFINITE
PartitionName=slow Nodes=ALL Default=NO MaxTime=60
CONF
    printf 'SLURM_CONF=%s\n' "$dir/slurm.conf" >"$dir/env"
}

# ---- daemons ----------------------------------------------------------------

# Runs a daemon with this cluster's marks, and nothing of the caller's open files.
daemon() { # NODE-OR-EMPTY LOG COMMAND…
    local node=$1 log=$2
    shift 2
    env "$DIR_MARK=$dir" "$NODE_MARK=$node" "SLURM_CONF=$dir/slurm.conf" "$@" </dev/null >>"$dir/logs/$log" 2>&1 ||
        die "$1 did not start: $(tail -n3 "$dir/logs/$log")"
}
start_munge() {
    local spool
    spool=$(realpath "$dir/spool")
    (umask 077 && head -c 1024 /dev/urandom >"$dir/munge.key")
    # --force: folders that a group may write are no reason to refuse a test.
    daemon '' munged.out munged --force --num-threads=2 --socket="$spool/munge.socket" --key-file="$dir/munge.key" \
        --seed-file="$dir/munge.seed" --pid-file="$dir/munge.pid" --log-file="$dir/logs/munged.log"
}
start_controller() { daemon '' slurmctld.out slurmctld -f "$dir/slurm.conf"; }
# -b: the node says that it has just booted. Without it the controller would go on
# believing in jobs that were cut off by a power cut that it has not noticed.
start_node() { daemon "$1" "$1.out" slurmd -b -N "$1" -f "$dir/slurm.conf"; }

slurm() { SLURM_CONF=$dir/slurm.conf timeout 10 "$@"; }

# Waits until $1 nodes among $2 (a list) can take jobs.
wait_for_nodes() {
    local deadline=$((SECONDS + UP_DEADLINE_S)) up
    while ((SECONDS < deadline)); do
        up=$(slurm sinfo -h -N -p bench -n "$2" -o '%T' 2>/dev/null | grep -cxE 'idle|mixed|allocated|completing' || true)
        if ((up == $1)); then return 0; fi
        if port_was_taken; then return 1; fi
        sleep 0.2
    done
    return 1
}
port_was_taken() { grep -qs 'Address already in use' "$dir"/logs/*.log; }
show_logs() { tail -n 15 -v "$dir"/logs/*.log "$dir"/logs/*.out >&2; }

# ---- commands ---------------------------------------------------------------

start_once() { # NODES
    local k
    remove_spool
    rm -rf "$dir/state" "$dir/logs" "$dir"/munge.* "$dir/jobcomp.txt" "$dir/slurm.conf" "$dir/env" "$dir"/*.pid
    mkdir -p "$dir/state" "$dir/logs"
    make_spool
    for ((k = 1; k <= $1; k++)); do mkdir "$dir/spool/n$k"; done
    write_configuration "$1"
    start_munge
    start_controller
    for ((k = 1; k <= $1; k++)); do start_node "n$k"; done
    wait_for_nodes "$1" "n[1-$1]"
}

start_cluster() { # NODES
    local attempt status
    [[ $EUID -eq 0 ]] || die 'only root can start a cluster'
    [[ -z $(missing_programs) ]] || die "Slurm is not installed (no $(missing_programs)): run \"$0 install\""
    [[ -z $(pids_of) ]] || die "a cluster runs in $dir already: stop it first"
    mkdir -p "$dir"
    for attempt in 1 2 3; do
        # In a subshell (and not in a condition, where a failure would not end
        # it), so that what is half there is cleaned up here.
        set +e
        (
            set -e
            start_once "$1"
        )
        status=$?
        set -e
        if ((status == 0)); then return; fi
        port_was_taken || break
        cut_power || true
        say "attempt $attempt: somebody took a port before we did"
    done
    show_logs
    stop_cluster || true
    die "the cluster of $1 nodes in $dir did not come up"
}

stop_cluster() {
    cut_power || die "processes are left after $STOP_DEADLINE_S s: $(pids_of | tr '\n' ' ')"
    remove_spool
}

kill_node() { cut_power "$1" || die "processes of $1 are left after $STOP_DEADLINE_S s"; }
restart_node() {
    [[ -z $(pids_of "$1") ]] || die "$1 is running"
    start_node "$1"
    wait_for_nodes 1 "$1" || die "$1 takes no jobs within $UP_DEADLINE_S s: $(tail -n3 "$dir/logs/$1.log")"
}

stop_controller() {
    local pid deadline=$((SECONDS + STOP_DEADLINE_S))
    pid=$(cat "$dir/slurmctld.pid" 2>/dev/null || true)
    has "${pid:-none}" "$DIR_MARK=$dir" || die "no controller runs in $dir"
    kill -TERM "$pid"
    while has "$pid" "$DIR_MARK=$dir"; do
        ((SECONDS < deadline)) || die "slurmctld ($pid) did not end within $STOP_DEADLINE_S s"
        sleep 0.1
    done
}

known_node() {
    grep -q "^NodeName=$1 " "$dir/slurm.conf" 2>/dev/null || usage "no node '$1' in $dir/slurm.conf"
}

main() {
    local command=${1-}
    if [[ $command == install ]]; then
        install_slurm
        return
    fi
    [[ -n ${2-} ]] || usage "expected a command and the cluster's folder"
    dir=$(realpath -m "$2")
    # Slurm's configuration has no way to quote other characters.
    [[ $dir =~ ^[A-Za-z0-9/._+@:-]+$ ]] || usage "a cluster's folder has only letters, digits and . _ + @ : - in its path, not '$dir'"
    case $command in
        start)
            [[ ${3-2} =~ ^[1-9][0-9]?$ ]] || usage "NODES is a number from 1 to 99, not '$3'"
            start_cluster "${3-2}"
            ;;
        kill-node | start-node)
            known_node "${3-}"
            if [[ $command == kill-node ]]; then kill_node "$3"; else restart_node "$3"; fi
            ;;
        stop-ctl) stop_controller ;;
        start-ctl) start_controller ;;
        stop) stop_cluster ;;
        *) usage "no command '$command'" ;;
    esac
}

main "$@"
