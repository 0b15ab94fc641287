"""scripts/setup: what its steps leave where one fails; a shell script plays Python, its pip and colcon."""

import pytest
from fresh_checkout import BASE_PYTHON, Checkout

PYTHON = """for last; do :; done
case "$*" in
  *"-m venv"*) mkdir -p "$last/bin" && cp "$0" "$last/bin/python" ;;
  *"-m pip"*) {pip} ;;
  *"-m colcon"*) mkdir install && touch install/local_setup.bash ;;
  *compile_kernels*) echo "$NUMBA_CACHE_DIR" >>"{root}/compiled" ;;
  *sys.executable*) echo "$0" ;;
  *rclpy*) exit 1 ;;
  *repair_cmake_exports*) ;;
  *) exec "{python}" "$@" ;;
esac"""
NO_NETWORK = "echo Network is unreachable; exit 1"
WHOLE = (".venv/q2q/kept", "build/kept", "install/kept")


@pytest.fixture
def bare(checkout: Checkout) -> Checkout:
    """Return a checkout whose compilers are found and whose pip fails for lack of a network."""
    checkout.env.update(CC="true", CXX="true")
    set_pip(checkout, NO_NETWORK)
    return checkout


def set_pip(checkout: Checkout, script: str) -> None:
    """Let pip be a line of shell."""
    checkout.tool("python3", PYTHON.format(pip=script, python=BASE_PYTHON, root=checkout.root))


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
    set_pip(bare, "kill -KILL $PPID")
    bare.setup()
    assert not (bare.root / ".venv/q2q/venv").exists()
    set_pip(bare, NO_NETWORK)
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
    python = bare.root / ".venv/bin/python"
    for text, ending in ((before + "another\n", "kill -KILL $PPID"), (before, "exit 0")):
        asked.unlink(missing_ok=True)
        requirements.write_text(text)
        set_pip(bare, f'echo "$*" >>"{asked}"; {ending}')
        (bare.bin / "python3").rename(python)
        bare.setup("--dev")
        assert name in asked.read_text()


def test_machine_code_goes_where_nodes_look_for_it(bare: Checkout) -> None:
    """A folder that the user chose stayed empty: nodes compiled in flight."""
    set_pip(bare, "exit 0")
    own, chosen, other = bare.root / "build/numba", bare.root.parent / "chosen", bare.root.parent / "other"
    (other / ".venv/q2q").mkdir(parents=True)
    cases = (("", own), (str(chosen), chosen), (str(chosen), chosen), (f"{other}/build/numba", own))
    for value, _ in cases:
        done = bare.shell("scripts/setup", NUMBA_CACHE_DIR=value)
        assert done.returncode == 0, done.stderr
    assert (bare.root / "compiled").read_text().splitlines() == [str(own), str(chosen), str(own)]
    assert chosen.is_dir()


def test_cflib_is_left_out_where_it_does_not_fit_and_asked_for_again_after_a_network_failure(
    bare: Checkout,
) -> None:
    stamp = bare.root / ".venv/q2q/dev"
    set_pip(bare, f'case "$*" in *radio.txt*) {NO_NETWORK} ;; esac')
    done = bare.setup("--dev")
    assert done.returncode == 1
    assert "setup: error: no network" in done.stderr
    assert stamp.read_text() == "incomplete\n"

    set_pip(bare, 'case "$*" in *radio.txt*) echo ResolutionImpossible; exit 1 ;; esac')
    (bare.bin / "python3").rename(bare.root / ".venv/bin/python")
    done = bare.setup("--dev")
    assert done.returncode == 0
    assert "cflib does not go with this Python's packages" in done.stderr
    assert stamp.read_text() != "incomplete\n"
