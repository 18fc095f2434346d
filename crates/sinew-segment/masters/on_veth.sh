#!/bin/sh
# Runs a master against `examples/serve.rs` over a pair of virtual interfaces in a network of its own, without privileges:
#   on_veth.sh SERVE_PROGRAM [DRIVES [ENCODERS]] -- MASTER_COMMAND...     the master's interface is veth-master
set -eu
serve=$1
drives=
shift
while [ "$1" != "--" ]; do
    drives="$drives $1"
    shift
done
shift
export serve drives
exec unshare -Urn sh -eu -c '
    ip link add veth-master type veth peer name veth-line
    ip link set veth-master up
    ip link set veth-line up
    mkfifo "${TMPDIR:-/tmp}/serve.$$"
    "$serve" veth-line $drives < "${TMPDIR:-/tmp}/serve.$$" &
    served=$!
    exec 9> "${TMPDIR:-/tmp}/serve.$$"
    rm "${TMPDIR:-/tmp}/serve.$$"
    result=0
    "$@" || result=$?
    exec 9>&-
    wait $served
    exit $result
' sh "$@"
