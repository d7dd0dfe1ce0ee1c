# SIGKILL at any time: a file written before is complete, or it does not exist.
#
# Each command is first run to its end, then repeatedly and killed at times that are spread over
# that duration. ROUNDS (default 10) says how often.
source "$(dirname "$0")/lib.sh"
scene=$here/room.scene.xml
rounds=${ROUNDS:-10}
RANDOM=20

now() { date +%s%N; }

# Runs a command and kills it $1 nanoseconds later, unless it has ended; its children end with it or by
# themselves.
kill_after() {
  local delay=$1
  shift
  "$@" >out 2>err </dev/null &
  local child=$!
  sleep "$((delay / 1000000000)).$(printf %09d $((delay % 1000000000)))"
  kill -KILL $child 2>/dev/null
  # A signal also reaches an ended process until it is waited for; only the status shows it.
  local status=0
  wait $child 2>/dev/null || status=$?
  [ "$status" -ne $((128 + 9)) ] || killed=$((killed + 1))
}

# A run that was never killed tests nothing: the first time lies before any end.
must_have_killed() {
  echo "$1: $killed of $rounds killed"
  [ "$killed" -gt 0 ] || wrong "$1: none was killed"
}

# The k-th of the times in a span, with some randomness.
random_time() { echo $(((($1 * 32768 + RANDOM) * $2) / (rounds * 32768))); }

# ---- a recording can be read up to the kill
killed=0
start=$(now)
"$program" run "$scene" --duration 20s --record whole.mcap >/dev/null 2>&1 || wrong "the whole run"
span=$(($(now) - start))
read_back=0
for ((k = 0; k < rounds; k++)); do
  rm -f run.mcap
  kill_after "$(random_time $k $span)" "$program" run "$scene" --duration 20s --record run.mcap
  [ -e run.mcap ] || continue # killed before it began
  try "$program" info run.mcap
  if [ "$status" -eq 0 ]; then
    read_back=$((read_back + 1))
    try "$program" plot run.mcap --y ball.z -o run.json
    [ "$status" -eq 0 ] || wrong "a recording that was cut off cannot be plotted"
  elif [ "$(stat -c %s run.mcap)" -gt 3000000 ] || [ "$status" -ge 124 ]; then
    # Up to the first chunk there are no frames, and that is reported.
    wrong "a recording that was cut off at $(stat -c %s run.mcap) bytes: exit status $status"
  fi
done
must_have_killed recordings
echo "$read_back recordings were read back"
[ "$read_back" -gt 0 ] || wrong "no recording of a killed run could be read"

# ---- files that are written at once: the old one or the new one
killed=0
"$program" run "$scene" --duration 0.2s --save-at 0.1s old.snap >/dev/null 2>&1
start=$(now)
"$program" run "$scene" --duration 0.3s --save-at 0.2s new.snap >/dev/null 2>&1 || wrong "a snapshot"
span=$(($(now) - start))
for ((k = 0; k < rounds; k++)); do
  cp old.snap kept.snap
  kill_after "$(random_time $k $span)" "$program" run "$scene" --duration 0.3s --save-at 0.2s kept.snap
  cmp -s kept.snap old.snap || cmp -s kept.snap new.snap || wrong "a snapshot is neither old nor new"
done
must_have_killed snapshots

# ---- a sweep resumes where it was killed, and ends as if it had not been
killed=0
sweep=("$program" sweep "$scene" --vary speed=1,2,3 --seeds 1..3 --until 0.3s)
start=$(now)
"${sweep[@]}" -o whole >/dev/null 2>err || wrong "the whole sweep"
span=$(($(now) - start))
for ((k = 0; k < rounds; k++)); do
  kill_after "$(random_time $((k % 3)) $span)" "${sweep[@]}" -o study
done
try "${sweep[@]}" -o study
[ "$status" -eq 0 ] || wrong "a sweep that was killed does not resume: exit status $status"
# All but the last column, the wall-clock times.
cmp -s <(sed 's/,[^,]*$//' whole/results.csv) <(sed 's/,[^,]*$//' study/results.csv) ||
  wrong "a sweep that was killed $killed times has another table than one that was not"
[ "$(wc -l <whole/results.csv)" -eq 10 ] || wrong "the table has not 9 rows"
must_have_killed sweeps

# ---- a package, made and unpacked: complete or missing
killed=0
mkdir packages
start=$(now)
"$program" push "$scene" --name room --include whole.mcap -o whole.cogrsim.zip >/dev/null 2>err ||
  wrong "the whole package"
span=$(($(now) - start))
for ((k = 0; k < rounds; k++)); do
  rm -rf packages/*
  kill_after "$(random_time $k $span)" "$program" push "$scene" --name room --include whole.mcap \
    -o packages/room.cogrsim.zip
  [ -e packages/room.cogrsim.zip ] || continue
  try "$program" pull packages/room.cogrsim.zip --dry-run
  [ "$status" -eq 0 ] || wrong "a package is there and not whole"
done
must_have_killed packages
killed=0
start=$(now)
"$program" pull whole.cogrsim.zip --into packages >/dev/null 2>err || wrong "the whole pull"
span=$(($(now) - start))
unpacked=$(cd packages && ls -d room-*)
cp -r "packages/$unpacked" pulled
for ((k = 0; k < rounds; k++)); do
  rm -rf packages
  mkdir packages
  kill_after "$(random_time $k $span)" "$program" pull whole.cogrsim.zip --into packages
  [ -e "packages/$unpacked" ] || continue
  diff -r "packages/$unpacked" pulled >/dev/null || wrong "a package was unpacked in part"
  # Files that were left behind do not hinder the next one.
  rm -rf "packages/$unpacked"
  try "$program" pull whole.cogrsim.zip --into packages
  [ "$status" -eq 0 ] || wrong "a pull after one that was killed"
done
must_have_killed pulls

# ---- a package being pushed to a store: a pull gets it completely, or reports that it is missing
server=$(command -v lighttpd || echo /usr/sbin/lighttpd)
if [ -x "$server" ]; then
  killed=0
  mkdir -p store/open uploads
  for port in $((20000 + RANDOM % 10000)) $((30000 + RANDOM % 10000)); do
    cat >lighttpd.conf <<CONF
server.modules = ("mod_webdav")
server.document-root = "$PWD/store"
server.bind = "127.0.0.1"
server.port = $port
server.upload-dirs = ("$PWD/uploads")
server.stat-cache-engine = "disable"
webdav.activate = "enable"
webdav.is-readonly = "disable"
CONF
    "$server" -D -f lighttpd.conf >server.log 2>&1 &
    lighttpd=$!
    until (exec 3<>/dev/tcp/127.0.0.1/$port) 2>/dev/null || ! kill -0 $lighttpd 2>/dev/null; do
      sleep 0.05
    done
    kill -0 $lighttpd 2>/dev/null && break
  done
  trap 'kill $lighttpd 2>/dev/null' EXIT
  store=http://127.0.0.1:$port/open
  push=("$program" push "$scene" --name room --include whole.mcap --to "$store" --force)
  start=$(now)
  "${push[@]}" >out 2>err || wrong "a push to the store"
  span=$(($(now) - start))
  whole_pulls=0
  for ((k = 0; k < rounds; k++)); do
    rm -rf store/open/* taken
    kill_after "$(random_time $k $span)" "${push[@]}"
    try "$program" pull room --from "$store" --into taken
    if [ "$status" -eq 0 ]; then
      whole_pulls=$((whole_pulls + 1))
      diff -r taken/* pulled >/dev/null || wrong "a package came out of the store in part"
    elif [ "$status" -ne 1 ] || grep -qiE 'damaged|checksum|changed' err; then
      wrong "a push that was killed left something bad in the store"
    fi
    # And pushing again repairs it.
    try "${push[@]}"
    [ "$status" -eq 0 ] || wrong "a push after one that was killed"
  done
  must_have_killed pushes
  echo "$whole_pulls pushes were through"
else
  wrong "there is no lighttpd to push to"
fi
finish
