#!/usr/bin/env bash
# new_game.sh WORK_DIR: a game of the template, made by the ff that build_consumer.sh installed in WORK_DIR/prefix.
set -euo pipefail
work=$1
cd "$work"
ff=$work/prefix/bin/ff
rm -rf quiet-hills packages unpacked
"$ff" new quiet-hills
if "$ff" new quiet-hills 2>refused; then echo "ff new wrote over a game"; exit 1; fi
grep -q "not empty" refused
if grep -rnE "@NAME@|@TITLE@" quiet-hills --include='*' -I; then echo "the template's own words are left"; exit 1; fi
if "$ff" new other --name "Quiet Hills" 2>refused; then echo "ff new took a name that no package can have"; exit 1; fi
words=$(bash -c 'source <("$1" completion bash); COMP_WORDS=(ff re); COMP_CWORD=1; _ff; echo "${COMPREPLY[*]}"' bash "$ff")
[ "$words" = "render report replay" ] || { echo "'ff re' is completed to '$words'; expected render, report and replay"; exit 1; }
"$ff" package quiet-hills -o packages
ctest --test-dir quiet-hills/build/package --output-on-failure
ls -l packages
mkdir unpacked
tar -C unpacked -xf packages/quiet-hills-*.tar.gz --strip-components=1
unpacked/bin/quiet-hills --player random --minutes 0.05 --no-record
test -s unpacked/share/applications/quiet-hills.desktop
test -s unpacked/share/icons/hicolor/scalable/apps/quiet-hills.svg
grep -q "^libembree3-3 " unpacked/share/doc/quiet-hills/copyright
[ "$(dpkg-deb -f packages/quiet-hills_*.deb Package)" = quiet-hills ]
dpkg-deb -f packages/quiet-hills_*.deb Depends | grep libembree3-3 >/dev/null
