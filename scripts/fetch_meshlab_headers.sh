#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Puts the sources of a MeshLab release (headers, vcglib included) into .cache/meshlab-RELEASE.
# Usage: fetch_meshlab_headers.sh [RELEASE], default 2025.07.
# Tried in order: $MESHLAB_SOURCE_DIR, a copy fetched before, upstream's tag, the Debian (or
# Ubuntu) source package. Prints the folder on the last line. Nothing is done twice.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
readonly release=${1:-2025.07}
readonly cache="$root/.cache"
readonly target="$cache/meshlab-$release"
readonly upstream=https://github.com/cnr-isti-vclab/meshlab
readonly git_seconds=60
# The source packages that hold upstream's files, vcglib included: SHA-256 of the tarball, suites.
case "$release" in
2025.07)
    readonly tarball_sha256=d22c98d362f2a284e481af8dbfc272b2222f5b9c67b3cf8bec57d1c3161886f4
    readonly debian_suites="sid testing" ubuntu_suites="devel"
    ;;
2022.02)
    readonly tarball_sha256=11da26ec46c3fbbbc806d410a3221542ec21ec13fdcc55d624304600029435fd
    readonly debian_suites="trixie" ubuntu_suites=""
    ;;
*) readonly tarball_sha256="" debian_suites="" ubuntu_suites="" ;;
esac

say() { echo "headers: $*" >&2; }

has_headers() {
    [ -f "$1/src/common/plugins/interfaces/filter_plugin.h" ] &&
        [ -f "$1/src/vcglib/vcg/complex/complex.h" ]
}

is_release() { grep -qs "^$release" "$1/ML_VERSION"; }

# Moves a finished tree into place; a broken download never gets there.
keep() {
    if ! has_headers "$1" || ! is_release "$1"; then
        say "what was fetched is not MeshLab $release with vcglib"
        return 1
    fi
    rm -rf "$target"
    mv "$1" "$target"
}

from_git() {
    command -v git >/dev/null || return 1
    say "cloning upstream's tag MeshLab-$release (at most $git_seconds s)"
    export GIT_TERMINAL_PROMPT=0
    timeout 10 git ls-remote --exit-code "$upstream" "refs/tags/MeshLab-$release" >/dev/null 2>&1 ||
        return 1
    timeout "$git_seconds" git clone --quiet --depth 1 --branch "MeshLab-$release" \
        "$upstream" "$scratch/git" &&
        timeout "$git_seconds" git -C "$scratch/git" submodule update --quiet --init --depth 1 \
            src/vcglib &&
        keep "$scratch/git"
}

# A private apt configuration: the machine's own mirror, the suite that has the release.
apt_source() {
    local mirror=$1 suite=$2 component=$3 apt="$scratch/apt-$2"
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial" "$apt/download"
    echo "deb-src $mirror $suite $component" >"$apt/sources.list"
    local options=(
        -o "Dir::Etc::SourceList=$apt/sources.list" -o Dir::Etc::SourceParts=-
        -o "Dir::State::Lists=$apt/lists" -o "Dir::Cache=$apt/cache" -o APT::Sandbox::User=root
        -o Acquire::Languages=none -o Acquire::Retries=1 -o Acquire::http::Timeout=20
    )
    (
        cd "$apt/download"
        timeout 120 apt-get "${options[@]}" -qq update >&2 &&
            timeout 120 apt-get "${options[@]}" -qq source --tar-only --download-only meshlab >&2
    ) || return 1
    local tarball
    tarball=$(find "$apt/download" -name "meshlab_$release*.orig.tar.*" | head -n 1)
    if [ -z "$tarball" ]; then
        say "suite $suite has another release of MeshLab"
        return 1
    fi
    if ! echo "$tarball_sha256  $tarball" | sha256sum --check --status; then
        say "SHA-256 of $(basename "$tarball") is not the expected $tarball_sha256"
        return 1
    fi
    mkdir -p "$apt/tree"
    tar -xf "$tarball" -C "$apt/tree" --strip-components 1 && keep "$apt/tree"
}

from_apt() {
    command -v apt-get >/dev/null || return 1
    local mirror origin suite
    # shellcheck disable=SC2016 # $(...) is apt's own format syntax
    apt-get indextargets --format '$(REPO_URI) $(ORIGIN) $(COMPONENT)' | sort -u |
        awk '$3 == "main" && $1 !~ /security/ {print $1, $2}' >"$scratch/mirrors"
    while read -r mirror origin; do
        case "$origin" in
        Debian) set -- main $debian_suites ;;
        Ubuntu) set -- universe $ubuntu_suites ;;
        *) continue ;;
        esac
        local component=$1
        shift
        for suite in "$@"; do
            say "source package from $origin $suite"
            apt_source "$mirror" "$suite" "$component" && return 0
        done
    done <"$scratch/mirrors"
    return 1
}

if [ -n "${MESHLAB_SOURCE_DIR:-}" ] && [ $# -eq 0 ]; then
    if ! has_headers "$MESHLAB_SOURCE_DIR"; then
        say "MESHLAB_SOURCE_DIR=$MESHLAB_SOURCE_DIR has no src/common and src/vcglib"
        exit 1
    fi
    echo "$MESHLAB_SOURCE_DIR"
    exit 0
fi
if ! { has_headers "$target" && is_release "$target"; }; then
    mkdir -p "$cache"
    scratch=$(mktemp -d "$cache/fetch.XXXXXX")
    trap 'rm -rf "$scratch"' EXIT
    from_git || from_apt || {
        say "MeshLab $release could not be fetched. Get its sources (with the vcglib submodule)" \
            "elsewhere and set MESHLAB_SOURCE_DIR to their folder."
        exit 1
    }
fi
echo "$target"
