# build/numba: the machine code of all compiled functions; sourced by scripts/setup.

# What the machine code is made of: every source that makes a kernel. A constant that it reads from elsewhere is
# not seen here; its kernel is compiled when a node starts.
kernels_hash() {
  {
    venv_hash
    cd "$ROOT/src" && grep -rlZ --include='*.py' 'q2q_model.compiled import' . | sort -z | xargs -0 cat
  } | sha256sum
}

kernels_are_compiled() { fresh kernels "$(kernels_hash)" && [ -d "$ROOT/build/numba" ]; }

compile_kernels() (
  workspace_environment
  exec "$VENV/bin/python" -m q2q_sim.tools.compile_kernels
)

# A failure is no reason to refuse a shell: nodes compile what they lack when they start.
ensure_kernels() {
  kernels_are_compiled && return
  report "machine code of the kernels, in build/numba (first time: several minutes)"
  mkdir -p "$ROOT/build/numba"
  if in_log compile_kernels; then
    stamp kernels "$(kernels_hash)"
  else
    report "warning: kernels are left to be compiled when a node starts: $(last_step | tail -n 1) (all of it in $LOG)"
  fi
}
