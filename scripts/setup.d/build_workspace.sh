# build/ and install/: the colcon workspace; sourced by scripts/setup.

# What the build reads. Python sources are linked into install/, so their contents do not count.
build_hash() {
  {
    venv_hash
    cd "$ROOT/src" && cat ../colcon.meta ../scripts/setup.d/{build_workspace.sh,console_scripts.py} */package.xml */setup.py */setup.cfg */CMakeLists.txt */msg/*.msg
    printf '%s\n' */msg/* */resource/* */config/* */launch/*
  } 2>/dev/null | sha256sum
}

ros_environment() {
  [ "$ROS_KIND" = sourced ] && return
  unset PYTHONPATH
  export LD_LIBRARY_PATH=$(sh "$ROOT/scripts/setup.d/other_libraries.sh")
  export AMENT_PREFIX_PATH=$VENV CMAKE_PREFIX_PATH=$VENV ROS_DISTRO=jazzy ROS_VERSION=2 ROS_PYTHON_VERSION=3
}

workspace_environment() {
  ros_environment
  set +u
  # colcon's script calls Python unquoted: the real interpreter's path has no space where the checkout's has.
  COLCON_PYTHON_EXECUTABLE=$(readlink -f "$VENV/bin/python")
  . "$ROOT/install/local_setup.bash"
}

colcon_build() (
  ros_environment
  export PATH=$VENV/bin:$PATH
  local generator=()
  command -v ninja >/dev/null && generator=(-G Ninja)
  cd "$ROOT" && "$VENV/bin/python" -m colcon --log-base "$ROOT/log" build --symlink-install --base-paths src --metas colcon.meta \
    --event-handlers desktop_notification- --cmake-args "${generator[@]}" "-DPython3_EXECUTABLE=$VENV/bin/python"
)

# Remove what was built of packages that src/ no longer has: ros2 would still list them.
drop_gone_packages() {
  local listed name
  listed=$(cd "$ROOT" && "$VENV/bin/python" -m colcon --log-base /dev/null list --names-only --base-paths src 2>/dev/null)
  [ -n "$listed" ] || return
  for name in "$ROOT"/install/*/share/colcon-core/packages/*; do
    name=${name##*/}
    grep -qxF -- "$name" <<<"$listed" || rm -rf -- "$ROOT/install/$name" "$ROOT/build/$name"
  done
}

ensure_build() {
  fresh build "$(build_hash)" && [ -f "$ROOT/install/local_setup.bash" ] && return
  report "step 3 of 3: colcon build of src/"
  [ -f "$ROOT/install/local_setup.bash" ] || MAKING=$ROOT/install
  begin build
  logged "colcon build failed" colcon_build
  "$VENV/bin/python" -I -S "$ROOT/scripts/setup.d/console_scripts.py" "$ROOT"
  drop_gone_packages
  drop_replaced
  stamp build "$(build_hash)"
  MAKING=
}
