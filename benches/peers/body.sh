#!/bin/sh
# Muscle geometry and inverse dynamics: this project and MuJoCo, dynibo and Pinocchio interleaved, on the same robots.
#
#   benches/peers/body.sh ROBOT.xml [ROUNDS]
#
# The robot's name is its file's: one of those that crates/sinew/benches/body.rs lists (lm_arm, myoarm). lm_arm itself
# is measured in every run, and so is inverse dynamics of seven joints.
# PYTHON names an interpreter that has requirements.txt installed (default: python3). Pinocchio is also called from C++
# where g++ and pip's headers (cmeel-eigen beside pin) are at hand.
set -eu
cd "$(dirname "$0")/../.."
robot=$1 rounds=${2:-3} python=${PYTHON:-python3} target=${CARGO_TARGET_DIR:-target}
golden=$(mktemp -d)
trap 'rm -rf "$golden"' EXIT
cargo run --quiet -p sinew-cli -- arm convert lm_arm "$golden/lm_arm.xml" >"$golden/said"
"$python" benches/peers/body_golden.py "$golden" "$robot" "$golden/lm_arm.xml" --poses 64 >"$golden/made"
cargo bench --quiet -p sinew --bench body --no-run
cargo build --quiet --release --manifest-path benches/peers/dynibo/Cargo.toml --target-dir "$target/peers"
"$python" - "$golden" <<'PYTHON'
import json, sys, pinocchio
arm = json.load(open("crates/sinew/tests/sinew/description/pinocchio.json"))["robots"][0]
open(sys.argv[1] + "/arm.urdf", "w").write(arm["urdf"])
pinocchio.buildModelFromUrdf(sys.argv[1] + "/arm.urdf").saveToText(sys.argv[1] + "/arm.txt")
PYTHON
cmeel=$("$python" -c 'import cmeel, pathlib; print(pathlib.Path(cmeel.__file__).parents[1] / "cmeel.prefix")')
# Limits as pip's CMake files of Pinocchio have them.
g++ -O3 -march=native -DNDEBUG -std=c++17 -DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 \
    -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS -DBOOST_FUSION_INVOKE_MAX_ARITY=12 -I"$cmeel/include" \
    -I"$cmeel/include/eigen3" benches/peers/pinocchio.cpp -L"$cmeel/lib" -lpinocchio_default -lboost_serialization \
    -Wl,-rpath,"$cmeel/lib" -o "$golden/pinocchio" 2>"$golden/compiler" || echo "no Pinocchio from C++ here"
export SINEW_BODY_GOLDEN="$golden"
for round in $(seq "$rounds"); do
    echo "round $round"
    cargo bench --quiet -p sinew --bench body -- muscles
    cargo bench --quiet -p sinew --bench body -- inverse_dynamics
    "$target/peers/release/sinew-peer-dynibo"
    if [ -x "$golden/pinocchio" ]; then "$golden/pinocchio" "$golden/arm.txt"; fi
    for file in "$robot" "$golden/lm_arm.xml"; do
        echo "$(basename "$file")"
        "$python" benches/peers/body.py "$file"
    done
done
