#!/bin/sh
# A cable in its sheath: this project's step and MuJoCo's nearest models, interleaved in one run.
#
#   benches/peers/cable.sh [ROUNDS]
#
# PYTHON names an interpreter that has requirements.txt installed (default: python3); with `newton` in it, that too is timed.
set -eu
cd "$(dirname "$0")/../.."
rounds=${1:-3} python=${PYTHON:-python3}
cargo bench --quiet -p sinew --bench cable --no-run
for round in $(seq "$rounds"); do
    echo "round $round"
    cargo bench --quiet -p sinew --bench cable -- fifteen
    "$python" benches/peers/cable.py
done
# Newton has its own capstan tendon, slow to compile: once is enough.
if "$python" -c "import newton" 2>/dev/null; then "$python" benches/peers/cable_newton.py; fi
