# A folder that cannot be written into: said at once, before a long run, with the file's name.
if [ "${COGRSIM_FAULTS_INSIDE:-}" != yes ]; then
  export COGRSIM_FAULTS_INSIDE=yes
  if unshare -rm true 2>/dev/null; then exec unshare -rm bash "$0" "$@"; fi
  # Permissions stop everyone but root.
  [ "$(id -u)" -ne 0 ] || { echo "no name spaces here, and root may write anywhere"; exit 77; }
fi
source "$(dirname "$0")/lib.sh"
scene=$here/room.scene.xml
"$program" run "$scene" --record good.mcap >/dev/null 2>&1 || wrong "a run that may write"
mkdir place
cp "$scene" place/room.scene.xml
mount -t tmpfs -o size=1m none place 2>/dev/null && cp "$scene" place/room.scene.xml && mount -o remount,ro place ||
  chmod a-w place
touch place/probe 2>/dev/null && wrong "the folder can be written into"
words='read-only|permission|cannot be (written|created|made)|not be written'

for words_of in "run $scene --json place/x.json" "run $scene --record place/x.mcap" \
  "run $scene --save-at 0.5s place/x.snap" "run $scene --plots place/plots" \
  "compare $scene --duration 0.1s --json place/x.json" \
  "compare $scene --duration 0.1s --report place/x.html" "render $scene --at 0.1 -o place/x.png" \
  "map $scene --at 0.1 -o place/x.svg" "bundle $scene --duration 0.1s -o place/x.html" \
  "plot good.mcap --y ball.z -o place/x.svg" "plot good.mcap --y ball.z -o place/x.json" \
  "sweep $scene --seeds 1..2 --until 0.1s -o place/study"; do
  read -ra command <<<"$words_of"
  try "$program" "${command[@]}"
  must_refuse "$words" "${command[0]} $(grep -o 'place/[a-z.]*' <<<"$words_of") in a folder that is read-only"
  grep -q place err || wrong "$words_of: does not name the file"
done
# Reading from there is no trouble.
try "$program" run place/room.scene.xml --duration 0.1s
[ "$status" -eq 0 ] || wrong "a scene in a folder that is read-only cannot be run"
finish
