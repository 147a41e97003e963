# Sourced by tools/quickstart, tools/test and the checks: packages, configuring and building, with plain words on what
# is going on. Expects to be run from the root of the repository.

# shellcheck shell=bash
steps=0
step=0

fail() {
  echo "error: $*" >&2
  exit 1
}

# "[2/4] building ..."
announce() {
  step=$((step + 1))
  echo "[$step/$steps] $*"
}

elapsed() {
  local seconds=$((SECONDS - $1))
  if [ "$seconds" -ge 60 ]; then echo "$((seconds / 60)) min $((seconds % 60)) s"; else echo "$seconds s"; fi
}

# The lists of packages that install_packages() takes.
lists=(tools/packages.txt tools/packages_dev.txt)
listed_packages() { cat "${lists[@]}" | sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d'; }

missing_packages() {
  local installed
  # shellcheck disable=SC2046
  installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' $(listed_packages) 2>/dev/null |
    sed -n 's/ installed$//p' || true)
  listed_packages | grep -vxF "${installed:-none}" || true
}

# Is there a terminal, and are we in front? In the background a question would stop us without a word.
can_ask() {
  local group front
  { : </dev/tty; } 2>/dev/null || return 1
  read -r _ _ _ _ group _ _ front _ <"/proc/$$/stat"
  [ "$group" = "$front" ]
}

# Runs a command as root: directly, or by sudo (which may ask for a password only where somebody can answer: on the
# terminal, wherever the input comes from).
as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif can_ask; then
    sudo "$@"
  else
    sudo -n "$@"
  fi
}

# missing_commands COMMAND=PACKAGE...: the packages of those commands that are not there. For what a user may have from
# elsewhere, as a Node.js that brings its own npm, which Debian's package would conflict with.
missing_commands() {
  local pair
  for pair in "$@"; do command -v "${pair%%=*}" >/dev/null || echo "${pair#*=}"; done
}

# install_packages [PACKAGE...]: those of the list, and these.
install_packages() {
  command -v dpkg-query >/dev/null ||
    fail "this is not a Debian system; install the equivalents of ${lists[*]}, then build with: cmake --preset release && cmake --build build/release"
  local missing
  missing=$({ missing_packages; printf '%s\n' "$@"; } | sed '/^$/d' | tr '\n' ' ')
  missing=${missing% }
  if [ -z "$missing" ]; then
    announce "packages: all installed"
    return
  fi
  announce "installing packages (some minutes the first time): $missing"
  if [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null; then
    fail "packages are missing and this is neither root nor a machine with sudo; as root, run: apt-get install --no-install-recommends $missing"
  fi
  local log=build/packages.log begin=$SECONDS
  mkdir -p build
  # The list of packages may be old or absent; a failed update is reported only if the install fails as well.
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -q update >"$log" 2>&1 </dev/null || true
  # shellcheck disable=SC2086
  if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y --no-install-recommends install $missing >>"$log" 2>&1 </dev/null; then
    tail -n 20 "$log" >&2
    fail "apt-get could not install the packages (whole log: $log)"
  fi
  echo "      installed in $(elapsed $begin)"
}

# build PRESET WORDS [cmake cache arguments...]: configures when needed, builds what has changed; of the targets in the
# array `built` where there is one, of all otherwise.
build() {
  local preset=$1 words=$2
  shift 2
  local log=build/$preset.log begin=$SECONDS first=""
  mkdir -p build
  [ -f "build/$preset/build.ninja" ] || first=" ($words the first time)"
  local wanted=()
  if [ -n "${built[*]-}" ]; then wanted=(--target "${built[@]}"); fi
  announce "building build/$preset$first"
  if ! cmake --preset "$preset" "$@" >"$log" 2>&1 </dev/null; then
    tail -n 30 "$log" >&2
    fail "cmake could not configure (whole log: $log)"
  fi
  if [ -t 1 ]; then
    cmake --build "build/$preset" -j "$(nproc)" ${wanted[@]+"${wanted[@]}"} || fail "the build failed"
  elif ! cmake --build "build/$preset" -j "$(nproc)" ${wanted[@]+"${wanted[@]}"} >>"$log" 2>&1 </dev/null; then
    grep -A 40 -m 3 '^FAILED:' "$log" >&2 || tail -n 40 "$log" >&2
    fail "the build failed (whole log: $log)"
  fi
  echo "      built in $(elapsed $begin)"
}
