#!/bin/sh
# Sets of joint torques: this project and pycapacity on the same random muscles, without friction.
#
#   benches/peers/capability.sh [PROBLEMS]
#
# PYTHON names an interpreter that has requirements.txt installed; without it, one is made in target/peers.
set -eu
cd "$(dirname "$0")/../.."
target=${CARGO_TARGET_DIR:-target}
cargo build --quiet --release -p sinew --example torque_set
if [ -z "${PYTHON:-}" ]; then
    PYTHON=$target/peers/python/bin/python3
    if ! "$PYTHON" -c "import numpy, pycapacity" 2>/dev/null; then
        python3 -m venv "$target/peers/python"
        grep -E "^(numpy|pycapacity)=" benches/peers/requirements.txt >"$target/peers/requirements.txt"
        "$PYTHON" -m pip install --quiet -r "$target/peers/requirements.txt"
    fi
fi
export OPENBLAS_NUM_THREADS=1
"$PYTHON" benches/peers/capability.py "$target/release/examples/torque_set" "${1:-20}"
