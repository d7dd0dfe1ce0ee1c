# A calendar clock that runs backwards all the time: results are the same, nothing waits for it, and
# a run in real time still takes as long as it should.
source "$(dirname "$0")/lib.sh"
shim=$3
scene=$here/room.scene.xml
backwards() { LD_PRELOAD=$shim timeout 120 "$@"; }

first=$(backwards bash -c "printf '%(%s)T' -1")
[ "$first" -lt "$(date +%s)" ] || wrong "the clock does not go backwards"

for backend in $engines; do
  "$program" run "$scene" --backend $backend --json right.json >/dev/null 2>&1 || wrong "a run"
  status=0
  backwards "$program" run "$scene" --backend $backend --record run.mcap --json other.json >out 2>err || status=$?
  [ "$status" -eq 0 ] || wrong "a run on $backend: exit status $status"
  # Everything except the duration.
  same() { grep -vE '"(wall|wall_time|realtime_factor|steps_per_second|date|recording|recorded)' "$1"; }
  cmp -s <(same right.json) <(same other.json) || {
    wrong "the results on $backend differ"
    diff <(same right.json) <(same other.json) | head -5
  }
  try "$program" info run.mcap
  [ "$status" -eq 0 ] || wrong "the recording cannot be read"
done

start=$(date +%s%N)
status=0
backwards "$program" run "$scene" --speed 1 >out 2>err || status=$?
took=$((($(date +%s%N) - start) / 1000000))
[ "$status" -eq 0 ] || wrong "a run in real time: exit status $status"
# It simulates 1 s; a slow machine may take longer, but not a minute.
if [ "$took" -lt 1000 ] || [ "$took" -gt 60000 ]; then wrong "1 s in real time took $took ms"; fi

status=0
backwards "$program" sweep "$scene" --seeds 1..2 --until 0.2s --timeout 60s -o study >out 2>err || status=$?
[ "$status" -eq 0 ] || wrong "a sweep with a time limit: exit status $status"
[ "$(grep -c completed study/results.csv)" -eq 2 ] || wrong "runs of the sweep were given up"
finish
