# Thousands of connections to the studio: it keeps serving, with many file descriptors and with few.
source "$(dirname "$0")/lib.sh"
storm=$3
connects=${CONNECTS:-2000}
cp "$here/room.scene.xml" .

ticks() { awk '{print $14 + $15}' "/proc/$1/stat"; }

for files in "$(ulimit -Hn)" 64; do
  rm -f address  # the last server's must not be taken for this one's
  (ulimit -Sn "$files" && exec "$program" studio room.scene.xml --no-open) >address 2>err </dev/null &
  server=$!
  for ((i = 0; i < 200; i++)); do
    grep -q http address 2>/dev/null && break
    sleep 0.1
  done
  port=$(grep -oE '127.0.0.1:[0-9]+' address | head -1 | cut -d: -f2)
  [ -n "$port" ] || { wrong "the studio does not start with $files descriptors"; kill $server; continue; }
  for how in come-and-go half deaf; do
    got=$("$storm" "$port" "$connects" $how) || wrong "$how: the studio cannot be reached"
    kill -0 $server 2>/dev/null || { wrong "$how: the studio has ended"; break; }
    answer=$("$storm" "$port" 1 ask) || wrong "$how with $files descriptors: no answer afterwards"
    # It asks for the page, which needs no token; a refusal is an answer too.
    [[ $answer == "HTTP/1.1 "* ]] || wrong "$how: answers '$answer'"
    echo "$files descriptors, $how: $got connects, then: $answer"
  done
  # Without viewers it uses no processor time: the scene is paused, because no viewer plays it.
  sleep 1
  before=$(ticks $server)
  sleep 2
  burnt=$(($(ticks $server) - before))
  # 2 s are 200 ticks; a loop that fails to accept would take most of them.
  [ "$burnt" -lt 100 ] || wrong "it is busy with nothing: $burnt of 200 ticks"
  held=$(ls /proc/$server/fd | wc -l)
  [ "$held" -lt 60 ] || wrong "$held descriptors are open without viewers"
  kill -INT $server
  for ((i = 0; i < 100; i++)); do
    kill -0 $server 2>/dev/null || break
    sleep 0.1
  done
  kill -KILL $server 2>/dev/null && wrong "the studio does not end at Ctrl-C"
  wait $server 2>/dev/null
done
finish
