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

# A crash may have left /proc mounted in it; removing the folder would then reach into the host.
remove_tree() {
    while grep -q " $1/proc " /proc/mounts; do
        umount "$1/proc" || fail "$1/proc is mounted and cannot be unmounted"
    done
    rm -rf --one-file-system "$1"
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
    command -v sudo >/dev/null || fail "needs root for debootstrap and chroot, and there is no sudo"
    exec sudo --preserve-env=SPHEROSEG_GUI_ROOT,SPHEROSEG_GUI_SUITE,SPHEROSEG_GUI_MIRROR "$0" "$@"
fi
if [ "${1:-}" = --remove ]; then
    remove_tree "$root"
    remove_tree "$root.partial"
    exit 0
fi
if [ -e "$stamp" ]; then
    echo "$root"
    exit 0
fi

command -v debootstrap >/dev/null || fail "debootstrap is missing: apt-get install debootstrap"
mirror=${SPHEROSEG_GUI_MIRROR:-$(debian_mirror)}
[ -n "$mirror" ] || fail "apt knows no Debian mirror here: run 'apt-get update', or set" \
    "SPHEROSEG_GUI_MIRROR to one that carries $suite"

mkdir -p "$(dirname "$root")"
remove_tree "$root.partial"
remove_tree "$root"
trap 'umount "$root.partial/proc" 2>/dev/null || true' EXIT
echo "gui_root: making a $suite system with MeshLab in $root (about a minute)" >&2
# The last argument: an older debootstrap knows no script of the suite's name, sid's fits.
if ! debootstrap --variant=minbase --include="$packages" "$suite" "$root.partial" "$mirror" sid \
    >"$root.log" 2>&1; then
    tail -n 20 "$root.log" >&2
    fail "debootstrap failed, its log is $root.log"
fi
umount "$root.partial/proc" 2>/dev/null || true

version=$(installed_version "$root.partial")
case $version in
$wanted_version*) ;;
*) fail "$suite carries MeshLab $version, the tests need $wanted_version:" \
    "set SPHEROSEG_GUI_SUITE or SPHEROSEG_GUI_MIRROR to where it is" ;;
esac

# Where a test session mounts its own folders; and nothing of apt's caches is needed any more.
mkdir -p "$root.partial/home/user" "$root.partial/tmp/.X11-unix"
rm -rf "$root.partial/var/cache/apt/archives" "$root.partial/var/lib/apt/lists" \
    "$root.partial/usr/share/doc" "$root.partial/usr/share/man" "$root.partial/usr/share/locale"
echo "$suite meshlab $version" >"$root.partial/.complete"
mv "$root.partial" "$root"
rm -f "$root.log"
echo "$root"
