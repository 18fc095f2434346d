#!/bin/sh
# Full-batch Levenberg-Marquardt, 500 000 samples x 4 inputs x 30 nodes: this project and NumPy interleaved, on the
# same files from the same initial weights, with the same rule for the damping.
#
#   benches/peers/train.sh [STEPS [ROUNDS [scikit-learn]]]
#
# PYTHON names an interpreter that has requirements.txt installed (default: python3). THREADS (default 2) holds
# for both sides.
set -eu
cd "$(dirname "$0")/../.."
steps=${1:-60} rounds=${2:-3} extra=${3:-}
python=${PYTHON:-python3} threads=${THREADS:-2}
export RAYON_NUM_THREADS="$threads" OPENBLAS_NUM_THREADS="$threads" OMP_NUM_THREADS="$threads"

cargo build --quiet --release -p sinew-identify --example train_paper
sinew=${CARGO_TARGET_DIR:-target}/release/examples/train_paper
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
"$sinew" write "$data"

row() { # name, then the five numbers
    printf '%-14s %9.2f %6d %9d %16s %8.0f\n' "$@"
}
printf '%-14s %9s %6s %9s %16s %8s\n' program seconds steps rejected MSE 'peak MB'
ratios=
for _ in $(seq "$rounds"); do
    ours=$("$sinew" time "$data" "$steps")
    # shellcheck disable=SC2086
    row sinew $ours
    peer=$("$python" benches/peers/train.py numpy "$data" "$steps")
    # shellcheck disable=SC2086
    row numpy $peer
    ratio=$(echo "${ours%% *} ${peer%% *}" | awk '{ printf "%.3f", $1 / $2 }')
    ratios="$ratios $ratio"
done
if [ "$extra" = scikit-learn ]; then
    # An L-BFGS step is one or two gradients: ten of them for one step above.
    # shellcheck disable=SC2046
    row scikit-learn $("$python" benches/peers/train.py scikit-learn "$data" $((10 * steps)))
fi
echo "sinew / numpy, round by round:$ratios"
