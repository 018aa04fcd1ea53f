#!/usr/bin/env bash
# cluster.sh start|stop FOLDER: a Slurm cluster of one node in a folder: munged, slurmctld, slurmd; without accounting. Needs root and the packages slurm-wlm and munge.
# Its processes are those of the .pid files in the folder, and it has ports of its own. SLURM_CONF=FOLDER/slurm.conf makes sbatch, squeue and scancel talk to it.
set -euo pipefail
what=$1
folder=$(realpath -m "$2")
socket=$folder/munge/munge.socket

start() {
  mkdir -p "$folder"/{munge,state,spool,log}
  # munged refuses folders that others may write to, and runs as its own user.
  chmod 755 "$folder" && chmod 711 "$folder/munge"
  dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 2> /dev/null
  chmod 600 "$folder/munge/key"
  munged --force --socket="$socket" --key-file="$folder/munge/key" --log-file="$folder/munge/log" --pid-file="$folder/munged.pid" --seed-file="$folder/munge/seed"
  local host port
  host=$(hostname -s)
  port=$((20000 + RANDOM % 20000))
  cat > "$folder/slurm.conf" << CONF
ClusterName=ajar
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
AuthType=auth/munge
AuthInfo=socket=$socket
CredType=cred/munge
SlurmUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/log/slurmctld
SlurmdLogFile=$folder/log/slurmd
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=1
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
KillWait=10
MinJobAge=300
JobRequeue=1
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  export SLURM_CONF=$folder/slurm.conf
  slurmctld
  slurmd
  for _ in $(seq 100); do
    [ "$(sinfo --noheader --format %T 2> /dev/null)" = idle ] && return 0
    sleep 0.2
  done
  echo "The node does not come up; see $folder/log." >&2
  stop
  return 1
}

stop() {
  for name in slurmd slurmctld munged; do
    [ -f "$folder/$name.pid" ] || continue
    kill "$(cat "$folder/$name.pid")" 2> /dev/null || true
  done
  for name in slurmd slurmctld munged; do
    for _ in $(seq 100); do
      { [ -f "$folder/$name.pid" ] && kill -0 "$(cat "$folder/$name.pid")" 2> /dev/null; } || break
      sleep 0.1
    done
  done
}

case $what in
  start) start ;;
  stop) stop ;;
  *) echo "cluster.sh start|stop FOLDER" >&2; exit 2 ;;
esac
