#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Installs what is missing to build and run (setup.sh run), also to test (setup.sh dev), or also to
# drive the MeshLab application on a virtual screen (setup.sh gui):
# system packages by apt, pinned Python packages in .venv, MeshLab's headers in .cache, and the
# application where scripts/gui_root.sh puts it.
# What is there already is left alone, so that a second run takes a moment.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
readonly level="${1:-dev}"
readonly venv="$root/.venv"

run_packages=(g++ cmake ninja-build python3 python3-venv git ca-certificates xz-utils
    qtbase5-dev libqt5opengl5-dev libglew-dev libeigen3-dev libglu1-mesa-dev libopengl0)
gui_packages=(mmdebstrap xvfb openbox xdotool x11-utils xclip)
dev_packages=(libgtest-dev clang libomp-dev libegl1 ccache)
# Elsewhere Chromium is no ordinary package; the tests of the report then skip, or fail in CI.
if grep -qs '^ID=debian' /etc/os-release; then dev_packages+=(chromium chromium-driver); fi

say() { echo "setup: $*"; }

case "$level" in
run) packages=("${run_packages[@]}") ;;
dev) packages=("${run_packages[@]}" "${dev_packages[@]}") ;;
gui) packages=("${run_packages[@]}" "${dev_packages[@]}" "${gui_packages[@]}") ;;
*)
    say "expected run, dev or gui, found '$level'" >&2
    exit 2
    ;;
esac

# One at a time, as with `make -j`.
exec 9<"${BASH_SOURCE[0]}"
if command -v flock >/dev/null; then flock 9; fi

name_packages_and_stop() {
    cat >&2 <<END
setup: $1
setup: install these, then run again with SPHEROSEG_SKIP_PACKAGES=1:
    a C++17 compiler with OpenMP, CMake 3.22 or later, Ninja, git, xz,
    Python 3.11 or later with venv,
    the development files of Qt 5.15 (Core, Gui, Widgets, Xml, OpenGL), GLEW, GLU and Eigen 3.3,
    for the tests also GoogleTest, clang with its OpenMP library and Chromium with its driver
    (ccache, where it is there, saves time).
  On Debian and Ubuntu: ${packages[*]}
END
    exit 1
}

install_packages() {
    local missing=() package
    for package in "${packages[@]}"; do
        dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null |
            grep -qx installed || missing+=("$package")
    done
    [ ${#missing[@]} -eq 0 ] && return
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null ||
            name_packages_and_stop "packages are missing (${missing[*]}), and there is no sudo"
        as_root=(sudo)
    fi
    say "installing ${missing[*]}"
    "${as_root[@]}" apt-get -qq update
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get -qq install --yes --no-install-recommends "${missing[@]}" >/dev/null
}

if [ -z "${SPHEROSEG_SKIP_PACKAGES:-}" ]; then
    if command -v apt-get >/dev/null && command -v dpkg-query >/dev/null; then
        install_packages 9<&- # no service that a package starts keeps the lock
    else
        name_packages_and_stop "this system has no apt"
    fi
fi

python="${PYTHON:-python3}"
if [ ! -x "$venv/bin/pip" ]; then # which comes last
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
        say "$python is older than 3.11; set PYTHON to a later one" >&2
        exit 1
    }
    say "making .venv"
    "$python" -m venv "$venv"
fi

# The stamp lies inside the environment, which several checkouts may share by a symbolic link.
python_level="${level/gui/dev}"
requirements="$root/requirements/$python_level.txt"
stamp="$venv/.spheroseg-$python_level"
wanted=$(cat "$root"/requirements/*.txt | sha256sum)
if [ "$(cat "$stamp" 2>/dev/null)" != "$wanted" ]; then
    say "installing Python packages (requirements/$python_level.txt)"
    # Meanwhile the rest is done. The process group is its own, to be ended as a whole.
    set -m
    # Most modules are never imported; Python compiles the others as they are.
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile \
        --requirement "$requirements" </dev/null &
    installation=$!
    set +m
    trap 'kill -- "-$installation" 2>/dev/null || true' EXIT
fi
if [ ! -L "$venv" ]; then
    # The package runs from the checkout: no second installation that could grow stale.
    # By a relative path: with LC_ALL=C Python dies of letters beyond ASCII there.
    "$venv/bin/python" - "$root/python" <<'END'
import os, pathlib, sys, sysconfig
site = sysconfig.get_path("purelib")
path = os.path.relpath(sys.argv[1], site)
pathlib.Path(site, "spheroseg-checkout.pth").write_text(path + "\n")
END
    install -m 755 "$root/scripts/spheroseg.sh" "$venv/bin/spheroseg"
fi

"$root/scripts/fetch_meshlab_headers.sh" >/dev/null
if [ "$level" = gui ]; then "$root/scripts/gui_root.sh" >/dev/null; fi

if [ -n "${installation:-}" ]; then
    wait "$installation"
    trap - EXIT
    echo "$wanted" >"$stamp"
fi
