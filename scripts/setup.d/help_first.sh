# Answer --help before any set-up: sourced by the scripts that run a tool.

# help_first MODULE ARGUMENT...: print the tool's help and exit where an argument asks for it.
help_first() {
  local module=$1 root python status
  shift
  case " $* " in *" --help "* | *" -h "*) ;; *) return 0 ;; esac
  root=$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd -P)
  for python in "$root/.venv/bin/python" python3 python3.12 python3.11; do
    command -v "$python" >/dev/null || continue
    status=0
    "$python" -I -S "$root/scripts/setup.d/tool_help.py" "$module" || status=$?
    [ "$status" -eq 3 ] || exit "$status"
  done
  echo "no Python 3.11 or 3.12 found: scripts/setup says what to install" >&2
  exit 1
}
