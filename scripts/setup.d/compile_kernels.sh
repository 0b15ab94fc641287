# The machine code of all compiled functions; sourced by scripts/setup. Sets NUMBA_CACHE_DIR, its folder.

export NUMBA_CACHE_DIR=$(sh "$ROOT/scripts/setup.d/numba_cache.sh" "$ROOT")

# What the machine code is made of: every source that makes a kernel, by its path, and how the store names them. A
# constant that a kernel reads from elsewhere is not seen here; the kernel is compiled when a node starts.
kernels_hash() {
  {
    venv_hash
    cd "$ROOT/src" && {
      find . -path '*/compilation/*.py' -print0
      grep -rlZ --include='*.py' 'q2q_model.compil' .
    } | sort -zu | xargs -0r sha256sum
  } | sha256sum
}

# The stamp is next to the machine code, of which shells may choose different folders, and checkouts the same.
KERNELS_STAMP=$NUMBA_CACHE_DIR/q2q${ROOT//\//-}
kernels_are_compiled() { [ "$(cat "$KERNELS_STAMP" 2>/dev/null)" = "$(kernels_hash)" ]; }

compile_kernels() (
  workspace_environment
  exec "$VENV/bin/python" -P -m q2q_sim.tools.kernels.compile_kernels
)

# A failure is no reason to refuse a shell: nodes compile what they lack when they start.
ensure_kernels() {
  kernels_are_compiled && return
  report "machine code of the kernels, in ${NUMBA_CACHE_DIR#"$ROOT/"} (first time: several minutes)"
  if in_log mkdir -p "$NUMBA_CACHE_DIR" && in_log test -w "$NUMBA_CACHE_DIR" && in_log compile_kernels; then
    kernels_hash >"$KERNELS_STAMP"
  else
    report "warning: kernels are left to be compiled when a node starts: $(last_step | tail -n 1) (all of it in $LOG)"
  fi
}
