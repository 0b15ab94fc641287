"""scripts/env.sh: the shell that it makes of shells of all kinds."""

from fresh_checkout import Checkout


def test_a_folder_on_cdpath_is_not_taken_for_the_checkout(checkout: Checkout) -> None:
    (checkout.root.parent / "other/scripts").mkdir(parents=True)
    for cdpath in ("../other", ".:../other"):
        done = checkout.shell("source scripts/env.sh", CDPATH=cdpath, CC="no-such-compiler")
        assert "setup: error: no C compiler" in done.stderr
