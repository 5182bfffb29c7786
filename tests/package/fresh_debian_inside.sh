#!/usr/bin/env bash
# The part of fresh_debian.sh that runs in the fresh system, as its root. The .debs lie in /tmp, which is no part of what is compared;
# so does everything that the programs write.
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive
ours=(libfarfield-dev farfield-tools farfield-beacons)
step() { echo "== $* ($(date +%H:%M:%S))"; }
fail() { echo "FAILED: $*"; exit 1; }
cd /tmp

# Every file but those of the package manager's own books, with what is in it.
list_files() {
  find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /tmp -o -path /var/lib/dpkg -o -path /var/lib/apt \
    -o -path /var/cache/apt -o -path /var/log \) -prune -o -printf '%p %y %s %l\n' | sort
}

step "dependencies"
apt-get -o Acquire::Retries=3 update -qq
for deb in *.deb; do dpkg-deb -f "$deb" Depends; done | tr ',' '\n' | sed 's/^ *//' |
  grep -v '^farfield-' | sort -u >depends
apt-get satisfy -y -qq --no-install-recommends "$(paste -sd, depends)" >apt.log 2>&1 || { tail -20 apt.log; exit 1; }
list_files >before

step "install"
apt-get install -y -qq --no-install-recommends ./*.deb >>apt.log 2>&1 || { tail -20 apt.log; exit 1; }
dpkg -L "${ours[@]}" | sort -u >files
for path in "$BUILD_PATH" "$SOURCE_PATH"; do
  found=$(xargs -d '\n' -a files sh -c 'for f; do [ -f "$f" ] && echo "$f"; done' sh | xargs -d '\n' grep -lF "$path" || true)
  [ -z "$found" ] || fail "$path is baked into $found"
done
for package in "${ours[@]}"; do
  [ "$(wc -l <"/usr/share/doc/$package/copyright")" -gt 300 ] || fail "$package: no licences"
done
grep -q "^libembree3-3 " /usr/share/doc/farfield-beacons/copyright || fail "Embree's licence is not there"

step "play"
farfield-beacons --version
farfield-beacons --player winner --minutes 0.5 --draw --recording /tmp/winner.ffreplay
farfield-beacons --verify /tmp/winner.ffreplay
bash -n /usr/share/bash-completion/completions/ff
# Read to its end: `grep -q` would leave zcat with a broken pipe.
zcat /usr/share/man/man1/ff.1.gz | grep "ff cook" >/dev/null || fail "no manual"

step "a new game: made, cooked, drawn"
ff --version
ff new /tmp/lost-harbour
ff cook lost-harbour/scene.toml -o /tmp/harbour.ffpack --cache /tmp/cache
ff render /tmp/harbour.ffpack --walk main --size 320x240 -o /tmp/harbour.png
[ "$(stat -c %s harbour.png)" -gt 20000 ] || fail "harbour.png shows nothing"
ff new /tmp/lost-harbour 2>refused && fail "ff new wrote over a game"
grep -q "not empty" refused || fail "ff new does not say why it refuses"

step "a new game: built, tested, packed"
cd /tmp/lost-harbour
cmake --preset release >/dev/null
cmake --build --preset release
ctest --preset release
ff package . -o /tmp/packages >/tmp/package.log 2>&1 || { tail -30 /tmp/package.log; exit 1; }
ls -l /tmp/packages
cd /tmp

step "the new game: installed, played, removed"
list_files >before_harbour
apt-get install -y -qq --no-install-recommends ./packages/lost-harbour_*.deb >>apt.log 2>&1 || { tail -20 apt.log; exit 1; }
lost-harbour --player random --minutes 0.1 --draw --recording /tmp/harbour.ffreplay
lost-harbour --verify /tmp/harbour.ffreplay
apt-get purge -y -qq lost-harbour >>apt.log 2>&1
list_files >after_harbour
diff before_harbour after_harbour || fail "the new game left something behind"
mkdir unpacked && tar -C unpacked -xf packages/lost-harbour-*.tar.gz --strip-components=1
unpacked/bin/lost-harbour --player random --minutes 0.05 --no-record

step "remove"
apt-get purge -y -qq "${ours[@]}" >>apt.log 2>&1 || { tail -20 apt.log; exit 1; }
list_files >after
diff before after || fail "something is left behind"
