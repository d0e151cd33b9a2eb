# Shared by the scripts beside it; source it.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
preset=${ISTHMUS_PRESET:-release}
build_dir=$root/build/$preset

say() { printf '\n== %s\n' "$*"; }

# install_packages [PACKAGE ...]: installs what scripts/packages names, and these, as far as it is
# not there yet. Needs root or sudo only for that.
install_packages() {
  local wanted missing=() package
  wanted="$(grep -v '^#' "$root/scripts/packages") $*"
  for package in $wanted; do
    dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed ||
      missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  say "installing ${#missing[@]} Debian packages"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      echo "these packages are missing and there is no sudo; install them as root:" >&2
      echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
      exit 1
    }
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
    --no-install-recommends "${missing[@]}" >"${TMPDIR:-/tmp}/isthmus-packages.log" 2>&1 || {
    tail -n 20 "${TMPDIR:-/tmp}/isthmus-packages.log" >&2
    exit 1
  }
}

# Of ninja's output, what no progress line is; and of those one every ten seconds: how far it is,
# how long it took and about how long it still takes. Sources are compiled before programs are
# linked, and those are quick, so what is left is overrated rather than underrated.
show_progress() {
  awk -F'[@/ ]' '
    /^@[0-9]+\/[0-9]+ / {
      now = int($4)
      if (now < next_at && $2 != $3) next
      next_at = now + 10
      left = $2 ? now * ($3 - $2) / $2 : 0
      printf "%4d of %d built, %d:%02d min", $2, $3, now / 60, now % 60
      if ($2 != $3) printf ", about %d min to go", left / 60 + 1
      printf "\n"
      fflush()
      next
    }
    { print; fflush() }'
}

# build [TARGET ...]: configures the preset and builds the targets (all without).
build() {
  say "building ($preset) in ${build_dir#"$root"/}"
  (cd "$root" && cmake --preset "$preset" ${configure[@]+"${configure[@]}"} \
    >"$root/build-configure.log" 2>&1) || {
    tail -n 30 "$root/build-configure.log" >&2
    exit 1
  }
  rm -f "$root/build-configure.log"
  NINJA_STATUS='@%f/%t %e ' cmake --build "$build_dir" ${1:+--target "$@"} | show_progress
}
