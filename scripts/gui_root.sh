#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Makes the folder with the desktop MeshLab that the GUI tests drive: a small Debian system of the
# suite that carries MeshLab 2025.07, used through chroot. Prints the folder. A second run only
# checks it. Usage: scripts/gui_root.sh [--remove]
#
#   SPHEROSEG_GUI_ROOT    the folder, default .cache/meshlab-root of the repository
#   SPHEROSEG_GUI_SUITE   the Debian suite, default forky
#   SPHEROSEG_GUI_MIRROR  the Debian mirror, default the one that this machine's apt uses
set -eu

repository=$(cd "$(dirname "$0")/.." && pwd)
root=${SPHEROSEG_GUI_ROOT:-$repository/.cache/meshlab-root}
suite=${SPHEROSEG_GUI_SUITE:-forky}
wanted_version=2025.07
# MeshLab only recommends the four libraries after it, but without them a modal error of its own
# blocks the start.
packages=meshlab,libmuparser2v5,libqhull-r8.0,lib3ds-1-3,libopenctm1,fonts-dejavu-core
stamp=$root/.complete

fail() {
    echo "gui_root: $*" >&2
    exit 1
}

debian_mirror() {
    apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' \
        'Label: Debian' 2>/dev/null | head -n 1
}

# Debian's dpkg writes the version as 2025.07+dfsg1-...; the tests rely on its first part.
installed_version() {
    dpkg-query --admindir "$1/var/lib/dpkg" --show --showformat '${Version}' meshlab
}

if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "needs root for mmdebstrap and chroot, and there is no sudo"
    exec sudo --preserve-env=SPHEROSEG_GUI_ROOT,SPHEROSEG_GUI_SUITE,SPHEROSEG_GUI_MIRROR "$0" "$@"
fi
if [ "${1:-}" = --remove ]; then
    rm -rf --one-file-system "$root" "$root.partial"
    exit 0
fi
if [ -e "$stamp" ]; then
    echo "$root"
    exit 0
fi

command -v mmdebstrap >/dev/null || fail "mmdebstrap is missing: apt-get install mmdebstrap"
mirror=${SPHEROSEG_GUI_MIRROR:-$(debian_mirror)}
[ -n "$mirror" ] || fail "apt knows no Debian mirror here: run 'apt-get update', or set" \
    "SPHEROSEG_GUI_MIRROR to one that carries $suite"

mkdir -p "$(dirname "$root")"
rm -rf --one-file-system "$root" "$root.partial"
echo "gui_root: making a $suite system with MeshLab in $root (about a minute)" >&2
# Half of debootstrap's time. What it mounts in the folder ends with its mount namespace, after a
# crash too. A snapshot's date says nothing here, its signature is checked.
if ! unshare --mount mmdebstrap --mode=root --variant=apt --include="$packages" \
    --dpkgopt=force-unsafe-io --aptopt='Acquire::Check-Valid-Until "false"' \
    "$suite" "$root.partial" "$mirror" >"$root.log" 2>&1; then
    tail -n 20 "$root.log" >&2
    fail "mmdebstrap failed, its log is $root.log"
fi

version=$(installed_version "$root.partial")
case $version in
$wanted_version*) ;;
*) fail "$suite carries MeshLab $version, the tests need $wanted_version:" \
    "set SPHEROSEG_GUI_SUITE or SPHEROSEG_GUI_MIRROR to where it is" ;;
esac

# Where a test session mounts its own folders.
mkdir -p "$root.partial/home/user" "$root.partial/tmp/.X11-unix"
rm -rf "$root.partial/usr/share/doc" "$root.partial/usr/share/man" \
    "$root.partial/usr/share/locale"
echo "$suite meshlab $version" >"$root.partial/.complete"
mv "$root.partial" "$root"
rm -f "$root.log"
echo "$root"
