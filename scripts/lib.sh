# Shared by the scripts beside it; source it, do not run it. Needs bash.
#
# COGRSIM_PRESET chooses the CMake preset (default: release), COGRSIM_BUILD_DIR another build folder.

repo=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
preset=${COGRSIM_PRESET:-release}
build_dir=$repo/build
[ "$preset" = release ] || build_dir=$repo/build-$preset
build_dir=${COGRSIM_BUILD_DIR:-$build_dir}

# Under a sanitizer a program ends at the first finding. Known findings in third-party libraries are listed
# in tests/sanitizers, with the reason.
if [ "$preset" = asan ]; then
  export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1:${ASAN_OPTIONS:-}
  export LSAN_OPTIONS=suppressions=$repo/tests/sanitizers/lsan.supp:print_suppressions=0:${LSAN_OPTIONS:-}
  export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1:${UBSAN_OPTIONS:-}
elif [ "$preset" = tsan ]; then
  export TSAN_OPTIONS=halt_on_error=1:die_after_fork=0:second_deadlock_stack=1:suppressions=$repo/tests/sanitizers/tsan.supp:${TSAN_OPTIONS:-}
fi

packages=(
  cmake ninja-build make g++ ccache pkg-config
  libeigen3-dev libtinyxml2-dev libyaml-cpp-dev libboost-dev
  libexpected-dev libfmt-dev nlohmann-json3-dev libcli11-dev
  libpng-dev libjpeg-dev libembree-dev libqhull-dev libcairo2-dev ffmpeg libjs-dygraphs gnuplot-nox
  libompl-dev libzstd-dev zlib1g-dev libsqlite3-dev libopenmpi-dev openmpi-bin protobuf-compiler libprotobuf-dev libprotozero-dev
  libcurl4-openssl-dev libarchive-dev libssl-dev
  python3-dev pybind11-dev python3-numpy dpkg-dev file
  catch2 liborocos-kdl-dev liburdfdom-dev
)
# What tests run beside that.
test_packages=(python3-onnx libxml2-utils lighttpd lighttpd-mod-webdav openssl chromium fonts-dejavu-core zsh fish gdb mkdocs mkdocs-material
  python3-websockets)
# The packages of each backend.
for list in "$repo"/{backends,renderers}/*/packages.txt; do
  mapfile -t -O ${#packages[@]} packages <"$list"
done
# For tests that read recordings with other tools; some nodejs packages include npm.
command -v npm >/dev/null || packages+=(nodejs npm)

say() { printf '\n== %s\n' "$*"; }

die() {
  printf '%s\n' "$@" >&2
  exit 1
}

# Installs the Debian packages that are missing; touches no network when all are there.
install_missing() {
  if ! command -v dpkg-query >/dev/null; then
    echo "this is not a Debian system; these packages must be installed: ${packages[*]}"
    return
  fi
  local missing=() package
  for package in "${packages[@]}"; do
    if [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
      missing+=("$package")
    fi
  done
  [ ${#missing[@]} -gt 0 ] || return 0

  local as_root=()
  if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null || { [ ! -t 0 ] && ! sudo -n true 2>/dev/null; }; then
      die "packages are missing, and there is neither root nor sudo to install them. Run as root:" \
        "  apt-get update && apt-get install --no-install-recommends ${missing[*]}"
    fi
    as_root=(sudo)
  fi
  say "installing ${missing[*]}"
  "${as_root[@]}" apt-get update -qq || die "apt-get update failed: is there a network?"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y \
    --no-install-recommends "${missing[@]}" >/dev/null ||
    die "apt-get could not install: ${missing[*]}"
}

# True if the packages of the studio's page are installed or can be fetched.
page_packages_at_hand() {
  local web=$repo/apps/studio/web
  command -v npm >/dev/null || return
  [ "$build_dir/apps/studio/web/packages.stamp" -nt "$web/package-lock.json" ] && return
  npm view "esbuild@$(sed -n 's/.*"esbuild": "\(.*\)".*/\1/p' "$web/package.json")" version \
    --prefer-offline --fetch-retries=0 --fetch-timeout=20000 >/dev/null 2>&1
}

configure() {
  say "configuring $build_dir (preset $preset)"
  local studio=ON
  if ! page_packages_at_hand; then
    studio=OFF
    echo "npm is missing or its registry cannot be reached: building without the studio and \`cogrsim bundle\`." \
      "Everything else is built; run this again when npm can fetch packages."
  fi
  (cd "$repo" && cmake --preset "$preset" -B "$build_dir" -DCOGRSIM_STUDIO=$studio --log-level=WARNING)
}

# Builds the targets given.
build() {
  say "building $*"
  cmake --build "$build_dir" --parallel "$(nproc)" --target "$@"
}

# The program with one engine and a renderer, and a picture of a run: what there is to see first.
first_motion() {
  local picture=$build_dir/first.png scene=examples/030_pendulums/pendulums.scene.xml
  build cogrsim_cli cogrsim osmesa
  say "cogrsim render $scene"
  "$build_dir/bin/cogrsim" render "$repo/$scene" --backend cogrsim -o "$picture" || return
  printf 'The first picture, %d min %02d s after the start: %s\n' $((SECONDS / 60)) $((SECONDS % 60)) "$picture"
}

# The demo: the navigation experiment on three engines, in its short form, and a comparison of the engines.
run_demo() {
  local example=examples/050_navigation album=$build_dir/navigation engines=bullet,simbody,cogrsim
  say "$example/experiment --short --seeds 3 --backends $engines ${album#"$repo"/}"
  COGRSIM=$build_dir/bin/cogrsim "$repo/$example/experiment" --short --seeds 3 --backends "$engines" \
    "$album" || return
  say "cogrsim compare $example/navigation.scene.xml --backends $engines"
  "$build_dir/bin/cogrsim" compare "$repo/$example/navigation.scene.xml" --backends "$engines" \
    --report "$album/report.html" || return
  printf '\nOver three seeds:\n'
  cat "$album/summary.txt"
  printf '\nThe map, with the path dashed: %s\nPictures and figures:          %s\n' \
    "$album/bullet/map.png" "$album"
  printf 'The curves of all engines:     %s\n' "$album/report.html"
}
