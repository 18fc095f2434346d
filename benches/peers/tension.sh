#!/bin/sh
# Tension distribution: this project, DAQP, quadprog, Clarabel and a least-squares oracle on the same random problems.
#
#   benches/peers/tension.sh [PROBLEMS]
#
# PYTHON names an interpreter that has requirements.txt installed; without it, one is made in target/peers.
set -eu
cd "$(dirname "$0")/../.."
target=${CARGO_TARGET_DIR:-target}
cargo build --quiet --release -p sinew-cli
cargo build --quiet --release --manifest-path benches/peers/tension_clarabel/Cargo.toml --target-dir "$target/peers"
if [ -z "${PYTHON:-}" ]; then
    PYTHON=$target/peers/python/bin/python3
    if ! "$PYTHON" -c "import daqp, numpy, quadprog, scipy" 2>/dev/null; then
        python3 -m venv "$target/peers/python"
        grep -E "^(daqp|numpy|quadprog|scipy)=" benches/peers/requirements.txt >"$target/peers/requirements.txt"
        "$PYTHON" -m pip install --quiet -r "$target/peers/requirements.txt"
    fi
fi
export OPENBLAS_NUM_THREADS=1
"$PYTHON" benches/peers/tension.py "$target/release/sinew" "$target/peers/release/tension-clarabel" "${1:-10000}"
