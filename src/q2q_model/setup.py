"""ament_python build of q2q_model."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "q2q_model"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={PACKAGE: ["py.typed", "node/loopback.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml") + glob("config/*.q2q")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="q2q developers",
    maintainer_email="maintainer@q2q.invalid",
    description="Signals, vehicles, mocap filter, interaction models, identification",
    license="MIT",
    entry_points={
        "console_scripts": [
            "mocap_filter = q2q_model.commands.model_nodes:mocap_filter",
            "interference = q2q_model.commands.model_nodes:interference",
            "identify = q2q_model.commands.identify:main",
            "evaluate = q2q_model.commands.evaluate:main",
            "scale_model = q2q_model.commands.scale_model:main",
        ],
    },
)
