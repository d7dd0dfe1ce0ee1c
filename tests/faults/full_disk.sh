# A disk that is full: every command that writes reports it and fails, and existing files stay.
#
# A file system of its own in memory, in a name space of its own; if the system does not allow one,
# only a full standard output is tested.
if [ "${COGRSIM_FAULTS_INSIDE:-}" != yes ]; then
  export COGRSIM_FAULTS_INSIDE=yes
  if unshare -rm true 2>/dev/null; then exec unshare -rm bash "$0" "$@"; fi
  export COGRSIM_FAULTS_INSIDE=no
fi
source "$(dirname "$0")/lib.sh"
words='space|written|too large|too big|full'

scene=$here/room.scene.xml
if [ "$COGRSIM_FAULTS_INSIDE" = yes ]; then
  mkdir disk
  mount -t tmpfs -o size=64k none disk || exit $skipped
  fill() { # leaves no space except in existing files
    head -c 1000000 /dev/zero >disk/filler 2>/dev/null
    [ "$(stat -c %s disk/filler)" -lt 1000000 ] || wrong "the disk is not full"
  }
  "$program" run "$scene" --record good.mcap >/dev/null 2>&1 || wrong "a run with a disk"

  # Files that are written completely or not at all: an old one is unchanged.
  whole=(
    "run $scene --json disk/result.json"
    "run $scene --save-at 0.5s disk/kept.snap"
    "compare $scene --duration 0.1s --json disk/compared.json"
    "compare $scene --duration 0.1s --report disk/report.html"
    "render $scene --at 0.1 -o disk/picture.png"
    "map $scene --at 0.1 -o disk/map.svg"
    "bundle $scene --duration 0.1s -o disk/page.html"
    "plot good.mcap --y ball.z -o disk/figure.json"
    "plot good.mcap --y ball.z -o disk/figure.svg"
    "test $scene --junit disk/junit.xml"
  )
  for words_of in "${whole[@]}"; do
    read -ra command <<<"$words_of"
    target=$(grep -o 'disk/[a-z.]*' <<<"$words_of")
    rm -f disk/*
    echo "what was there" >"$target"
    fill
    try "$program" "${command[@]}" --overwrite
    must_refuse "$words" "${command[*]:0:1} into $target on a full disk"
    [ "$(cat "$target")" = "what was there" ] || wrong "$target was damaged"
    # No partial file is left beside it.
    left=$(ls -A disk | grep -vx -e filler -e "${target#disk/}")
    [ -z "$left" ] || wrong "${command[0]} leaves $left behind"
  done

  # A recording grows; the frames that fitted can be read.
  mkdir larger
  mount -t tmpfs -o size=3m none larger
  try "$program" run "$scene" --duration 60s --record larger/run.mcap
  must_refuse "$words" "run --record on a full disk"
  try "$program" info larger/run.mcap
  [ "$status" -eq 0 ] || wrong "what was recorded before the disk was full cannot be read"

  # A sweep's table.
  rm -rf disk/*
  fill
  try "$program" sweep "$scene" --seeds 1..2 --until 0.1s -o disk/study
  must_refuse "$words" "sweep on a full disk"
fi

# The terminal's own file.
for command in "run $scene --duration 0.1s --json -" "schema" "plugins" "explain CG0502" "check $scene --json"; do
  read -ra command <<<"$command"
  status=0
  "$program" "${command[@]}" >/dev/full 2>err || status=$?
  must_refuse "$words" "${command[*]} into a full standard output"
done
[ "$COGRSIM_FAULTS_INSIDE" = yes ] || [ "$failures" -ne 0 ] || {
  echo "no name spaces here: only a full standard output was tried"
  exit $skipped
}
finish
