#!/bin/sh
# Tension distribution: this project, DAQP, quadprog and a least-squares oracle on the same random problems.
#
#   benches/peers/tension.sh [PROBLEMS]
#
# PYTHON names an interpreter that has requirements.txt installed (default: python3).
set -eu
cd "$(dirname "$0")/../.."
cargo build --quiet --release -p sinew-cli
export OPENBLAS_NUM_THREADS=1
"${PYTHON:-python3}" benches/peers/tension.py "${CARGO_TARGET_DIR:-target}/release/sinew" "${1:-10000}"
