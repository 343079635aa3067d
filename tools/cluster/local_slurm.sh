#!/bin/sh
# A Slurm cluster of several nodes on one machine, to try workflows on.
#
#   local_slurm.sh start DIR [NODES]    starts NODES nodes (3), their state in DIR
#   local_slurm.sh kill DIR NODE        node NODE (1, 2 ...) dies: all its processes, then its network
#   local_slurm.sh revive DIR NODE      and comes back
#   local_slurm.sh stop DIR             stops everything
#
# Every node is a network namespace with an address and a host name of its own, joined by a bridge; the controller is
# outside. Where the kernel has no namespaces, nodes share the machine's network and differ by their ports (Slurm calls
# this "multiple slurmd support"; Debian's packages have it). The script says which it is.
#
# Needs root and Debian's packages: apt-get install slurmctld slurmd slurm-client munge
# Where there is no /etc/slurm/slurm.conf, it becomes a link to the one in DIR until the cluster stops: engines clear
# SLURM_CONF from the environment of their jobs. Where there is one, this machine is part of a cluster: it refuses.
set -eu

command=${1:-}
[ $# -ge 2 ] || { sed -n '2,/^set/p' "$0" | grep '^#' | cut -c3-; exit 2; }
mkdir -p "$2"
dir=$(cd "$2" && pwd)
subnet=10.77.0
bridge=mesotex0

name_of() { echo "mesotex-node$1"; }

# Namespaces need more than a kernel that knows them: links must be allowed too.
has_namespaces() {
    ip netns add mesotex-try 2>/dev/null || return 1
    if ip link add mtry0 type veth peer name mtry1 netns mesotex-try 2>/dev/null; then
        ip link del mtry0
        ip netns del mesotex-try
        return 0
    fi
    ip netns del mesotex-try
    return 1
}

add_network() {
    ip link add $bridge type bridge
    ip addr add $subnet.1/24 dev $bridge
    ip link set $bridge up
}

add_namespace() {
    space=$(name_of "$1")
    ip netns add "$space"
    ip link add "mtx$1" type veth peer name eth0 netns "$space"
    ip link set "mtx$1" master $bridge up
    ip -n "$space" addr add "$subnet.$((10 + $1))/24" dev eth0
    ip -n "$space" link set eth0 up
    ip -n "$space" link set lo up
}

write_configuration() {
    nodes=$1
    if [ "$mode" = namespaces ]; then
        host="SlurmctldHost=$(hostname -s)($subnet.1)"
        last=$((10 + nodes))
        machines="NodeName=node[1-$nodes] NodeAddr=$subnet.[11-$last] CPUs=1 RealMemory=4000"
    else
        host="SlurmctldHost=$(hostname -s)(127.0.0.1)"
        last=$((17100 + nodes))
        machines="NodeName=node[1-$nodes] NodeAddr=127.0.0.1 Port=[17101-$last] CPUs=1 RealMemory=4000"
    fi
    cat > "$dir/slurm.conf" <<CONF
ClusterName=mesotex
$host
SlurmctldPort=17817
SlurmdPort=17818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool-%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd-%n.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
# A dead node is noticed within seconds, and what ran there is put in the queue again.
SlurmdTimeout=15
MessageTimeout=10
JobRequeue=1
ReturnToService=2
# Snakemake asks squeue about jobs that are finished, too.
MinJobAge=3600
MaxArraySize=10001
MaxJobCount=20000
SchedulerParameters=bf_interval=5,sched_interval=5
$machines State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    # No groups are used; without this slurmd looks for a mounted /sys/fs/cgroup, which containers lack.
    echo "CgroupPlugin=cgroup/v1" > "$dir/cgroup.conf"
}

start_munge() {
    [ -f "$dir/munge.key" ] || head -c 1024 /dev/urandom > "$dir/munge.key"
    chmod 600 "$dir/munge.key"
    munged --force --key-file="$dir/munge.key" --socket="$dir/munge.socket" --pid-file="$dir/munged.pid" \
        --log-file="$dir/munged.log" --seed-file="$dir/munged.seed" 2> "$dir/munged.err"
}

start_node() {
    mkdir -p "$dir/spool-node$1"
    if [ "$(cat "$dir/mode")" = namespaces ]; then
        ip -n "$(name_of "$1")" link set eth0 up
        ip netns exec "$(name_of "$1")" unshare --uts \
            sh -c "hostname node$1 && exec slurmd -f $dir/slurm.conf -N node$1"
    else
        slurmd -f "$dir/slurm.conf" -N "node$1"
    fi
}

# All processes of a node: of its namespace, or of its slurmd.
processes_of() {
    if [ "$(cat "$dir/mode")" = namespaces ]; then
        ip netns pids "$(name_of "$1")" 2>/dev/null || true
    else
        pid=$(cat "$dir/slurmd-node$1.pid" 2>/dev/null) || return 0
        echo "$pid"
        # Steps detach from slurmd; they name its spool folder.
        for step in $(pgrep -f "slurmstepd.*" || true); do
            grep -qz "node$1" "/proc/$step/environ" 2>/dev/null && echo "$step" && pgrep -P "$step"
        done
    fi
}

kill_node() {
    pids=$(processes_of "$1")
    [ -z "$pids" ] || kill -9 $pids 2>/dev/null || true
    [ "$(cat "$dir/mode")" != namespaces ] || ip -n "$(name_of "$1")" link set eth0 down 2>/dev/null || true
}

etc=/etc/slurm

link_configuration() {
    for file in slurm.conf cgroup.conf; do
        ln -sf "$dir/$file" "$etc/$file"
    done
}

unlink_configuration() {
    for file in slurm.conf cgroup.conf; do
        [ "$(readlink "$etc/$file")" != "$dir/$file" ] || rm "$etc/$file"
    done
}

start() {
    nodes=${1:-3}
    if [ -e $etc/slurm.conf ]; then
        echo "$etc/slurm.conf is there: this machine is part of a cluster already" >&2
        exit 1
    fi
    mode=ports
    if has_namespaces; then mode=namespaces; fi
    echo $mode > "$dir/mode"
    echo "$nodes" > "$dir/nodes"
    mkdir -p "$dir/state"
    write_configuration "$nodes"
    link_configuration
    start_munge
    [ $mode != namespaces ] || add_network
    slurmctld -f "$dir/slurm.conf"
    for node in $(seq "$nodes"); do
        [ $mode != namespaces ] || add_namespace "$node"
        start_node "$node"
    done
    for try in $(seq 60); do
        idle=$(sinfo -h -N -o %T 2>/dev/null | grep -c '^idle$' || true)
        [ "$idle" != "$nodes" ] || break
        sleep 1
    done
    sinfo -N -o '%N %T %c CPU %m MB'
    [ "$idle" = "$nodes" ] || { echo "only $idle of $nodes nodes are up; see $dir/*.log" >&2; exit 1; }
    case $mode in
        namespaces) echo "every node is a network namespace" ;;
        ports) echo "nodes differ by their ports: this kernel allows no network namespaces" ;;
    esac
}

stop() {
    for node in $(seq "$(cat "$dir/nodes")"); do
        kill_node "$node"
    done
    for daemon in slurmctld munged; do
        pid=$(cat "$dir/$daemon.pid" 2>/dev/null) && kill "$pid" 2>/dev/null || true
    done
    if [ "$(cat "$dir/mode")" = namespaces ]; then
        for node in $(seq "$(cat "$dir/nodes")"); do
            ip netns del "$(name_of "$node")" 2>/dev/null || true
            ip link del "mtx$node" 2>/dev/null || true
        done
        ip link del $bridge 2>/dev/null || true
    fi
    unlink_configuration
}

case $command in
    start) start "${3:-3}" ;;
    kill) kill_node "$3" ;;
    revive) start_node "$3" ;;
    stop) stop ;;
    *) echo "$0: $command: expected start, kill, revive or stop" >&2; exit 2 ;;
esac
