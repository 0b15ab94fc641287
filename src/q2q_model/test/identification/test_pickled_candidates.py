"""Candidates are passed between processes, as results of `identify` in a sweep are."""

import pickle

from made_flights import LOOP, Pass, record_of

from q2q_model.identification.selection.candidate import NOTHING
from q2q_model.identification.selection.identification_data import IdentificationData
from q2q_model.identification.selection.jet_candidates import jet_candidates
from q2q_model.identification.selection.network_candidates import network_candidates


def test_every_candidate_can_be_pickled() -> None:
    data = [IdentificationData((record_of(Pass(seconds=20.0)),), ())]
    made = [NOTHING, *jet_candidates(data, LOOP), *network_candidates(data, LOOP)]
    copies = pickle.loads(pickle.dumps(made))  # noqa: S301 - own bytes
    assert [one.name for one in copies] == [one.name for one in made]
    assert copies[0].fit(data) == NOTHING.fit(data)
