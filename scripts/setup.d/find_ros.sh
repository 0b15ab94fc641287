# Which ROS and which Python carry q2q: sourced by scripts/setup. Sets ROS_KIND (sourced | wheels) and PYTHON.

# Set CHECKOUTS: this one, and those whose env.sh made this shell, which have their .venv on PATH.
find_checkouts() {
  local entry entries
  CHECKOUTS=("$ROOT")
  IFS=: read -ra entries <<<"$PATH"
  for entry in "${entries[@]}"; do
    [ ! -f "${entry%/bin}/q2q/origin" ] || CHECKOUTS+=("${entry%/.venv/bin}")
  done
}

# Print a colon-separated list without the entries inside CHECKOUTS, so that a shell made by env.sh is judged as it
# was before.
outside_checkouts() {
  local entry entries checkout kept=() IFS=:
  read -ra entries <<<"$1"
  for entry in "${entries[@]}"; do
    for checkout in "${CHECKOUTS[@]}"; do
      [[ $entry != "$checkout"/* ]] || continue 2
    done
    kept+=("$entry")
  done
  printf '%s' "${kept[*]}"
}

# Print why a candidate interpreter cannot carry q2q; succeed when it can.
python_problem() {
  local why
  why=$("$1" -I "$ROOT/scripts/setup.d/python_is_usable.py" 2>/dev/null) && return 0
  printf '%s %s' "$1" "${why:-does not run}"
  return 1
}

path_of_python() { "$1" -I -c 'import sys; print(sys.executable)'; }

# Succeed when a ROS prefix can build messages: it has the generators, and its exports name folders that exist.
ros_builds_messages() {
  local prefix
  while IFS= read -r prefix; do
    [ -e "$prefix/share/rosidl_default_generators/package.xml" ] || continue
    ! grep -qs '/opt/python/cp' "$prefix"/share/rosidl_generator_py/cmake/*.cmake "$prefix"/share/*/cmake/*Export*.cmake
    return
  done < <(printf '%s\n' "$AMENT_PREFIX_PATH" | tr ':' '\n')
  return 1
}

# Succeed when a complete ROS 2 Jazzy that is not our own .venv is sourced. Where that ROS finds its libraries by
# itself (wheels in another environment), a Python on top of it needs to know it.
ros_is_sourced() {
  local libraries
  [ "${ROS_DISTRO:-}" = jazzy ] || return 1
  libraries=$(python3 -c 'import os, rclpy; print(os.environ.get("LD_LIBRARY_PATH", ""))' 2>/dev/null) || return 1
  ros_builds_messages && export LD_LIBRARY_PATH=$libraries && return
  report "the sourced ROS 2 cannot build messages (no usable rosidl_default_generators): taking the ROS wheels"
  return 1
}

choose_python() {
  local candidate problem problems=
  if [ -n "${Q2Q_PYTHON:-}" ]; then
    problem=$(python_problem "$Q2Q_PYTHON") ||
      die "Q2Q_PYTHON: $problem. Name a Python 3.11 or 3.12 with venv and headers, or unset Q2Q_PYTHON"
    PYTHON=$(path_of_python "$Q2Q_PYTHON")
    return
  fi
  for candidate in python3 python3.11 python3.12; do
    command -v "$candidate" >/dev/null || continue
    problem=$(python_problem "$candidate") && PYTHON=$(path_of_python "$candidate") && return
    problems="$problems; $problem"
  done
  die "no usable Python${problems/#;/:}. Install Python 3.11 or 3.12 with venv and headers" \
    "(sudo apt install python3 python3-venv python3-dev), or name one: Q2Q_PYTHON=/path/to/python3.11 scripts/setup"
}

find_ros() {
  local list
  find_checkouts
  for list in PATH PYTHONPATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH; do
    export "$list=$(outside_checkouts "${!list:-}")"
  done
  unset _ROS_WHEELS_BOOTSTRAP_COMPLETE COLCON_PREFIX_PATH VIRTUAL_ENV PYTHONHOME
  if ros_is_sourced; then
    ROS_KIND=sourced
  else
    ROS_KIND=wheels
  fi
}

find_python() {
  if [ "$ROS_KIND" = wheels ]; then
    choose_python
    return
  fi
  PYTHON=$(path_of_python python3)
  local problem
  problem=$(python_problem "$PYTHON") || die "the Python of the sourced ROS 2: $problem"
}
