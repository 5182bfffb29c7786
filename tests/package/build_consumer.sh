#!/usr/bin/env bash
# build_consumer.sh CMAKE BUILD_DIR CONSUMER_SOURCE WORK_DIR
set -euo pipefail
cmake=$1 build=$2 source=$3 work=$4
rm -rf "$work/prefix" "$work/consumer"
"$cmake" --install "$build" --prefix "$work/prefix" >/dev/null
"$cmake" -S "$source" -B "$work/consumer" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix"
"$cmake" --build "$work/consumer"
"$work/consumer/consumer"
