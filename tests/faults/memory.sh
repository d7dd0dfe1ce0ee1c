# Too little memory: a message and an exit status, never an abort or a signal.
#
# The limits rise from too little for the libraries alone to enough for everything.
source "$(dirname "$0")/lib.sh"
cat >many.scene.xml <<'SCENE'
<scene name="many" version="1">
  <physics step="2 ms" duration="1 s"/>
  <plane name="floor"/>
  <repeat count="1500" var="i">
    <box name="b${i}" size="10 10 10 cm" xyz="${0.3 * (i % 40)} ${0.3 * floor(i / 40)} 0.05"/>
  </repeat>
</scene>
SCENE

# Its memory use in a run without a limit [kB].
needed() {
  "$@" >/dev/null 2>&1 &
  local child=$! most=0 now
  while now=$(awk '/^VmSize/ {print $2}' /proc/$child/status 2>/dev/null) && [ -n "$now" ]; do
    [ "$now" -gt "$most" ] && most=$now
    sleep 0.01
  done
  wait $child
  echo "$most"
}

refused=0
for backend in $engines; do
  command=("$program" run many.scene.xml --backend $backend --duration 0.02s --record run.mcap)
  most=$(needed "${command[@]}")
  [ "$most" -gt 100000 ] || wrong "the run on $backend seems to need $most kB only"
  for share in $(seq 30 3 96); do
    kilobytes=$((most * share / 100))
    status=0
    (ulimit -v $kilobytes && exec "${command[@]}") >out 2>err </dev/null || status=$?
    case $status in
      0) ;;
      # 127: the system's loader could not map a library, and reports it.
      1 | 127)
        refused=$((refused + 1))
        grep -qE 'memory|cannot be loaded|failed to map|cannot allocate|cannot create' err ||
          wrong "$backend with $kilobytes kB: the message does not speak of memory"
        ;;
      # Where even "--version" dies, constructors of shared libraries ran out of memory before the
      # program began (measured: GnuTLS and others, in a window of 0.3 MB above what 127 needs).
      *)
        starts=0
        (ulimit -v $kilobytes && exec "$program" --version) >/dev/null 2>&1 || starts=$?
        [ "$starts" -gt 127 ] || wrong "$backend with $kilobytes kB of $most: exit status $status"
        ;;
    esac
  done
done
echo "$refused runs were refused"
[ "$refused" -gt 5 ] || wrong "the limits were no limits"
finish
