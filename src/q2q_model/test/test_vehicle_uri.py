"""URIs that reach the same vehicle have one canonical spelling, others have others."""

from itertools import combinations

import pytest

from q2q_model.vehicle.vehicle_uri import canonical_uri

SAME = [
    (
        "radio://*/80/2M/E7E7E7E7E7",
        "radio://0/80/2M/e7e7e7e7e7",
        "radio://1/80/2M/E7E7E7E7E7",
        "radio://0/80/2M/E7E7E7E7E7?safelink=0&rate_limit=100",
        "radio://0/80/2M/",
        "radio://0/80/2m",
        "radio://0/80",
    ),
    ("radio://*/80/2M/00000000E7", "radio://0/80/2M/E7"),
    ("radio://*/80/1M/E7E7E7E7E7", "radio://0/80/1M"),
    ("radio://*/81/2M/E7E7E7E7E7", "radio://0/81"),
    ("udp://127.0.0.1:19850", "udp://localhost:19850", "udp://127.0.0.1:19850/", "UDP://LOCALHOST:19850"),
    ("udp://127.0.0.1:19851", "udp://localhost:19851"),
    ("usb://0", "USB://0"),
    ("radio://0", "radio://0"),
]


@pytest.mark.parametrize("same", SAME)
def test_all_spellings_of_a_vehicles_uri_are_one(same: tuple[str, ...]) -> None:
    assert {canonical_uri(one) for one in same} == {same[0]}


def test_other_vehicles_have_other_uris() -> None:
    assert all(canonical_uri(a[0]) != canonical_uri(b[0]) for a, b in combinations(SAME, 2))
