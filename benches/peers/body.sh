#!/bin/sh
# Muscle geometry and inverse dynamics: this project and MuJoCo (and Pinocchio) by turns, on the same robot.
#
#   benches/peers/body.sh ROBOT.xml [ROUNDS]
#
# The robot's name is its file's: one of those that crates/sinew/benches/body.rs lists (lm_arm, myoarm).
# PYTHON names an interpreter that has requirements.txt installed (default: python3).
set -eu
cd "$(dirname "$0")/../.."
robot=$1 rounds=${2:-3} python=${PYTHON:-python3}
golden=$(mktemp -d)
trap 'rm -rf "$golden"' EXIT
"$python" benches/peers/body_golden.py "$golden" "$robot" --poses 64 >"$golden/made"
cargo bench --quiet -p sinew --bench body --no-run
export SINEW_BODY_GOLDEN="$golden"
for round in $(seq "$rounds"); do
    echo "round $round"
    cargo bench --quiet -p sinew --bench body -- muscles
    cargo bench --quiet -p sinew --bench body -- inverse_dynamics
    "$python" benches/peers/body.py "$robot"
done
