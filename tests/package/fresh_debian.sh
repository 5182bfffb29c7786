#!/usr/bin/env bash
# fresh_debian.sh CMAKE_BUILD_DIR WORK_DIR
# Packs this build, installs the .debs in a minimal Debian of its own with apt, and does there what their users do: plays the game
# without a window, cooks and draws a scene, makes a new game, builds, tests and packs that. Then removes them: nothing is left.
# Ends with 77 (not run) where there is no root, debootstrap, permission to mount or answer of a Debian mirror. DEBIAN_ROOT_CACHE: folder that keeps the base
# system from run to run (the user's cache).
set -euo pipefail
build=$1 work=$2
tool=$(cd "$(dirname "$0")" && pwd)
not_here() { echo "not run: $*"; exit 77; }
step() { echo "== $* ($(date +%H:%M:%S))"; }

[ "$(id -u)" = 0 ] || not_here "needs root"
command -v debootstrap >/dev/null || not_here "needs debootstrap (apt-get install debootstrap)"
unshare --mount true 2>/dev/null || not_here "needs the permission to mount"
# In a mount namespace of its own, so that whatever happens no mount is left behind.
[ -n "${FF_IN_NAMESPACE:-}" ] || FF_IN_NAMESPACE=1 exec unshare --mount --propagation private "$0" "$@"

step "packages"
rm -rf --one-file-system "$work/packages" "$work/root"
mkdir -p "$work"
cpack --config "$build/CPackConfig.cmake" -B "$work/packages" >"$work/cpack.log" 2>&1 || { tail -20 "$work/cpack.log"; exit 1; }
ls -l "$work/packages"/*.deb "$work/packages"/*.tar.gz | awk '{print $5, $9}'
debs=("$work"/packages/*.deb)
[ ${#debs[@]} -eq 3 ] || { echo "${#debs[@]} .debs; expected 3"; exit 1; }

step "base system"
cache=${DEBIAN_ROOT_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/farfield-debian}
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
base=$cache/$release.tar
if [ ! -f "$base" ]; then
  mkdir -p "$cache"
  mirror=$(apt-get indextargets --format '$(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' |
           awk -v r="$release" '$2 == r && $3 == "main" {print $1; exit}')
  fresh=$(mktemp -d "$cache/base.XXXX")
  debootstrap --variant=minbase "$release" "$fresh" "${mirror:-http://deb.debian.org/debian}" >"$work/debootstrap.log" 2>&1 ||
    {
      tail -5 "$work/debootstrap.log"
      rm -rf --one-file-system "$fresh"
      grep -q "Failed getting release file\|Couldn't download" "$work/debootstrap.log" && not_here "the Debian mirror does not answer"
      exit 1
    }
  tar -C "$fresh" -cf "$base.part" . && mv "$base.part" "$base"
  rm -rf --one-file-system "$fresh"
fi
root=$work/root
clean_up() {
  umount -l "$root"/tmp "$root"/proc "$root"/dev "$root"/sys 2>/dev/null || true
  rm -rf --one-file-system "$root" # which it never leaves for a mount that is still there
}
trap clean_up EXIT
mkdir "$root"
tar -C "$root" -xf "$base"
chmod 755 "$root" # apt fetches as a user of its own
# This machine's mirrors and how to reach them.
rm -rf "$root"/etc/apt/sources.list "$root"/etc/apt/sources.list.d "$root"/etc/apt/apt.conf.d
cp -a /etc/apt/apt.conf.d "$root/etc/apt/"
mkdir -p "$root/etc/apt/sources.list.d" "$root/usr/share/keyrings"
cp -a /etc/apt/sources.list.d/*debian* "$root/etc/apt/sources.list.d/" 2>/dev/null || true
[ ! -s /etc/apt/sources.list ] || cp /etc/apt/sources.list "$root/etc/apt/"
cp -a /usr/share/keyrings/. "$root/usr/share/keyrings/"
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir -p "$root/etc/ssl/certs"
cp -aL /etc/ssl/certs/. "$root/etc/ssl/certs/" 2>/dev/null || true
for folder in proc dev sys; do mount --rbind "/$folder" "$root/$folder" || not_here "cannot mount /$folder in a root of its own"; done
mount -t tmpfs tmpfs "$root/tmp" || not_here "cannot mount a tmpfs"
cp "${debs[@]}" "$root/tmp/"
cp "$tool/fresh_debian_inside.sh" "$root/tmp/"

env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp LANG=C.UTF-8 BUILD_PATH="$(cd "$build" && pwd)" \
  SOURCE_PATH="$(cd "$tool/../.." && pwd)" ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
  MESA_SHADER_CACHE_DISABLE=true chroot "$root" /tmp/fresh_debian_inside.sh
step "done"
