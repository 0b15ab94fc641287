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

# Whether a set-up is set aside; its successor is complete only when it has been dropped.
is_set_aside() { [ -f "$REPLACED/.venv/q2q/venv" ]; }

# The stamp first, so that one that is partly removed never comes back.
drop_replaced() { rm -f -- "$REPLACED/.venv/q2q/venv" && rm -rf -- "$REPLACED"; }

# Clear the place of a new .venv. One that was never completed, since its set-up was killed, is not worth keeping.
set_aside() {
  if [ -f "$STAMPS/venv" ] && ! is_set_aside; then
    rm -rf -- "$REPLACED"
    mkdir "$REPLACED"
    move_set_up "$ROOT" "$REPLACED"
  fi
  remove_set_up
}

remove_set_up() { rm -rf -- "$VENV" "$ROOT/build" "$ROOT/install"; }

clean_up() {
  [ -z "$MAKING" ] || rm -rf -- "$MAKING"
  is_set_aside || return
  remove_set_up
  move_set_up "$REPLACED" "$ROOT"
  rm -rf -- "$REPLACED"
  report "the set-up that was to be replaced is back"
}
