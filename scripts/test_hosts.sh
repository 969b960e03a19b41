#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Builds the plugin for earlier PyMeshLab releases and runs the plugin's tests in each of them.
# Usage: scripts/test_hosts.sh [RELEASE...], default all below. Environments are kept in .cache.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
cd "$root"

say() { echo "hosts: $*"; }

# PyMeshLab release -> MeshLab release inside it, and the NumPy that it was compiled for.
meshlab_of() {
    case "$1" in
    2022.2.post4) echo "2022.02 numpy==1.26.4" ;;
    2023.12.post3) echo "2023.12 numpy==2.4.6" ;;
    2025.7.post1) echo "2025.07 numpy==2.4.6" ;;
    *)
        say "no such PyMeshLab release is known here: $1" >&2
        exit 2
        ;;
    esac
}

# Prints the folder with the headers to build with. The interface of 2022.02 and 2025.07 is the
# same, so the newer headers serve for a release between them that can not be fetched.
headers_of() {
    scripts/fetch_meshlab_headers.sh "$1" 2>/dev/null || {
        say "MeshLab $1 can not be fetched; its neighbour's headers are used" >&2
        scripts/fetch_meshlab_headers.sh
    }
}

test_host() {
    local pymeshlab=$1 versions meshlab numpy headers venv library
    versions=$(meshlab_of "$pymeshlab")
    read -r meshlab numpy <<<"$versions"
    venv=".cache/hosts/pymeshlab-$pymeshlab"
    if [ ! -e "$venv/.complete" ]; then
        say "making $venv"
        "${PYTHON:-.venv/bin/python}" -m venv --clear "$venv"
        "$venv/bin/python" -m pip install --quiet --disable-pip-version-check \
            "pymeshlab==$pymeshlab" "$numpy" rich==15.0.0 pytest==9.2.0 hypothesis==6.170.15
        touch "$venv/.complete"
    fi
    headers=$(headers_of "$meshlab" | tail -n 1)
    library=$("$venv/bin/python" -c "import importlib.util as u; \
print(u.find_spec('pymeshlab').submodule_search_locations[0])")/lib/libmeshlab-common.so
    cmake --preset plugin -B "build/host-$pymeshlab" -DMESHLAB_SOURCE_DIR="$headers" \
        -DSPHEROSEG_MESHLAB_RELEASE="$meshlab" -DSPHEROSEG_MESHLAB_COMMON="$library" >/dev/null
    cmake --build "build/host-$pymeshlab" --target filter_spheroseg
    say "PyMeshLab $pymeshlab, headers of $(cat "$headers/ML_VERSION")"
    SPHEROSEG_PLUGIN="$root/build/host-$pymeshlab/libfilter_spheroseg.so" \
        "$venv/bin/python" -m pytest tests/plugin
}

[ $# -gt 0 ] || set -- 2022.2.post4 2023.12.post3
failed=()
for release in "$@"; do
    # In a process of its own: the shell ignores `set -e` in what stands before ||.
    bash -c "$(declare -f say meshlab_of headers_of test_host); set -euo pipefail
        root=\$1; test_host \"\$2\"" bash "$root" "$release" || failed+=("$release")
done
[ ${#failed[@]} -eq 0 ] || {
    say "failed: ${failed[*]}" >&2
    exit 1
}
