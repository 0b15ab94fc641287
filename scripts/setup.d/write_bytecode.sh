# Bytecode of everything that the workspace imports; sourced by scripts/setup.
#
# Python writes it when a module is first imported, but not where PYTHONDONTWRITEBYTECODE is set, as in many
# containers: there every start of a node compiled a thousand modules, for one to three seconds.

# The packages, and which modules there are: those that change are few.
bytecode_hash() {
  {
    venv_hash && cat "$STAMPS/dev"
    cd "$ROOT/src" && find . -path './*/test' -prune -o -name '*.py' -print | sort
  } 2>/dev/null | sha256sum
}
bytecode_is_written() { fresh bytecode "$(bytecode_hash)"; }

write_bytecode() (
  workspace_environment
  exec env -u PYTHONDONTWRITEBYTECODE "$VENV/bin/python" "$ROOT/scripts/setup.d/import_all.py" "$ROOT/src"
)

ensure_bytecode() {
  bytecode_is_written && return
  report "bytecode of all modules"
  in_log write_bytecode || report "warning: bytecode is left to be written when a node starts (see $LOG)"
  stamp bytecode "$(bytecode_hash)"
}
