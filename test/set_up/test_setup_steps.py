"""scripts/setup: what its steps leave where one fails; a shell script plays Python, its pip and colcon."""

import pytest
from fresh_checkout import BASE_PYTHON, Checkout

PYTHON = """for last; do :; done
case "$*" in
  *"-m venv"*) mkdir -p "$last/bin" && cp "$0" "$last/bin/python" ;;
  *"-m pip"*) {pip} ;;
  *"-m colcon"*) {colcon} ;;
  *compile_kernels*) echo "$NUMBA_CACHE_DIR" >>"{root}/compiled" ;;
  *sys.executable*) echo "$0" ;;
  *rclpy*) exit 1 ;;
  *repair_cmake_exports*) ;;
  *) exec "{python}" "$@" ;;
esac"""
BUILT = "mkdir -p install && touch install/local_setup.bash"
KILLED = "kill -KILL $PPID"
KILLED_BUILD = 'kill -KILL "$(cat pid)"'
NO_NETWORK = "echo Network is unreachable; exit 1"
RETRY = "WARNING: Retrying (Retry(total=0)) after connection broken by '{}': /simple/cflib/\n"
NO_VERSIONS = "ERROR: Could not find a version that satisfies the requirement cflib (from versions: none)"
FAILURES = {
    "Network is unreachable": "no network",
    RETRY.format("ReadTimeoutError(Read timed out. (read timeout=1.0))") + NO_VERSIONS: "no network",
    RETRY.format("ConnectionResetError(104, Connection reset by peer)") + NO_VERSIONS: "no network",
    "ERROR: Could not install packages: [Errno 28] No space left on device": "the disk is full",
}
"""What pip says where it cannot fetch a package, and the error of the set-up."""
UNFIT = (
    "ERROR: ResolutionImpossible",
    "ERROR: Package 'cflib' requires a different Python: 3.12.3 not in '<3.11'",
    "ERROR: Could not find a version that satisfies the requirement cflib==9 (from versions: 0.1, 0.2)",
    "ERROR: Ignored the following versions that require a different python version: 9\n" + NO_VERSIONS,
    "ERROR: Failed building wheel for cflib",
)
"""What pip says where a package does not go with the others or with this Python."""
UNFITTING, ABSENT = "does not go with this Python's packages", "is not in the package index"
WITHOUT_TORCH = {
    RETRY.format("ReadTimeoutError(Read timed out.)")
    + NO_VERSIONS: "could not be fetched for lack of a network",
    NO_VERSIONS.replace("none", "2.11.0, 2.12.0"): "has no CPU build for this Python in the package indices",
    "ERROR: ResolutionImpossible": UNFITTING,
    "ERROR: THESE PACKAGES DO NOT MATCH THE HASHES": "could not be installed (see ",
}
"""What pip says where it cannot install torch, and what the set-up says of it."""
WHOLE = (".venv/q2q/kept", "build/kept", "install/kept")


@pytest.fixture
def bare(checkout: Checkout) -> Checkout:
    """Return a checkout whose compilers are found and whose pip fails for lack of a network."""
    checkout.env.update(CC="true", CXX="true")
    set_pip(checkout, NO_NETWORK)
    return checkout


def set_pip(checkout: Checkout, script: str, colcon: str = BUILT) -> None:
    """Let pip and colcon be lines of shell."""
    tool = PYTHON.format(pip=script, colcon=colcon, python=BASE_PYTHON, root=checkout.root)
    checkout.tool("python3", tool)


def set_pip_of_venv(checkout: Checkout, script: str, colcon: str = BUILT) -> None:
    """Let pip and colcon of a .venv that is there be lines of shell."""
    set_pip(checkout, script, colcon)
    (checkout.bin / "python3").rename(checkout.root / ".venv/bin/python")


def add_set_up(checkout: Checkout) -> None:
    """Write a complete set-up on another Python."""
    for name in WHOLE:
        (checkout.root / name).parent.mkdir(parents=True)
        (checkout.root / name).touch()
    (checkout.root / ".venv/q2q/origin").write_text("wheels of another Python\n")
    (checkout.root / ".venv/q2q/venv").write_text("of its requirements\n")


def kept(checkout: Checkout) -> list[str]:
    """Return the files of `add_set_up` that are there, and any that is set aside."""
    found = (path.relative_to(checkout.root) for path in checkout.root.rglob("kept"))
    return sorted(map(str, (*found, *checkout.root.glob(".replaced"))))


def test_a_set_up_is_kept_where_its_successor_cannot_be_made(bare: Checkout) -> None:
    add_set_up(bare)
    done = bare.setup()
    assert "no network" in done.stderr
    assert kept(bare) == [*WHOLE]


def test_a_set_up_is_kept_also_where_its_successor_was_killed_before(bare: Checkout) -> None:
    add_set_up(bare)
    set_pip(bare, KILLED)
    bare.setup()
    assert not (bare.root / ".venv/q2q/venv").exists()
    set_pip(bare, NO_NETWORK)
    bare.setup()
    assert kept(bare) == [*WHOLE]


@pytest.mark.parametrize("move", ["/q2q/install ", "/.replaced/install "])
def test_a_set_up_is_kept_also_where_its_moving_aside_or_back_was_killed(bare: Checkout, move: str) -> None:
    """What had not been moved by then was removed."""
    add_set_up(bare)
    bare.tool("mv", f'case "$*" in *"{move}"*) kill -KILL $PPID ;; *) exec /bin/mv "$@" ;; esac')
    bare.setup()
    assert (bare.root / ".replaced").exists()
    (bare.bin / "mv").unlink()
    bare.setup()
    assert kept(bare) == [*WHOLE]


@pytest.mark.parametrize(
    ("tool", "at"), [("mv", "/q2q/.venv "), ("mv", "/q2q/install "), ("mkdir", ".replaced")]
)
def test_a_set_up_is_kept_where_it_cannot_be_moved_aside(bare: Checkout, tool: str, at: str) -> None:
    """It was removed, to make place for its successor."""
    add_set_up(bare)
    set_pip(bare, "exit 0")
    bare.tool(tool, f'case "$*" in *"{at}"*) exit 1 ;; *) exec /bin/{tool} "$@" ;; esac')
    refused = bare.setup()
    assert refused.returncode != 0
    assert "cannot be m" in refused.stdout + refused.stderr
    assert kept(bare) == [*WHOLE]


@pytest.mark.parametrize("ends", [("exit 1",), (KILLED_BUILD, "exit 1")])
def test_a_set_up_is_kept_where_its_successor_cannot_be_built(bare: Checkout, ends: tuple[str, ...]) -> None:
    """Also where the build of the successor was killed before: its packages are complete then."""
    add_set_up(bare)
    set_pip(bare, "exit 0", ends[0])
    bare.shell("echo $$ >pid && exec scripts/setup")
    for colcon in ends[1:]:
        assert (bare.root / ".venv/q2q/venv").exists()
        assert not (bare.root / ".venv/q2q/kept").exists()
        set_pip_of_venv(bare, "exit 0", colcon)
        bare.setup()
    assert kept(bare) == [*WHOLE]


def test_a_set_up_goes_when_its_successor_is_complete(bare: Checkout) -> None:
    add_set_up(bare)
    set_pip(bare, "exit 0")
    assert bare.setup().returncode == 0
    assert kept(bare) == []


@pytest.mark.parametrize("name", ["run.txt", "dev.txt"])
def test_an_update_that_was_killed_is_made_also_when_its_files_are_as_before(
    bare: Checkout, name: str
) -> None:
    """What pip had removed by then was missing, silently."""
    requirements = bare.root / "requirements" / name
    before = requirements.read_text()
    set_pip(bare, "exit 0")
    bare.setup("--dev")
    asked = bare.root / "asked"
    for text, ending in ((before + "another\n", KILLED), (before, "exit 0")):
        asked.unlink(missing_ok=True)
        requirements.write_text(text)
        set_pip_of_venv(bare, f'echo "$*" >>"{asked}"; {ending}')
        bare.setup("--dev")
        assert name in asked.read_text()


@pytest.mark.parametrize("name", ["run.txt", "dev.txt"])
def test_without_a_network_an_update_leaves_the_set_up_of_the_files_before(bare: Checkout, name: str) -> None:
    """It was lost, also after a return to them, until there was a network again."""
    requirements = bare.root / "requirements" / name
    before = requirements.read_text()
    set_pip(bare, "exit 0")
    bare.setup("--dev")
    set_pip_of_venv(bare, NO_NETWORK)
    requirements.write_text(before + "another\n")
    assert "setup: error: no network" in bare.setup("--dev").stderr
    requirements.write_text(before)
    again = bare.setup("--dev")
    assert (again.returncode, again.stderr) == (0, "")


def test_an_update_that_filled_the_disk_after_a_retry_is_made_when_its_files_are_as_before(
    bare: Checkout,
) -> None:
    """Retries are reported as a missing network is, and pip may have removed packages by then."""
    requirements = bare.root / "requirements/run.txt"
    before = requirements.read_text()
    set_pip(bare, "exit 0")
    bare.setup()
    full = RETRY.format("ReadTimeoutError(Read timed out.)") + "ERROR: [Errno 28] No space left on device"
    set_pip_of_venv(bare, without("run.txt", full))
    requirements.write_text(before + "another\n")
    assert "setup: error: the disk is full" in bare.setup().stderr
    requirements.write_text(before)
    assert "step 2 of 3" in bare.setup().stderr


def test_what_is_built_of_a_package_goes_with_its_sources(bare: Checkout) -> None:
    """`ros2 pkg list` had it, and `ros2 run` started what no longer was there."""
    marks = "install/$p/share/colcon-core/packages"
    make = f"mkdir -p build/numba install/own build/$p {marks} && touch {marks}/$p"
    colcon = f"""case "$*" in
      *" list "*) cat listed ;;
      *) {BUILT}; for p in $(cat listed); do {make}; done ;;
    esac"""
    set_pip(bare, "exit 0", colcon)
    left = []
    for listed in ("toy q2q_sim", "q2q_sim", ""):
        (bare.root / "listed").write_text("\n".join([*listed.split(), ""]))
        (bare.root / ".venv/q2q/build").unlink(missing_ok=True)
        assert bare.setup().returncode == 0
        left.append({f"{one.parent.name}/{one.name}" for one in bare.root.glob("[bi]*/*/")})
    both = {"build/numba", "install/own", "build/q2q_sim", "install/q2q_sim"}
    assert left == [both | {"build/toy", "install/toy"}, both, both]


def test_machine_code_goes_where_nodes_look_for_it_once_for_each_folder(bare: Checkout) -> None:
    """A folder that the user chose stayed empty: nodes compiled in flight. One made another's stale."""
    set_pip(bare, "exit 0")
    own, chosen, other = bare.root / "build/numba", bare.root.parent / "chosen", bare.root.parent / "other"
    (other / ".venv/q2q").mkdir(parents=True)
    for value in ("", str(chosen), str(chosen), f"{other}/build/numba", "chosen"):
        done = bare.shell("scripts/setup", NUMBA_CACHE_DIR=value)
        assert done.returncode == 0, done.stderr
    relative = bare.root / "chosen"
    assert (bare.root / "compiled").read_text().splitlines() == [str(own), str(chosen), str(relative)]
    assert all(folder.is_dir() for folder in (own, chosen, relative))


def without(requirements: str, lines: str) -> str:
    """Return a pip that fails with these lines where it is asked for some requirements."""
    return f"""case "$*" in *{requirements}*) printf '%s\\n' "{lines}"; exit 1 ;; esac"""


def test_cflib_is_asked_for_again_where_it_could_not_be_fetched(bare: Checkout) -> None:
    """A stalled or reset connection, a server's error and a full disk made it unfit, for good."""
    stamp = bare.root / ".venv/q2q/dev"
    set_pip(bare, "exit 0")
    bare.setup()
    for lines, told in FAILURES.items():
        set_pip_of_venv(bare, without("radio.txt", lines))
        done = bare.setup("--dev")
        assert done.returncode == 1
        assert f"setup: error: {told}" in done.stderr
        assert stamp.read_text() == "incomplete\n"


@pytest.mark.parametrize(("lines", "why"), [*((one, UNFITTING) for one in UNFIT), (NO_VERSIONS, ABSENT)])
def test_cflib_is_left_out_where_it_does_not_fit_or_is_absent(bare: Checkout, lines: str, why: str) -> None:
    stamp = bare.root / ".venv/q2q/dev"
    set_pip(bare, without("radio.txt", lines))
    done = bare.setup("--dev")
    assert done.returncode == 0
    assert f"cflib {why}" in done.stderr
    assert stamp.read_text() != "incomplete\n"


def test_a_set_up_without_torch_says_why(bare: Checkout) -> None:
    """It said that no CPU build can be reached, whatever had failed."""
    set_pip(bare, "exit 0")
    bare.setup()
    for lines, why in WITHOUT_TORCH.items():
        set_pip_of_venv(bare, without("train.txt", lines))
        done = bare.setup("--dev")
        assert done.returncode == 0
        assert f"setup: torch {why}" in done.stderr
        (bare.root / ".venv/q2q/dev").unlink()
    set_pip_of_venv(bare, without("train.txt", "ERROR: [Errno 28] No space left on device"))
    assert "setup: error: the disk is full" in bare.setup("--dev").stderr
