"""Sources of the firmware app: strict C without a heap, in the firmware's interface."""

import ctypes
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from native_apps import STACKED, library, needs_cc

from q2q_control.onboard.app_folder import CORE, write_app
from q2q_control.onboard.app_memory import LARGEST_BYTES, AppMemoryError, app_bytes, app_samples
from q2q_control.onboard.model_header import AppRates, UnsupportedModelError, model_header
from q2q_control.onboard.native_app import FLAGS
from q2q_model.downwash.jet import MEASURED_LAW, MOVING_LAW, PAPER_LAW, Jet
from q2q_model.downwash.no_interaction import NoInteraction
from q2q_model.model_files.model_file import ModelFile
from q2q_model.vehicle.constants import CRAZYFLIE_2_0


@needs_cc
def test_the_core_compiles_strictly_and_calls_no_heap(tmp_path: Path) -> None:
    write_app(tmp_path, ModelFile(STACKED), CRAZYFLIE_2_0)
    strict = [*FLAGS, "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Wvla", "-c"]
    subprocess.run(["cc", *strict, *CORE], cwd=tmp_path, check=True)
    listed = subprocess.run(["nm", "-u", *(name[:-1] + "o" for name in CORE)], cwd=tmp_path, check=True,
                            capture_output=True, text=True).stdout  # fmt: skip
    called = {line.split()[1] for line in listed.splitlines() if line.startswith(" ")}
    own = {name for name in called if name.startswith("q2q_")}
    arithmetic = {"expf", "sqrtf", "roundf", "memset", "memcpy"}
    assert called - own <= arithmetic | {"_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"}


@needs_cc
def test_the_glue_uses_the_firmware_as_documented_and_every_source_is_in_the_build(tmp_path: Path) -> None:
    app, interface = tmp_path / "app", tmp_path / "firmware"
    write_app(app, ModelFile(MEASURED_LAW), CRAZYFLIE_2_0)
    interface.mkdir()
    glue = (app / "app_main.c").read_text(encoding="utf-8")
    for name in re.findall(r'#include "(.*)"', glue):
        if not (app / name).exists():
            (interface / name).write_text('#include "firmware.h"\n', encoding="utf-8")
    (interface / "firmware.h").write_bytes((Path(__file__).parent / "cortex_m4" / "firmware.h").read_bytes())
    checks = ["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-Wno-unused-const-variable", "-fsyntax-only"]
    subprocess.run(["cc", *checks, f"-I{interface}", "app_main.c"], cwd=app, check=True)
    built = set(re.findall(r"(\w+)\.o", (app / "Kbuild").read_text(encoding="utf-8")))
    assert built == {path.stem for path in app.glob("*.c")} == {"app_main", *(name[:-2] for name in CORE)}


@needs_cc
@pytest.mark.parametrize("jet", [PAPER_LAW, MEASURED_LAW, MOVING_LAW, STACKED])
def test_the_memory_of_an_app_is_the_size_of_its_state(jet: Jet) -> None:
    state = ctypes.c_uint32.in_dll(library(jet, AppRates()), "q2q_app_bytes").value
    assert state == app_bytes(app_samples(jet, 50.0, 5), 5)


@pytest.mark.parametrize("speed", [0.68, 0.05, 5e-324])
def test_an_app_that_does_not_fit_into_a_vehicle_is_refused(speed: float, tmp_path: Path) -> None:
    """Up to 12 MB were written without a word."""
    slow = replace(MOVING_LAW, travel_speed=speed)
    with pytest.raises(AppMemoryError, match=r"kB of RAM; .* leaves 27 kB.* make its range of 1.5 m smaller"):
        write_app(tmp_path / "app", ModelFile(slow), CRAZYFLIE_2_0)
    assert not (tmp_path / "app").exists()
    fits = replace(MOVING_LAW, travel_speed=0.69)
    assert app_bytes(app_samples(fits, 50.0, 5), 5) <= LARGEST_BYTES


def test_models_that_are_no_jet_and_folders_that_are_not_empty_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UnsupportedModelError, match="not a NoInteraction"):
        model_header(ModelFile(NoInteraction()), CRAZYFLIE_2_0)
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(FileExistsError, match="not an empty folder"):
        write_app(tmp_path, ModelFile(MEASURED_LAW), CRAZYFLIE_2_0)
    assert [one.name for one in tmp_path.iterdir()] == ["mine.txt"]
