#!/usr/bin/env bash
# The scripts configure without the studio, and report it, if npm's registry is unreachable; with
# the studio if it is reachable, or if the packages are installed already.
#   tests/package/without_npm.sh SOURCE_DIR SCRATCH
set -euo pipefail
source_dir=${1:?} scratch=${2:?}
rm -rf "$scratch"
mkdir -p "$scratch/tools"
printf '#!/bin/sh\necho "cmake $*"\n' >"$scratch/tools/cmake"
printf '#!/bin/sh\n[ "$REGISTRY" = up ]\n' >"$scratch/tools/npm"
chmod +x "$scratch"/tools/*
failures=0
expect() {  # up|down, ON|OFF
  local out said=ON
  out=$(REGISTRY=$1 COGRSIM_BUILD_DIR=$scratch/build PATH=$scratch/tools:$PATH \
    bash -c 'set -euo pipefail; source "$0/scripts/lib.sh"; configure' "$source_dir" 2>&1) || true
  if grep -q "without the studio" <<<"$out"; then said=OFF; fi
  if [ $said != "$2" ] || ! grep -q -- "-DCOGRSIM_STUDIO=$2" <<<"$out"; then
    printf 'registry %s: not configured with the studio %s:\n%s\n' "$1" "$2" "$out" >&2
    failures=1
  fi
}
expect up ON
expect down OFF
mkdir -p "$scratch/build/apps/studio/web"
touch "$scratch/build/apps/studio/web/packages.stamp"
expect down ON
exit $failures
