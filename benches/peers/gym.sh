#!/bin/sh
# Vector environments with sheaths, drives and sensors beside MuJoCo's batches of the same arm without any of them.
#
#   benches/peers/gym.sh [ENVIRONMENTS] [ROUNDS]
#
# PYTHON names an interpreter that has a release build of this package, gymnasium and mujoco; without it, one is made in target/peers.
set -eu
cd "$(dirname "$0")/../.."
target=${CARGO_TARGET_DIR:-target}
if [ -z "${PYTHON:-}" ]; then
    PYTHON=$target/peers/gym/bin/python3
    [ -x "$PYTHON" ] || python3 -m venv "$target/peers/gym"
    grep -E "^(numpy|mujoco|gymnasium)=" benches/peers/requirements.txt >"$target/peers/gym/requirements.txt"
    "$PYTHON" -m pip install --quiet -r "$target/peers/gym/requirements.txt" .
fi
export OPENBLAS_NUM_THREADS=1
"$PYTHON" benches/peers/gym.py "$@"
