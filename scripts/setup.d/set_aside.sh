# What a set-up that fails leaves: nothing half made, and the set-up that it was to replace; sourced by scripts/setup.

MAKING=
REPLACED=$ROOT/.replaced

# Move folders of a set-up from one place to another, in this order, where the other has none; fail if one stays.
move_folders() {
  local folder from=$1 to=$2
  shift 2
  for folder; do
    [ ! -e "$from/$folder" ] || [ -e "$to/$folder" ] || mv -- "$from/$folder" "$to/" || return
  done
}
# .venv first: as long as there is none, build and install are those of the set-up that is set aside.
move_aside() {
  move_folders "$ROOT" "$REPLACED" .venv build install || fail "the set-up to be replaced cannot be moved to $REPLACED"
}

# Whether a set-up is set aside; its successor is complete only when it has been dropped.
is_set_aside() { [ -f "$REPLACED/.venv/q2q/venv" ]; }

# The stamp first, so that one that is partly removed never comes back.
drop_replaced() { rm -f -- "$REPLACED/.venv/q2q/venv" && rm -rf -- "$REPLACED"; }

# Clear the place of a new .venv. One that was never completed, since its set-up was killed, is not worth keeping.
set_aside() {
  if is_set_aside; then
    [ -e "$VENV" ] || move_aside # a set-up was killed between the moves
  elif [ -f "$STAMPS/venv" ]; then
    rm -rf -- "$REPLACED"
    mkdir -- "$REPLACED" || fail "$REPLACED cannot be made"
    move_aside
  fi
  remove_set_up
}

# .venv last, as above.
remove_set_up() { rm -rf -- "$ROOT/build" "$ROOT/install" "$VENV"; }

clean_up() {
  [ -z "$MAKING" ] || rm -rf -- "$MAKING"
  is_set_aside || { rmdir -- "$REPLACED" 2>/dev/null; return; }
  [ ! -e "$VENV" ] || remove_set_up
  move_folders "$REPLACED" "$ROOT" build install .venv || return
  rm -rf -- "$REPLACED"
  report "the set-up that was to be replaced is back"
}
