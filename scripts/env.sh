# Source me (bash, zsh): sets q2q up if needed and gives a shell where `ros2 run q2q_sim simulator` works.
# Leaves the caller's `set -e`, `set -u` and arguments alone. Returns 1 when the set-up fails.

_q2q_root=$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]:-${(%):-%x}}")/.." && pwd -P)

_q2q_enter() {
  local venv=$_q2q_root/.venv shell=bash entry
  [ -z "${ZSH_VERSION:-}" ] || shell=zsh
  if [ "$(cut -d' ' -f1 "$venv/q2q/origin")" = wheels ]; then
    # Another ROS or Python must not leak in: the wheels are their own prefix, and have one middleware only.
    unset PYTHONPATH PYTHONHOME RMW_IMPLEMENTATION _ROS_WHEELS_BOOTSTRAP_COMPLETE
    export LD_LIBRARY_PATH=$(sh "$_q2q_root/scripts/setup.d/other_libraries.sh")
    export AMENT_PREFIX_PATH=$venv CMAKE_PREFIX_PATH=$venv ROS_DISTRO=jazzy ROS_VERSION=2 ROS_PYTHON_VERSION=3
  else
    # Overlays may have been sourced since the set-up.
    while IFS= read -r entry && [ -n "$entry" ]; do
      case ":${LD_LIBRARY_PATH:=$entry}:" in *":$entry:"*) ;; *) LD_LIBRARY_PATH=$LD_LIBRARY_PATH:$entry ;; esac
    done <<<"$(tr ':' '\n' <"$venv/q2q/library_path")"
    export LD_LIBRARY_PATH
  fi
  case ":$PATH:" in *":$venv/bin:"*) ;; *) export PATH=$venv/bin:$PATH ;; esac
  case ":$PATH:" in *":$_q2q_root/scripts/ros2-small:"*) ;; *) export PATH=$PATH:$_q2q_root/scripts/ros2-small ;; esac
  export VIRTUAL_ENV=$venv
  export ROS_AUTOMATIC_DISCOVERY_RANGE=${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}
  # What env.sh of another checkout set is no choice of the user.
  [ ! -d "${Q2Q_DATA%/../shared/data}/.venv/q2q" ] || unset Q2Q_DATA
  export Q2Q_DATA=${Q2Q_DATA:-$_q2q_root/../shared/data}
  export NUMBA_CACHE_DIR=$(sh "$_q2q_root/scripts/setup.d/numba_cache.sh" "$_q2q_root")
  # colcon's script calls Python unquoted: the real interpreter's path has no space where the checkout's has.
  COLCON_PYTHON_EXECUTABLE=$(readlink -f "$venv/bin/python")
  . "$_q2q_root/install/local_setup.$shell"
  unset COLCON_PYTHON_EXECUTABLE
}

_q2q_options=$-
set +eu
"$_q2q_root/scripts/setup" && _q2q_enter
_q2q_status=$?
case $_q2q_options in *e*) set -e ;; esac
case $_q2q_options in *u*) set -u ;; esac
unset -f _q2q_enter
unset _q2q_options _q2q_root
[ "$_q2q_status" -eq 0 ] || { unset _q2q_status && return 1; }
unset _q2q_status
