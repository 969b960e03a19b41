#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The one command for a machine with a GPU: scripts/gpu_check.sh [MESH...]
# Builds the engine and the kernels (a C++17 compiler, CMake and nvcc are enough), runs the tests
# labelled gpu, the memory and race checkers, the bench and the profiler as far as they are there,
# and writes everything to $OUT/gpu_check.md (OUT: build/gpu_check), to paste into docs/gpu.md.
# Exit status 0: everything that could run passed, and labels are those of the cores.
set -uo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
out="${OUT:-$PWD/build/gpu_check}"
build="${BUILD:-$PWD/build/gpu}"
report="$out/gpu_check.md"
mkdir -p "$out"
: >"$report"
status=0

note() { echo "$*" | tee -a "$report"; }

# section NAME COMMAND...: its output as a block of the report; its failure is the script's, as is
# one that takes longer than SECTION_SECONDS.
section() {
    note "" && note "## $1" && note '```'
    shift
    timeout "${SECTION_SECONDS:-300}" "$@" 2>&1 | tail -n "${LINES_KEPT:-80}" | tee -a "$report"
    local result=${PIPESTATUS[0]}
    note '```'
    [ "$result" -eq 0 ] && return
    note "**Failed with status $result.**"
    status=1
}

note "# GPU check of $(git log -1 --format=%h 2>/dev/null || echo 'an unknown commit')"
section Device nvidia-smi --query-gpu=name,driver_version,memory.total,compute_cap --format=csv
tests=ON
[ -n "$(find /usr /opt -name 'GTestConfig.cmake' -print -quit 2>/dev/null)" ] || tests=OFF
cmake -S . -B "$build" -DSPHEROSEG_BUILD_PLUGIN=OFF -DSPHEROSEG_BUILD_TOOLS=ON -DSPHEROSEG_CUDA=ON \
    -DSPHEROSEG_BUILD_TESTS=$tests ${CUDA_ARCHITECTURES:+-DCMAKE_CUDA_ARCHITECTURES=$CUDA_ARCHITECTURES} \
    >"$out/configure.log" 2>&1 &&
    cmake --build "$build" --parallel "$(nproc)" --target spheroseg-bench >"$out/build.log" 2>&1 || {
    tail -20 "$out/configure.log" "$out/build.log" 2>/dev/null
    note "The build failed: see $out."
    exit 1
}
bench="$build/tools/spheroseg-bench"
export OMP_WAIT_POLICY=passive

if [ $tests = ON ] && cmake --build "$build" --parallel "$(nproc)" --target cuda_tests \
    >>"$out/build.log" 2>&1; then
    section "Tests" "$build/tests/cuda/cuda_tests" --gtest_filter='Gpu.*'
else
    note "GoogleTest is not installed: the bench compares the labels below."
fi

section "Labels and times, k = 200" "$bench" --require-gpu sample_meshes/*.ply sphere:4 bumpy:5 "$@"
section "Many sub-meshes, other seed" "$bench" --require-gpu --k 999 --seed 7 sample_meshes/*.ply
section "Few sub-meshes, odd k" "$bench" --require-gpu --k 3 sample_meshes/*.ply
section "327,680 triangles, GPU alone" "$bench" --require-gpu --repeats 1 bumpy:7
section "Fast, k = 200" "$bench" --fast --require-gpu --cores-up-to 2000000 sample_meshes/*.ply bumpy:5 "$@"
section "Fast, 64 triangles per sub-mesh" "$bench" --fast --per 64 --require-gpu \
    --cores-up-to 2000000 bumpy:5 bumpy:7 bumpy:8 "$@"

if command -v compute-sanitizer >/dev/null; then
    for tool in memcheck racecheck initcheck synccheck; do
        LINES_KEPT=15 section "compute-sanitizer $tool" compute-sanitizer --tool "$tool" \
            --error-exitcode 9 "$bench" --require-gpu --repeats 1 --iterations 2 --k 50 sphere:3
        LINES_KEPT=15 section "compute-sanitizer $tool, fast" compute-sanitizer --tool "$tool" \
            --error-exitcode 9 "$bench" --fast --require-gpu --repeats 1 --k 100 sphere:3
    done
else
    note "compute-sanitizer is not installed: memory and races were not checked."
fi

if command -v ncu >/dev/null; then
    # The clocks are left as they are.
    for kernel in play_cohesion_tiles find_round decide_round commit_round; do
        LINES_KEPT=250 section "ncu $kernel" ncu --clock-control none \
            --section SpeedOfLight --section Occupancy --section LaunchStats \
            --kernel-name "$kernel" --launch-skip 20 --launch-count 2 \
            "$bench" --require-gpu --repeats 1 --iterations 1 --cores-up-to 0 bumpy:5
    done
    for kernel in anneal_groups exchange_groups; do
        LINES_KEPT=250 section "ncu $kernel" ncu --clock-control none \
            --section SpeedOfLight --section Occupancy --section LaunchStats \
            --kernel-name "$kernel" --launch-skip 4 --launch-count 2 \
            "$bench" --fast --per 64 --require-gpu --repeats 1 --cores-up-to 0 bumpy:7
    done
else
    note "ncu is not installed: occupancy and throughput were not read."
fi
note "" && note "Status: $([ $status -eq 0 ] && echo passed || echo FAILED). Report: $report"
exit $status
