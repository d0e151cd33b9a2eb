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
    # Node.js that came from elsewhere brings an npm of its own, and will not have Debian's beside it.
    [ "$package" = npm ] && command -v npm >/dev/null && continue
    dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed ||
      missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  local log
  log=$(mktemp --tmpdir isthmus-packages.XXXXXX.log)
  say "installing ${#missing[@]} Debian packages and what they need; takes minutes (tail -f $log)"
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
    --no-install-recommends "${missing[@]}" >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    exit 1
  }
  rm -f "$log"
}

# Of ninja's output, what no progress line is; and of those one every ten seconds: how far it is,
# how long it took and about how long it still takes. Sources are compiled before programs are
# linked, and those are quick, so what is left is overrated rather than underrated.
show_progress() {
  local line done_files=0 files=0 seconds=0 next_at=0
  while IFS= read -r line; do
    if ! [[ $line =~ ^@([0-9]+)/([0-9]+)\ ([0-9]+) ]]; then
      printf '%s\n' "$line"
      continue
    fi
    done_files=${BASH_REMATCH[1]} files=${BASH_REMATCH[2]} seconds=${BASH_REMATCH[3]}
    ((seconds < next_at && done_files < files)) && continue
    next_at=$((seconds + 10))
    printf '%4d of %d built, %d:%02d min' "$done_files" "$files" $((seconds / 60)) $((seconds % 60))
    # Before the first is done nothing tells how long the others take.
    if ((done_files > 0 && done_files < files)); then
      printf ', about %d min to go' $((seconds * (files - done_files) / (done_files * 60) + 1))
    fi
    printf '\n'
  done
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
