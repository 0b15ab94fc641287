# What a set-up that fails leaves: nothing half made, and the set-up that it was to replace; sourced by scripts/setup.

MAKING=
REPLACED=$ROOT/.replaced

# Move a set-up from one folder to another.
move_set_up() {
  local folder
  for folder in .venv build install; do
    [ ! -e "$1/$folder" ] || mv -- "$1/$folder" "$2"
  done
}

# Clear the place of a new .venv. A .venv that was never completed, since its set-up was killed, is not worth keeping:
# what it was to replace still is in REPLACED.
set_aside() {
  if [ -f "$STAMPS/venv" ]; then
    rm -rf -- "$REPLACED"
    mkdir "$REPLACED"
    move_set_up "$ROOT" "$REPLACED"
  fi
  rm -rf -- "$VENV" "$ROOT/build" "$ROOT/install"
}

clean_up() {
  [ -n "$MAKING" ] || return
  rm -rf -- "$MAKING"
  [ "$MAKING" = "$VENV" ] && [ -d "$REPLACED" ] || return
  move_set_up "$REPLACED" "$ROOT"
  rm -rf -- "$REPLACED"
  report "the set-up that was to be replaced is back"
}
