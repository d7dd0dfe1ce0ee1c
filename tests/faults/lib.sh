# Shared by the tests beside it, which are called as: TEST.sh PROGRAM FOLDER, FOLDER to be created.
set -u
program=$1
work=$2
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$work"
mkdir -p "$work"
cd "$work" || exit 1
failures=0
engines=${COGRSIM_TEST_ENGINES:-bullet cogrsim}

# The exit status of a test that cannot run here; ctest then reports "skipped".
skipped=77

wrong() {
  failures=$((failures + 1))
  printf 'WRONG: %s\n' "$*"
  [ -s err ] && sed 's/^/    /' err | head -5
  return 0
}

# Runs a command: its streams in files out and err, its exit status in $status.
try() {
  # In a separate shell, which reports on err, and not on the test's own output, what killed it.
  status=0
  (exec "$@") >out 2>err </dev/null || status=$?
}

# The command of the last try() failed properly: with an exit status and a message that matches $1.
must_refuse() {
  if [ "$status" -ne 1 ] && [ "$status" -ne 2 ]; then
    wrong "$2: exit status $status"
  elif ! grep -qiE "$1" err; then
    wrong "$2: does not say what is wrong ($1)"
  fi
}

finish() {
  if [ "$failures" -ne 0 ]; then
    echo "$failures things are wrong"
    exit 1
  fi
  echo "good"
  exit 0
}
