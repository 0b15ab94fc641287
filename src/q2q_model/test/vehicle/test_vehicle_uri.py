"""URIs that reach the same vehicle have one canonical spelling, others have others."""

import socket
from itertools import combinations

import pytest

from q2q_model.vehicle import vehicle_uri
from q2q_model.vehicle.vehicle_uri import canonical_uri, resolved_uri

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


def test_a_host_is_looked_up_only_where_its_address_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading a file of vehicles blocked for seconds where no name server answered."""
    asked = []

    def look_up(host: str) -> str:
        asked.append(host)
        if host == "nobody.lan":
            raise socket.gaierror
        return "192.168.4.1"

    monkeypatch.setattr(vehicle_uri, "gethostbyname", look_up)
    assert canonical_uri("udp://Drone.lan:19850/?x=1") == "udp://drone.lan:19850"
    assert not asked
    assert resolved_uri("udp://Drone.lan:19850") == "udp://192.168.4.1:19850"
    assert resolved_uri("udp://nobody.lan:19850") == "udp://nobody.lan:19850"
    assert asked == ["drone.lan", "nobody.lan"]
    for uri in ("udp://host:nought", "udp://[", "udp://", "radio://0/80", "usb://0"):
        assert resolved_uri(uri) == canonical_uri(uri)
