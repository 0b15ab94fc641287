# Print the folder of machine code: the one that the user chose, else build/numba of the checkout $1; run by env.sh
# and compile_kernels.sh. What env.sh of another checkout set is no choice of the user. Nodes run in any folder, so the
# path is absolute.
chosen=${NUMBA_CACHE_DIR:-}
case $chosen in "" | /*) ;; *) chosen=$PWD/$chosen ;; esac
[ ! -d "${chosen%/build/numba}/.venv/q2q" ] || chosen=
printf '%s\n' "${chosen:-$1/build/numba}"
