# SPDX-License-Identifier: GPL-3.0-or-later
# shellcheck shell=bash
# shellcheck disable=SC2034  # the variables are for those who source this
# What the scripts share: where things are, apt's list, and the chroots with the other Blender versions.

ROOT=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
PYTHON=/usr/bin/python3     # Debian's, which Blender uses; another python3 may stand before it in PATH
CHROOTS=${RUMPLE_BLENDERS:-/var/tmp/rumple-blenders}

die() { printf '%s: %s\n' "${0##*/}" "$*" >&2; exit 1; }
as_root() { if ((EUID == 0)); then "$@"; else sudo -E "$@"; fi; }
# The comment at the top of a script is its help.
help() { sed -n '3,/^[^#]/{s/^# \{0,1\}//p}' "$0"; }

# Debian's release that has this Blender version; nothing for one that we do not know.
release_of() { case $1 in 4.3) echo trixie ;; 5.2) echo sid ;; esac; }

# Names of packages.txt for a place (host, trixie, sid).
packages_for() { sed 's/#.*//' "$ROOT/scripts/packages.txt" | awk -v place="$1" 'NF == 1 || $2 == place {print $1}'; }

# missing_packages PLACE [ROOT_FOLDER]: those of them that dpkg does not have there.
missing_packages() {
    local names
    mapfile -t names < <(packages_for "$1")
    dpkg-query --admindir="${2:-}/var/lib/dpkg" --show --showformat '${db:Status-Status} ${Package}\n' "${names[@]}" 2>/dev/null |
        awk '$1 == "installed" {print $2}' | sort -u | comm -13 - <(printf '%s\n' "${names[@]}" | sort -u)
}

# send_tree CHROOT: this tree, and shared/data beside it, as /rumple in the chroot; its build folder is kept.
send_tree() {
    local home=$1/rumple
    as_root mkdir -p "$home/main"
    as_root find "$home" -mindepth 1 ! -path "$home/main" ! -path "$home/main/build" ! -path "$home/main/build/*" -delete
    # Exit status 1 is a file that changed while it was read: somebody is at work in the tree.
    { tar -C "$ROOT" -c --exclude=./{build,dist,out,.git} --exclude=__pycache__ . || [[ $? == 1 ]]; } |
        as_root tar -C "$home/main" -x --no-same-owner
    if [[ -d $ROOT/../shared/data ]]; then
        as_root mkdir -p "$home/shared"
        as_root cp -r "$ROOT/../shared/data" "$home/shared/"
    fi
}

# take_chroot CHROOT: this shell's alone until it ends, and this tree in it.
take_chroot() {
    exec 9>"$1.lock"
    flock --nonblock 9 || { echo "Another run has $1, waiting"; flock 9; }
    send_tree "$1"
}

# build_in CHROOT: the library that this machine builds: it knows no Python, and what it needs travels with it.
build_in() {
    local target=$1/rumple/main/build/release/python
    "$ROOT/scripts/build" release
    as_root rm -rf "$target"
    as_root cmake --install "$ROOT/build/release" --prefix "$target" >/dev/null
    as_root cp "$ROOT/build/release/python/rumple_native.py" "$target"
    as_root sed -i 's|^sys.path.insert.*|sys.path.insert(0, "/rumple/main/addon")|' "$target/rumple_native.py"
}

# enter CHROOT COMMAND...: runs a command in the chroot's copy of this tree, where build_in has built.
enter() {
    as_root chroot "$1" /usr/bin/env -u RUMPLE_DATA -u RUMPLE_OUT -u TMPDIR -u PYTHONPATH \
        PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
        RUMPLE_NATIVE=/rumple/main/build/release/python \
        sh -c 'cd /rumple/main && exec "$@"' sh "${@:2}" 9>&-
}
