# Print LD_LIBRARY_PATH without the libraries of the ROS that AMENT_PREFIX_PATH names: run where ROS comes as wheels,
# by env.sh and build_workspace.sh. Python would load libraries of either, by chance.
printf '%s\n' "$AMENT_PREFIX_PATH" | tr ':' '\n' | sed -n 's:.$:&/:p' | {
  exec 3<&0
  printf '%s\n' "$LD_LIBRARY_PATH" | tr ':' '\n' | grep -vFf /dev/fd/3 | paste -sd: -
}
