# A folder that cannot be written to: reported immediately, before a long run, with the file's name.
if [ "${COGRSIM_FAULTS_INSIDE:-}" != yes ]; then
  export COGRSIM_FAULTS_INSIDE=yes
  if unshare -rm true 2>/dev/null; then exec unshare -rm bash "$0" "$@"; fi
  # Permissions stop everyone but root.
  [ "$(id -u)" -ne 0 ] || { echo "no name spaces here, and root may write anywhere"; exit 77; }
fi
source "$(dirname "$0")/lib.sh"
scene=$here/room.scene.xml
"$program" run "$scene" --record good.mcap >/dev/null 2>&1 || wrong "a run that may write"
mkdir locked
cp "$scene" locked/room.scene.xml
mount -t tmpfs -o size=1m none locked 2>/dev/null && cp "$scene" locked/room.scene.xml && mount -o remount,ro locked ||
  chmod a-w locked
touch locked/probe 2>/dev/null && wrong "the folder can be written to"
words='read-only|permission|cannot be (written|created|made)|not be written'

for arguments in "run $scene --json locked/x.json" "run $scene --record locked/x.mcap" \
  "run $scene --save-at 0.5s locked/x.snap" "run $scene --plots locked/plots" \
  "compare $scene --duration 0.1s --json locked/x.json" \
  "compare $scene --duration 0.1s --report locked/x.html" "render $scene --at 0.1 -o locked/x.png" \
  "map $scene --at 0.1 -o locked/x.svg" "bundle $scene --duration 0.1s -o locked/x.html" \
  "plot good.mcap --y ball.z -o locked/x.svg" "plot good.mcap --y ball.z -o locked/x.json" \
  "sweep $scene --seeds 1..2 --until 0.1s -o locked/study"; do
  read -ra command <<<"$arguments"
  try "$program" "${command[@]}"
  must_refuse "$words" "${command[0]} $(grep -o 'locked/[a-z.]*' <<<"$arguments") in a folder that is read-only"
  grep -q locked err || wrong "$arguments: does not name the file"
done
# Reading from there works.
try "$program" run locked/room.scene.xml --duration 0.1s
[ "$status" -eq 0 ] || wrong "a scene in a folder that is read-only cannot be run"
finish
