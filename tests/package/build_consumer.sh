#!/usr/bin/env bash
# build_consumer.sh CMAKE BUILD_DIR CONSUMER_SOURCE WORK_DIR
set -euo pipefail
cmake=$1 build=$2 source=$3 work=$4
rm -rf "$work/prefix" "$work/consumer"
for component in dev tools; do
  "$cmake" --install "$build" --prefix "$work/prefix" --component $component >/dev/null
done
"$cmake" -S "$source" -B "$work/consumer" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix"
"$cmake" --build "$work/consumer"
"$work/consumer/consumer"
