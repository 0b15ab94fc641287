"""The chain of a tick stays on one core, and two flights keep their chains apart."""

from q2q_sim.tools.cores import cores_of

CHAIN = ("simulator", "mocap_filter", "interference", "pid", "mpc")


def test_the_chain_has_one_core_and_the_rest_have_the_others() -> None:
    assert {cores_of(name, 20, {0, 1, 2, 3}) for name in CHAIN} == {frozenset({0})}
    assert cores_of("bag_record", 20, {0, 1, 2, 3}) == {1, 2, 3}


def test_neighbouring_domains_chain_on_different_cores() -> None:
    assert cores_of("pid", 20, {3, 5}) == {3}
    assert cores_of("pid", 21, {3, 5}) == {5}


def test_on_one_core_all_share_it() -> None:
    assert cores_of("pid", 20, {7}) == cores_of("trajectory", 20, {7}) == {7}
